// Disks, and shapes that curve as no sphere does: exact, each in a space of its own that the shape's transform leads to,
// about the y axis. Every hit is a root of the shape itself, and what is closed is met as a whole: its ends and its side
// leave no gap between them.

/// `Primitive::index.z`: the unit disk y = 0, which faces +y.
const OTHER_DISK: u32 = 0u;
/// Radius 1, |y| <= 1; a tube has no ends.
const OTHER_CYLINDER: u32 = 1u;
const OTHER_TUBE: u32 = 2u;
/// Its tip is the origin, its base y = −1 has radius 1; a funnel has no base.
const OTHER_CONE: u32 = 3u;
const OTHER_FUNNEL: u32 = 4u;
/// All points 1 from the segment |y| <= `Primitive::x.x` of the axis.
const OTHER_CAPSULE: u32 = 5u;
/// All points `Primitive::x.x` from the unit circle about the axis; where that is over 1, those outside alone.
const OTHER_TORUS: u32 = 6u;
/// No shape but a copy of a part of the scene, which lies in its shape's own space: the walks go into it.
const OTHER_INSTANCE: u32 = 7u;

/// `Hit::uv.x` of a cylinder or a cone: which part was hit. The side is 0.
const PART_TOP: f32 = 1.0;
const PART_BOTTOM: f32 = -1.0;

/// The part of a line that lies in something convex, none if near > far, and the parts of it where it enters and leaves.
struct Span {
    near: f32,
    far: f32,
    near_part: f32,
    far_part: f32,
}

fn no_span() -> Span {
    return Span(FAR, -FAR, 0.0, 0.0);
}

/// Slower than this along an axis, a line stays where it is.
const STILL: f32 = 1e-18;

// Where f + t v lies between 1 below and 1 above 0.
fn slab_span(f: f32, v: f32) -> Span {
    if abs(v) < STILL {
        if abs(f) > 1.0 {
            return no_span();
        }
        return Span(-FAR, FAR, 0.0, 0.0);
    }
    let below = (-1.0 - f) / v;
    let above = (1.0 - f) / v;
    if v > 0.0 {
        return Span(below, above, PART_BOTTOM, PART_TOP);
    }
    return Span(above, below, PART_TOP, PART_BOTTOM);
}

// Where f + t v lies in the unit ball (of which a circle is one with y = 0): the robust quadratic of Haines et al., Ray
// Tracing Gems ch. 7.
fn ball_span(f: vec3<f32>, v: vec3<f32>) -> Span {
    let a = dot(v, v);
    if a < STILL * STILL {
        if dot(f, f) > 1.0 {
            return no_span();
        }
        return Span(-FAR, FAR, 0.0, 0.0);
    }
    let b = -dot(f, v);
    let nearest = f + (b / a) * v;
    let discriminant = 1.0 - dot(nearest, nearest);
    if discriminant < 0.0 {
        return no_span();
    }
    let root = sqrt(a * discriminant);
    let q = b + select(root, -root, b < 0.0);
    if q == 0.0 {
        return no_span();
    }
    let first = (dot(f, f) - 1.0) / q;
    let second = q / a;
    return Span(min(first, second), max(first, second), 0.0, 0.0);
}

fn span_both(a: Span, b: Span) -> Span {
    var both = a;
    if b.near > a.near {
        both.near = b.near;
        both.near_part = b.near_part;
    }
    if b.far < a.far {
        both.far = b.far;
        both.far_part = b.far_part;
    }
    return both;
}

fn flatten(v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(v.x, 0.0, v.z);
}

fn cylinder_span(f: vec3<f32>, v: vec3<f32>) -> Span {
    return span_both(ball_span(flatten(f), flatten(v)), slab_span(f.y, v.y));
}

