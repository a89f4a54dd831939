//! Rotations, as unit quaternions.

use glam::{DMat3, DQuat, DVec3};
use kinora_scene::{Binary, Orient, Unary};

use super::Call;
use super::math::{crossed, norm, try_arg};
use crate::eval::graph::{Graph, Scalar};
use crate::value::Value;

/// `a * b`: b is done first.
pub fn turn_after(graph: &mut Graph, a: &[Scalar; 4], b: &[Scalar; 4]) -> [Scalar; 4] {
    let [ax, ay, az, aw] = *a;
    let [bx, by, bz, bw] = *b;
    let minus = |graph: &mut Graph, value| graph.unary(Unary::Neg, value);
    let (nx, ny, nz) = (minus(graph, ax), minus(graph, ay), minus(graph, az));
    [
        graph.dot(&[aw, ax, ay, nz], &[bx, bw, bz, by]),
        graph.dot(&[aw, nx, ay, az], &[by, bz, bw, bx]),
        graph.dot(&[aw, ax, ny, az], &[bz, by, bx, bw]),
        graph.dot(&[aw, nx, ny, nz], &[bw, bx, by, bz]),
    ]
}

/// A vector turned by a rotation: v + 2 (w (u × v) + u × (u × v)).
pub fn turned(graph: &mut Graph, q: &[Scalar; 4], v: [Scalar; 3]) -> [Scalar; 3] {
    let u = [q[0], q[1], q[2]];
    let once = crossed(graph, u, v);
    let twice = crossed(graph, u, once);
    [0, 1, 2].map(|i| {
        let part = graph.mul(q[3], once[i]);
        let sum = graph.add(part, twice[i]);
        let double = graph.mul(sum, 2.0.into());
        graph.add(v[i], double)
    })
}

/// The same rotation, of its two signs the one that is nearer to `other`, and that sign.
pub fn near(graph: &mut Graph, q: &[Scalar; 4], other: &[Scalar; 4]) -> ([Scalar; 4], Scalar) {
    let dot = graph.dot(q, other);
    let away = graph.binary(Binary::Less, dot, 0.0.into());
    let sign = graph.select(away, (-1.0).into(), 1.0.into());
    (q.map(|part| graph.mul(part, sign)), sign)
}

/// Made a unit quaternion.
pub fn unit(graph: &mut Graph, q: &[Scalar; 4]) -> [Scalar; 4] {
    let length = norm(graph, q);
    q.map(|part| graph.div(part, length))
}

/// `a`, or `b` where `divisor` is next to 0.
fn safe(graph: &mut Graph, divisor: Scalar, a: Scalar, b: Scalar) -> Scalar {
    let large = graph.binary(Binary::Less, 1e-12.into(), divisor);
    graph.select(large, a, b)
}

/// Along the arc between two unit quaternions as they are, at constant speed.
pub fn slerp(graph: &mut Graph, from: &[Scalar; 4], to: &[Scalar; 4], t: Scalar) -> [Scalar; 4] {
    let chord = [0, 1, 2, 3].map(|i| graph.sub(from[i], to[i]));
    let diagonal = [0, 1, 2, 3].map(|i| graph.add(from[i], to[i]));
    let (chord, diagonal) = (norm(graph, &chord), norm(graph, &diagonal));
    let half = graph.binary(Binary::Atan2, chord, diagonal);
    let angle = graph.mul(half, 2.0.into());
    let left = graph.sub(1.0.into(), t);
    let [a, b] = [left, t].map(|share| {
        let part = graph.mul(share, angle);
        let sine = graph.unary(Unary::Sin, part);
        safe(graph, angle, sine, share)
    });
    let sum = [0, 1, 2, 3].map(|i| graph.dot(&[from[i], to[i]], &[a, b]));
    unit(graph, &sum)
}

/// Half the angle times the axis of a unit quaternion.
fn log(graph: &mut Graph, q: &[Scalar; 4]) -> [Scalar; 3] {
    let axis = [q[0], q[1], q[2]];
    let sine = norm(graph, &axis);
    let angle = graph.binary(Binary::Atan2, sine, q[3]);
    let factor = graph.div(angle, sine);
    let factor = safe(graph, sine, factor, 1.0.into());
    axis.map(|part| graph.mul(part, factor))
}

/// The inverse of [`log`].
fn exp(graph: &mut Graph, v: [Scalar; 3]) -> [Scalar; 4] {
    let angle = norm(graph, &v);
    let sine = graph.unary(Unary::Sin, angle);
    let factor = graph.div(sine, angle);
    let factor = safe(graph, angle, factor, 1.0.into());
    let [x, y, z] = v.map(|part| graph.mul(part, factor));
    [x, y, z, graph.unary(Unary::Cos, angle)]
}

/// Shoemake's squad from `from` to `to`, between its neighbours, each of the sign that is nearer to the one before; as the
/// animator has it for keys that stand still.
pub fn squad(
    graph: &mut Graph,
    before: Option<[Scalar; 4]>,
    from: [Scalar; 4],
    to: [Scalar; 4],
    after: Option<[Scalar; 4]>,
    t: Scalar,
) -> [Scalar; 4] {
    let mut control = |beyond: Option<[Scalar; 4]>, here: [Scalar; 4], other: [Scalar; 4]| {
        let Some(beyond) = beyond else { return here };
        let [x, y, z] = [here[0], here[1], here[2]].map(|part| graph.unary(Unary::Neg, part));
        let back = [x, y, z, here[3]];
        let [a, b] = [beyond, other].map(|key| {
            let relative = turn_after(graph, &back, &key);
            log(graph, &relative)
        });
        let bend = [0, 1, 2].map(|i| {
            let sum = graph.add(a[i], b[i]);
            graph.mul(sum, (-0.25).into())
        });
        let bent = exp(graph, bend);
        turn_after(graph, &here, &bent)
    };
    let (out, into) = (control(before, from, to), control(after, to, from));
    let (outer, inner) = (slerp(graph, &from, &to, t), slerp(graph, &out, &into, t));
    let left = graph.sub(1.0.into(), t);
    let product = graph.mul(t, left);
    let share = graph.mul(product, 2.0.into());
    slerp(graph, &outer, &inner, share)
}