// A capsule is convex and made of convex parts, so the whole of them is from the first to the last.
fn capsule_span(f: vec3<f32>, v: vec3<f32>, half: f32) -> Span {
    let lower = ball_span(f + vec3<f32>(0.0, half, 0.0), v);
    let upper = ball_span(f - vec3<f32>(0.0, half, 0.0), v);
    var near = min(lower.near, upper.near);
    var far = max(lower.far, upper.far);
    if half > 0.0 {
        let side = span_both(ball_span(flatten(f), flatten(v)), slab_span(f.y / half, v.y / half));
        if side.near <= side.far {
            near = min(near, side.near);
            far = max(far, side.far);
        }
    }
    return Span(near, far, 0.0, 0.0);
}

/// Where a line meets the double cone x² + z² = y².
struct ConeRoots {
    real: bool,
    first: f32,
    second: f32,
    /// Whether the cone's inside is between them, or else outside of them.
    between: bool,
    /// The height half way between them.
    middle: f32,
}

fn cone_roots(f: vec3<f32>, v: vec3<f32>) -> ConeRoots {
    // From the point nearest to the tip on, so that what follows has no large numbers.
    let shift = -dot(f, v) / dot(v, v);
    let g = f + shift * v;
    let steepness = v.x * v.x + v.z * v.z - v.y * v.y;
    let a = select(steepness, 1e-20, abs(steepness) < 1e-20);
    let b = g.y * v.y - g.x * v.x - g.z * v.z;
    let c = g.x * g.x + g.z * g.z - g.y * g.y;
    // b² − ac by Lagrange's identity, as a product without cancellation.
    let up = length(vec2<f32>(g.x * v.y - g.y * v.x, g.z * v.y - g.y * v.z));
    let round = abs(g.x * v.z - g.z * v.x);
    let discriminant = (up - round) * (up + round);
    if discriminant < 0.0 && a > 0.0 {
        return ConeRoots(false, 0.0, 0.0, true, 0.0);
    }
    let root = sqrt(max(discriminant, 0.0));
    let q = b + select(root, -root, b < 0.0);
    var low = 0.0;
    var high = 0.0;
    if q != 0.0 {
        low = min(c / q, q / a);
        high = max(c / q, q / a);
    }
    return ConeRoots(true, shift + low, shift + high, a > 0.0, g.y + (b / a) * v.y);
}

fn cone_span(f: vec3<f32>, v: vec3<f32>) -> Span {
    let roots = cone_roots(f, v);
    if !roots.real || (roots.between && roots.middle > 0.0) {
        return no_span();
    }
    var span = Span(roots.first, roots.second, 0.0, 0.0);
    if !roots.between {
        // Of the two cones, the lower one: that which the line is in where it is far down.
        if v.y < 0.0 {
            span = Span(roots.second, FAR, 0.0, 0.0);
        } else {
            span = Span(-FAR, roots.first, 0.0, 0.0);
        }
    }
    if abs(v.y) < STILL {
        if f.y < -1.0 {
            return no_span();
        }
        return span;
    }
    let base = (-1.0 - f.y) / v.y;
    if v.y > 0.0 {
        return span_both(span, Span(base, FAR, PART_BOTTOM, 0.0));
    }
    return span_both(span, Span(-FAR, base, 0.0, PART_BOTTOM));
}

// The hit of what is closed and convex. A ray that starts on it meets it once more if it goes inside, else never.
fn span_hit(id: u32, span: Span, starts_on: bool) -> Hit {
    let enters = span.near > 0.0 && !starts_on;
    let t = select(span.far, span.near, enters);
    if span.near > span.far || !(t > 0.0) || (starts_on && span.near + span.far <= 0.0) {
        return no_hit();
    }
    return Hit(t, id, vec2<f32>(select(span.far_part, span.near_part, enters), 0.0), NONE);
}

// The hit of what is open, at the first of two places where it may be. A ray that starts on it leaves the nearer out.
fn open_hit(id: u32, first: f32, second: f32, first_there: bool, second_there: bool, starts_on: bool) -> Hit {
    let on_first = starts_on && abs(first) <= abs(second);
    let on_second = starts_on && !on_first;
    if first_there && first > 0.0 && !on_first {
        return Hit(first, id, vec2<f32>(0.0), NONE);
    }
    if second_there && second > 0.0 && !on_second {
        return Hit(second, id, vec2<f32>(0.0), NONE);
    }
    return no_hit();
}

fn tube_hit(id: u32, f: vec3<f32>, v: vec3<f32>, starts_on: bool) -> Hit {
    let side = ball_span(flatten(f), flatten(v));
    if side.near > side.far || side.far >= FAR {
        return no_hit();
    }
    let near_there = abs(f.y + side.near * v.y) <= 1.0;
    let far_there = abs(f.y + side.far * v.y) <= 1.0;
    return open_hit(id, side.near, side.far, near_there, far_there, starts_on);
}

fn funnel_hit(id: u32, f: vec3<f32>, v: vec3<f32>, starts_on: bool) -> Hit {
    let roots = cone_roots(f, v);
    if !roots.real {
        return no_hit();
    }
    let y_first = f.y + roots.first * v.y;
    let y_second = f.y + roots.second * v.y;
    let first_there = y_first >= -1.0 && y_first <= 0.0;
    let second_there = y_second >= -1.0 && y_second <= 0.0;
    return open_hit(id, roots.first, roots.second, first_there, second_there, starts_on);
}

fn disk_hit(id: u32, f: vec3<f32>, v: vec3<f32>, starts_on: bool) -> Hit {
    if starts_on || v.y == 0.0 {
        return no_hit();
    }
    let t = -f.y / v.y;
    let x = f.x + t * v.x;
    let z = f.z + t * v.z;
    if !(t > 0.0 && x * x + z * z <= 1.0) {
        return no_hit();
    }
    return Hit(t, id, vec2<f32>(0.0), NONE);
}

/// How far f + t v is off a torus: h = ((ρ − 1)² + y² − r²) / 2 with ρ = √(x² + z²), and dh/dt. This form, unlike that
/// of the quartic, loses nothing where the tube is thin.
fn torus_at(f: vec3<f32>, v: vec3<f32>, tube: f32, t: f32) -> vec2<f32> {
    let p = f + t * v;
    let rho = length(p.xz);
    let out = rho - 1.0;
    let slope = dot(p.xz, v.xz) / max(rho, 1e-20);
    let h = 0.5 * ((out - tube) * (out + tube) + p.y * p.y);
    return vec2<f32>(h, out * slope + p.y * v.y);
}

/// Newton steps towards one root. They double its digits, but for a ray that grazes the tube they halve its error.
const TORUS_STEPS: u32 = 32u;
/// Steps shorter than this, of the ring's radius, are lost in rounding.
const TORUS_STEP: f32 = 1e-7;
/// So near to where a ray starts on it, of the tube's radius, the sign of h says nothing.
const TORUS_NEAR: f32 = 1e-4;

// The root of h between `begin` and `end` that is nearest to `begin`; FAR if there is none. Between them h curves so that
// no step from there leads past it.
fn torus_root(f: vec3<f32>, v: vec3<f32>, tube: f32, begin: f32, end: f32) -> f32 {
    let ahead = end - begin;
    var t = begin;
    let sign = torus_at(f, v, tube, begin).x;
    for (var i = 0u; i < TORUS_STEPS; i++) {
        let h = torus_at(f, v, tube, t);
        if h.x == 0.0 || (h.x > 0.0) != (sign > 0.0) {
            return t;
        }
        let step = -h.x / select(h.y, 1e-20, abs(h.y) < 1e-20);
        // Turned back, or past the end.
        if step * ahead < 0.0 || abs(t + step - begin) > abs(ahead) {
            return FAR;
        }
        t += step;
        if abs(step) < TORUS_STEP {
            return t;
        }
    }
    return t;
}