/// The rotation, if it does not move.
pub fn quaternion(q: &[Scalar; 4]) -> Option<DQuat> {
    let [x, y, z, w] = q;
    Some(DQuat::from_xyzw(x.constant()?, y.constant()?, z.constant()?, w.constant()?))
}

fn about(graph: &mut Graph, axis: [Scalar; 3], angle: Scalar) -> [Scalar; 4] {
    let half = graph.mul(angle, 0.5.into());
    let sin = graph.unary(Unary::Sin, half);
    let [x, y, z] = axis.map(|part| graph.mul(part, sin));
    [x, y, z, graph.unary(Unary::Cos, half)]
}

fn about_axis(call: &mut Call<'_>, argument: usize, axis: usize) -> Option<[Scalar; 4]> {
    let angle = call.true_angle(argument)?;
    let mut direction = [Scalar::Const(0.0); 3];
    direction[axis] = 1.0.into();
    Some(about(call.graph, direction, angle))
}

pub(super) fn rotate_x(call: &mut Call<'_>) -> Value {
    about_axis(call, 0, 0).map_or(Value::Error, Value::Turn)
}

pub(super) fn rotate_y(call: &mut Call<'_>) -> Value {
    about_axis(call, 0, 1).map_or(Value::Error, Value::Turn)
}

pub(super) fn rotate_z(call: &mut Call<'_>) -> Value {
    about_axis(call, 0, 2).map_or(Value::Error, Value::Turn)
}

pub(super) fn axis_angle(call: &mut Call<'_>) -> Value {
    let (axis, _) = try_arg!(call.vec3(0));
    let angle = try_arg!(call.true_angle(1));
    let length = norm(call.graph, &axis);
    if length == Scalar::Const(0.0) {
        return call.no_direction(0, "axis has zero length");
    }
    let axis = axis.map(|part| call.graph.div(part, length));
    Value::Turn(about(call.graph, axis, angle))
}

pub(super) fn euler(call: &mut Call<'_>) -> Value {
    let x = try_arg!(about_axis(call, 0, 0));
    let y = try_arg!(about_axis(call, 1, 1));
    let z = try_arg!(about_axis(call, 2, 2));
    let yx = turn_after(call.graph, &y, &x);
    Value::Turn(turn_after(call.graph, &z, &yx))
}

pub(super) fn face_towards(call: &mut Call<'_>) -> Value {
    let (direction, _) = try_arg!(call.vec3(0));
    orient(call, Orient::FaceTowards, direction, 0, 1)
}

pub(super) fn look_at(call: &mut Call<'_>) -> Value {
    let ((from, _), (to, _)) = (try_arg!(call.vec3(0)), try_arg!(call.vec3(1)));
    let direction = [0, 1, 2].map(|i| call.graph.sub(to[i], from[i]));
    orient(call, Orient::LookAlong, direction, 1, 2)
}

fn orient(call: &mut Call<'_>, how: Orient, direction: [Scalar; 3], at: usize, up_at: usize) -> Value {
    let up = match call.value(up_at) {
        Some(_) => try_arg!(call.vec3(up_at)).0,
        None => [0.0.into(), 1.0.into(), 0.0.into()],
    };
    let known = |three: [Scalar; 3]| -> Option<DVec3> {
        Some(DVec3::new(three[0].constant()?, three[1].constant()?, three[2].constant()?))
    };
    let (Some(d), Some(u)) = (known(direction), known(up)) else {
        return Value::Turn(call.graph.orient(how, direction, up));
    };
    let Some(d) = d.try_normalize() else {
        return call.no_direction(at, "direction has zero length");
    };
    let z = if how == Orient::LookAlong { -d } else { d };
    let Some(x) = u.try_normalize().map(|u| u.cross(z)).filter(|x| x.length() > 1e-9).map(DVec3::normalize) else {
        return call.no_direction(up_at, "`up` is parallel to the view");
    };
    let q = DQuat::from_mat3(&DMat3::from_cols(x, z.cross(x), z));
    Value::Turn(q.to_array().map(Scalar::Const))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_agree_with_glam() {
        let mut graph = Graph::default();
        let a = DQuat::from_rotation_x(0.3) * DQuat::from_rotation_y(-1.1);
        let b = DQuat::from_rotation_z(2.0) * DQuat::from_rotation_x(0.7);
        let v = DVec3::new(0.3, -2.0, 5.0);
        let scalars = |q: DQuat| q.to_array().map(Scalar::Const);
        let product = quaternion(&turn_after(&mut graph, &scalars(a), &scalars(b))).unwrap();
        assert!((product - a * b).length() < 1e-14, "{product} {}", a * b);
        let moved = turned(&mut graph, &scalars(a), v.to_array().map(Scalar::Const));
        let moved = DVec3::from_array(moved.map(|part| part.constant().unwrap()));
        assert!((moved - a * v).length() < 1e-14);
    }
}