// Along a line h'' = 1 − |v₊|² m² / ρ³, with v₊ the unit direction's part across the axis and m the line's least
// distance from the axis: h is convex, concave between two places that are known, and convex again. From an end of such
// a piece where its sign agrees with its curvature, Newton's method creeps up on the nearest root and passes none; from
// the other end it does so where the signs at the ends differ, and else there is no root.
fn torus_hit(id: u32, f: vec3<f32>, v: vec3<f32>, tube: f32, starts_on: bool) -> Hit {
    let speed = length(v);
    let w = v / speed;
    // In the ball and the slab around it, a little wider than it is.
    let around = 1.001 * (1.0 + tube);
    let ball = ball_span(f / around, w / around);
    let slab = slab_span(f.y / (1.001 * tube), w.y / (1.001 * tube));
    let inside = span_both(ball, slab);
    let begin = max(inside.near, 0.0);
    let end = inside.far - begin;
    if !(end > 0.0) || inside.near > inside.far {
        return no_hit();
    }
    let g = f + begin * w;
    let across = dot(w.xz, w.xz);
    var low = -1.0;
    var high = -1.0;
    if across > 1e-12 {
        let middle = -dot(g.xz, w.xz) / across;
        let miss = g.x * w.z - g.z * w.x;
        let least = miss * miss / across;
        // ρ³ = |v₊|² m² where h'' = 0.
        let rho_2 = pow_(across * least, 0.6666666666666666);
        let half = sqrt(max(rho_2 - least, 0.0) / across);
        low = middle - half;
        high = middle + half;
    }
    let first = torus_at(g, w, tube, 0.0);
    var outside = first.x > 0.0;
    if starts_on {
        outside = first.y > 0.0;
    }
    var on = starts_on;
    var at = 0.0;
    for (var piece = 0u; piece < 3u; piece++) {
        let convex = piece != 1u;
        let stop = min(end, select(select(end, high, piece == 1u), low, piece == 0u));
        if stop > at + select(0.0, TORUS_NEAR * tube, on && stop < end) {
            var t = FAR;
            if outside == convex {
                // Where it starts on the torus there is the root already.
                if !on {
                    t = torus_root(g, w, tube, at, stop);
                }
            } else if (torus_at(g, w, tube, stop).x > 0.0) != outside {
                t = torus_root(g, w, tube, stop, at);
                // What starts on it and goes inside comes out, however soon.
                t = max(select(t, at, t == FAR), select(0.0, TORUS_STEP, on));
            }
            let along = (begin + t) / speed;
            if t < FAR && along > 0.0 {
                return Hit(along, id, vec2<f32>(0.0), NONE);
            }
            at = stop;
            on = false;
        }
    }
    return no_hit();
}

/// Primitive `id`, one of PRIMITIVE_OTHER, against the ray from `o` along `d`, which starts on it or not: its nearest hit,
/// however far.
fn hit_other(id: u32, o: vec3<f32>, d: vec3<f32>, starts_on: bool) -> Hit {
    let shape = primitives[id].shade.w & ~PRIMITIVE_KIND;
    let f = object_point(shape, o);
    let v = object_vector(shape, d);
    switch primitives[id].index.z {
        case OTHER_DISK: {
            return disk_hit(id, f, v, starts_on);
        }
        case OTHER_CYLINDER: {
            return span_hit(id, cylinder_span(f, v), starts_on);
        }
        case OTHER_TUBE: {
            return tube_hit(id, f, v, starts_on);
        }
        case OTHER_CONE: {
            return span_hit(id, cone_span(f, v), starts_on);
        }
        case OTHER_FUNNEL: {
            return funnel_hit(id, f, v, starts_on);
        }
        case OTHER_CAPSULE: {
            return span_hit(id, capsule_span(f, v, primitives[id].x.x), starts_on);
        }
        default: {
            return torus_hit(id, f, v, primitives[id].x.x, starts_on);
        }
    }
}

/// A place on a shape of this file, in its own space.
struct OtherPoint {
    p: vec3<f32>,
    /// Outwards, of unit length.
    n: vec3<f32>,
}

// v over its length, or up if it has none.
fn unit_or_up(v: vec3<f32>) -> vec3<f32> {
    let size = length(v);
    if size < 1e-20 {
        return vec3<f32>(0.0, 1.0, 0.0);
    }
    return v / size;
}

// The place of the shape that is nearest to `q`, about; `part`: which part of it.
fn other_point(kind: u32, size: f32, q: vec3<f32>, part: f32) -> OtherPoint {
    if kind == OTHER_DISK {
        return OtherPoint(flatten(q), vec3<f32>(0.0, 1.0, 0.0));
    }
    if part != 0.0 {
        return OtherPoint(vec3<f32>(q.x, part, q.z), vec3<f32>(0.0, part, 0.0));
    }
    let out = flatten(q) / max(length(q.xz), 1e-20);
    switch kind {
        case OTHER_CYLINDER, OTHER_TUBE: {
            return OtherPoint(vec3<f32>(out.x, q.y, out.z), out);
        }
        case OTHER_CONE, OTHER_FUNNEL: {
            let y = min(q.y, 0.0);
            let slope = vec3<f32>(out.x, 1.0, out.z);
            return OtherPoint(vec3<f32>(-y * out.x, y, -y * out.z), unit_or_up(slope));
        }
        case OTHER_CAPSULE: {
            let centre = vec3<f32>(0.0, clamp(q.y, -size, size), 0.0);
            let n = unit_or_up(q - centre);
            return OtherPoint(centre + n, n);
        }
        default: {
            let n = unit_or_up(q - out);
            return OtherPoint(out + size * n, n);
        }
    }
}

// How far from the origin of its own space such a shape reaches, about.
fn other_reach(kind: u32, size: f32) -> f32 {
    return 1.0 + select(0.0, size, kind == OTHER_CAPSULE || kind == OTHER_TORUS);
}

fn surface_of_other(hit: Hit, o: vec3<f32>, d: vec3<f32>) -> Surface {
    let shape = primitives[hit.id].shade.w & ~PRIMITIVE_KIND;
    let kind = primitives[hit.id].index.z;
    let size = primitives[hit.id].x.x;
    let at = other_point(kind, size, object_point(shape, o) + hit.t * object_vector(shape, d), hit.uv.x);
    let n = normalize(world_normal(shape, at.n));
    // Round the axis, but of a disk and of ends along x.
    let flat = kind == OTHER_DISK || hit.uv.x != 0.0;
    let tangent = select(vec3<f32>(at.p.z, 0.0, -at.p.x), vec3<f32>(1.0, 0.0, 0.0), flat);
    let reach = shape_reach(shape, other_reach(kind, size));
    let along_u = world_vector(shape, tangent);
    var uv = vec2<f32>(0.0);
    var side = 1.0;
    if has_textures() {
        uv = other_uv(kind, size, at.p, hit.uv.x);
        side = handedness(shape, n, along_u, cross(at.n, tangent));
    }
    return Surface(world_point(shape, at.p), n, n, along_u, reach, shape, 0u, uv, side, 0u, uv, 0u);
}

/// (u, v) of a place `p` in the space of such a shape, on that part of it.
fn other_uv(kind: u32, size: f32, p: vec3<f32>, part: f32) -> vec2<f32> {
    if kind == OTHER_DISK || part != 0.0 {
        // As the square around it: u along x, v along the normal × x.
        return vec2<f32>(0.5 + 0.5 * p.x, 0.5 - select(0.5, -0.5, part < 0.0) * p.z);
    }
    let u = 0.5 + turn_of(p.z, p.x);
    switch kind {
        case OTHER_CYLINDER, OTHER_TUBE: {
            return vec2<f32>(u, 0.5 + 0.5 * p.y);
        }
        case OTHER_CONE, OTHER_FUNNEL: {
            return vec2<f32>(u, 1.0 + p.y);
        }
        case OTHER_CAPSULE: {
            // By the way along its outline, so that one without a side is a sphere.
            let straight = clamp(p.y, -size, size);
            let bend = TWO_PI * turn_of(length(p.xz), p.y - straight);
            return vec2<f32>(u, 0.5 + (straight + bend) / (2.0 * size + PI));
        }
        default: {
            let v = turn_of(length(p.xz) - 1.0, p.y);
            return vec2<f32>(u, select(v, v + 1.0, v < 0.0));
        }
    }
}

/// A place drawn on such a shape.
struct OtherSample {
    at: OtherPoint,
    /// With which it was drawn, per area in the shape's own space.
    pdf: f32,
}

// Where the part is drawn among side, top and bottom with the chances `parts`; the number is made fresh.
fn choose_part(parts: vec3<f32>, u: ptr<function, f32>) -> f32 {
    if *u < parts.x {
        *u /= parts.x;
        return 0.0;
    }
    if *u < parts.x + parts.y {
        *u = (*u - parts.x) / parts.y;
        return PART_TOP;
    }
    *u = min((*u - parts.x - parts.y) / max(parts.z, 1e-20), 0.99999994);
    return PART_BOTTOM;
}

// The angle round the tube at which an apple ends, and a ring does not.
fn torus_end(tube: f32) -> f32 {
    if tube <= 1.0 {
        return PI;
    }
    return acos_(-1.0 / tube);
}

// The density with which `other_sample` draws a place. `parts`: the chances of side, top and bottom; of a capsule, of its
// side and its round ends.
fn other_density(kind: u32, size: f32, p: vec3<f32>, part: f32, parts: vec3<f32>) -> f32 {
    if kind == OTHER_DISK {
        return INV_PI;
    }
    if part != 0.0 {
        return INV_PI * select(parts.y, parts.z, part < 0.0);
    }
    switch kind {
        case OTHER_CYLINDER, OTHER_TUBE: {
            return 0.25 * INV_PI * parts.x;
        }
        case OTHER_CONE, OTHER_FUNNEL: {
            return 0.7071067811865476 * INV_PI * parts.x;
        }
        case OTHER_CAPSULE: {
            return 0.25 * INV_PI * select(parts.x / max(size, 1e-20), parts.y, abs(p.y) > size);
        }
        default: {
            return 1.0 / (4.0 * PI * torus_end(size) * size * max(length(p.xz), 1e-6));
        }
    }
}

fn other_sample(kind: u32, size: f32, parts: vec3<f32>, u: vec2<f32>) -> OtherSample {
    var choice = u.x;
    var part = 0.0;
    if kind != OTHER_DISK && kind != OTHER_TORUS {
        part = choose_part(parts, &choice);
    }
    var at: OtherPoint;
    if kind == OTHER_DISK || (part != 0.0 && kind != OTHER_CAPSULE) {
        let disc = square_to_disc(vec2<f32>(choice, u.y));
        at = other_point(kind, size, vec3<f32>(disc.x, 0.0, disc.y), part);
    } else {
        let round = cos_sin_turn(choice);
        switch kind {
            case OTHER_CAPSULE: {
                if part == 0.0 {
                    at = other_point(kind, size, vec3<f32>(round.x, (2.0 * u.y - 1.0) * size, round.y), 0.0);
                } else {
                    let y = 2.0 * u.y - 1.0;
                    let n = vec3<f32>(sqrt(max(0.0, 1.0 - y * y)) * round, y).xzy;
                    at = OtherPoint(n + vec3<f32>(0.0, select(size, -size, y < 0.0), 0.0), n);
                    part = 0.0;
                }
            }
            case OTHER_CONE, OTHER_FUNNEL: {
                let y = sqrt(u.y);
                at = other_point(kind, size, vec3<f32>(y * round.x, -y, y * round.y), 0.0);
            }
            case OTHER_TORUS: {
                let along = cos_sin((2.0 * u.y - 1.0) * torus_end(size));
                let n = vec3<f32>(along.x * round.x, along.y, along.x * round.y);
                at = OtherPoint(vec3<f32>(round.x, 0.0, round.y) + size * n, n);
            }
            default: {
                at = other_point(kind, size, vec3<f32>(round.x, 2.0 * u.y - 1.0, round.y), 0.0);
            }
        }
    }
    return OtherSample(at, other_density(kind, size, at.p, part, parts));
}

// On which part of the shape a place of it lies.
fn other_part(kind: u32, p: vec3<f32>) -> f32 {
    if kind == OTHER_CYLINDER && abs(abs(p.y) - 1.0) < abs(length(p.xz) - 1.0) {
        return select(PART_TOP, PART_BOTTOM, p.y < 0.0);
    }
    if kind == OTHER_CONE && abs(p.y + 1.0) < abs(length(p.xz) + p.y) {
        return PART_BOTTOM;
    }
    return 0.0;
}
