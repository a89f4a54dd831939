//! The boxes of the tree over a scene's primitives, drawn as wires over its picture (`render.view: bvh`). They are drawn
//! on the host: their edges are the same few lines on every backend.

use glam::{DVec2, DVec3, Vec2, Vec3, Vec3A};
use kinora_kernel::Packed;
use kinora_scene::{Projection, View};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;

use crate::film::Window;
use crate::project::Projector;

/// Levels are drawn as long as this many boxes are not exceeded: more would fill the picture.
const MOST_BOXES: usize = 700;
/// Width of a wire in pixels: of the whole scene's box, then less at every level.
const WIDTHS: [f32; 4] = [2.0, 1.6, 1.25, 1.0];
/// How much of a wire's colour is seen in front of everything, level by level; small boxes are many.
const IN_FRONT: [f32; 4] = [0.95, 0.9, 0.75, 0.5];
/// The share of that which is left behind a surface.
const BEHIND: f32 = 0.08;
/// Colours of the levels, from the whole scene's box down; linear light.
const COLORS: [Vec3; 5] = [
    Vec3::new(1.0, 1.0, 1.0),
    Vec3::new(1.0, 0.45, 0.05),
    Vec3::new(0.15, 0.75, 0.25),
    Vec3::new(0.1, 0.45, 1.0),
    Vec3::new(0.85, 0.2, 0.75),
];
/// Wires nearer to the eye than this share of its distance to the boxes are cut off.
const NEAR: f64 = 1e-4;

/// Pieces of an edge where the picture bends it.
const PIECES: usize = 48;

/// Boxes, and the camera that sees them.
#[derive(Clone, Debug, PartialEq)]
pub struct Wires {
    // By level, the whole scene's box first.
    levels: Vec<Vec<[Vec3; 2]>>,
    eye: Vec3,
    // The camera's axis, away from what it looks at.
    back: Vec3,
    camera: Projector,
    picture: DVec2,
}

/// What lies beneath the wires.
pub struct Canvas<'a> {
    /// The part of the picture.
    pub window: Window,
    /// Linear light, row by row.
    pub pixels: &'a mut [Vec3],
    /// Metres along the camera's axis.
    pub depth: &'a dyn Fn(usize) -> f32,
}

impl Wires {
    /// The boxes of `packed`, which `view` shows in a picture of `size`, width and height in pixels.
    pub fn of(packed: &Packed, view: &View, size: [u32; 2]) -> Self {
        Self {
            levels: packed.compressed().map_or_else(|_| Vec::new(), |compressed| levels(&compressed.bvh)),
            eye: view.world_from_camera.translation.as_vec3(),
            back: view.world_from_camera.matrix3.z_axis.as_vec3(),
            camera: Projector::new(view, size),
            picture: DVec2::from(size.map(f64::from)),
        }
    }

    /// The direction from `p` to the eye.
    pub fn to_eye(&self, p: Vec3) -> Vec3 {
        match self.camera.projection() {
            Projection::Orthographic { .. } => self.back,
            _ => (self.eye - p).normalize_or_zero(),
        }
    }

    /// Draws all of them: the smallest boxes first, the whole scene's last.
    pub fn draw(&self, canvas: &mut Canvas<'_>) {
        for (level, boxes) in self.levels.iter().enumerate().rev() {
            let color = COLORS[level.min(COLORS.len() - 1)];
            let (width, strength) = (WIDTHS[level.min(3)], IN_FRONT[level.min(3)]);
            for corners in boxes {
                for [a, b] in edges(*corners) {
                    self.edge(canvas, [a, b], color, width, strength);
                }
            }
        }
    }

    fn edge(&self, canvas: &mut Canvas<'_>, [a, b]: [Vec3; 2], color: Vec3, width: f32, strength: f32) {
        let [mut a, mut b] = [a, b].map(|p| self.camera.in_camera(p.as_dvec3()));
        if !matches!(self.camera.projection(), Projection::Perspective { .. }) {
            let mut before = self.project(a);
            for piece in 1..=PIECES {
                let here = self.project(a.lerp(b, piece as f64 / PIECES as f64));
                // Not across a panorama from one side to the other.
                if let (Some(a), Some(b)) = (before, here)
                    && (a.0 - b.0).abs().as_dvec2().cmplt(0.5 * self.picture).all()
                {
                    line(canvas, [a, b], color, width, strength);
                }
                before = here;
            }
            return;
        }
        let near = -NEAR * a.length().max(b.length());
        if a.z > near && b.z > near {
            return;
        }
        // The camera looks along its own -z.
        let cut = |from: DVec3, to: DVec3| from + (to - from) * ((near - from.z) / (to.z - from.z));
        if a.z > near {
            a = cut(b, a);
        }
        if b.z > near {
            b = cut(a, b);
        }
        if let (Some(a), Some(b)) = (self.project(a), self.project(b)) {
            line(canvas, [a, b], color, width, strength);
        }
    }

    // Where a point of the camera's space is in pixels, and 1 / depth.
    fn project(&self, p: DVec3) -> Option<(Vec2, f32)> {
        let at = self.camera.point(p)?;
        let depth = match self.camera.projection() {
            Projection::Perspective { .. } | Projection::Orthographic { .. } => -p.z,
            Projection::Panorama => p.length(),
            Projection::Fisheye { .. } if (at - 0.5 * self.picture).length() > 0.5 * self.picture.y => return None,
            Projection::Fisheye { .. } => p.length(),
        };
        (depth > 0.0).then(|| (at.as_vec2(), (1.0 / depth) as f32))
    }
}

// A line between two points in pixels, each with 1 / depth, which is linear along it.
fn line(canvas: &mut Canvas<'_>, [(a, near_a), (b, near_b)]: [(Vec2, f32); 2], color: Vec3, width: f32, strength: f32) {
    let Window { left, top, width: columns, height: rows } = canvas.window;
    let start = Vec2::new(left as f32, top as f32);
    let end = start + Vec2::new(columns as f32, rows as f32);
    let steep = (b.y - a.y).abs() > (b.x - a.x).abs();
    let turn = |p: Vec2| if steep { Vec2::new(p.y, p.x) } else { p };
    let (mut a, mut b, start, end) = (turn(a), turn(b), turn(start), turn(end));
    let (mut near_a, mut near_b) = (near_a, near_b);
    if a.x > b.x {
        std::mem::swap(&mut a, &mut b);
        std::mem::swap(&mut near_a, &mut near_b);
    }
    let length = b.x - a.x;
    if !length.is_finite() || !a.y.is_finite() || !b.y.is_finite() {
        return;
    }
    // Across the line, as seen along y.
    let slope = if length > 0.0 { (b.y - a.y) / length } else { 0.0 };
    let stretch = (1.0 + slope * slope).sqrt();
    let reach = (0.5 * width + 0.5) * stretch;
    let first = a.x.floor().max(start.x) as i64;
    let last = b.x.ceil().clamp(start.x - 1.0, end.x - 1.0) as i64;
    for x in first..=last {
        // The line begins and ends within a pixel.
        let share = (b.x - x as f32).clamp(0.0, 1.0) - (a.x - x as f32).clamp(0.0, 1.0);
        let along = if length > 0.0 { ((x as f32 + 0.5 - a.x) / length).clamp(0.0, 1.0) } else { 0.0 };
        let middle = a.y + slope * (length * along);
        let near = near_a + (near_b - near_a) * along;
        let low = (middle - reach).floor().max(start.y);
        let high = (middle + reach).min(end.y - 1.0);
        let mut y = low;
        while y <= high {
            let distance = (y + 0.5 - middle).abs() / stretch;
            let cover = share * (0.5 * width + 0.5 - distance).clamp(0.0, 1.0);
            let (column, row) = if steep { (y as usize, x as usize) } else { (x as usize, y as usize) };
            let i = (row - top as usize) * columns as usize + column - left as usize;
            // A box may share a face with what it holds.
            let hidden = near * (canvas.depth)(i) < 0.995;
            if let Some(pixel) = canvas.pixels.get_mut(i) {
                *pixel = pixel.lerp(color, cover * strength * if hidden { BEHIND } else { 1.0 });
            }
            y += 1.0;
        }
    }
}

// The twelve edges between two opposite corners.
fn edges([low, high]: [Vec3; 2]) -> impl Iterator<Item = [Vec3; 2]> {
    let corner = move |i: u32| Vec3::select(glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0), high, low);
    let pairs = (0..8_u32).flat_map(|i| [1, 2, 4].map(|axis| (i, i | axis)));
    pairs.filter(|(a, b)| a != b).map(move |(a, b)| [corner(a), corner(b)])
}

fn levels(bvh: &CwBvh) -> Vec<Vec<[Vec3; 2]>> {
    let corners = |b: &Aabb| [Vec3::from(b.min), Vec3::from(b.max)];
    let mut levels = Vec::new();
    let mut count = 0;
    let mut nodes = if bvh.nodes.is_empty() { vec![] } else { vec![0_u32] };
    while !nodes.is_empty() {
        let (mut boxes, mut below) = (Vec::new(), Vec::new());
        for node in nodes.iter().filter_map(|&node| bvh.nodes.get(node as usize)) {
            for child in (0..8).filter(|&child| !node.is_child_empty(child)) {
                boxes.push(node.child_aabb(child));
                if !node.is_leaf(child) {
                    below.push(node.child_node_index(child));
                }
            }
        }
        if levels.is_empty() {
            let all =
                boxes
                    .iter()
                    .fold(Aabb { min: Vec3A::splat(f32::INFINITY), max: Vec3A::splat(f32::NEG_INFINITY) }, |all, b| {
                        Aabb { min: all.min.min(b.min), max: all.max.max(b.max) }
                    });
            levels.push(vec![corners(&all)]);
        }
        count += boxes.len();
        if count > MOST_BOXES && levels.len() > 1 {
            break;
        }
        levels.push(boxes.iter().map(corners).collect());
        nodes = below;
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_twelve_edges() {
        let edges: Vec<_> = edges([Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0)]).collect();
        assert_eq!(edges.len(), 12);
        let mut lengths: Vec<f32> = edges.iter().map(|[a, b]| (*b - *a).length()).collect();
        lengths.sort_by(f32::total_cmp);
        assert_eq!(lengths, [1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0, 3.0]);
    }

    // What a wire of width 1 adds to a black picture of 9 × 9 pixels, before a surface at `depth`.
    fn drawn(a: Vec2, b: Vec2, depth: f32) -> Vec<f32> {
        let mut pixels = vec![Vec3::ZERO; 81];
        let window = Window::whole([9, 9]);
        let mut canvas = Canvas { window, pixels: &mut pixels, depth: &|_| depth };
        line(&mut canvas, [(a, 0.5), (b, 0.5)], Vec3::ONE, 1.0, 0.5);
        pixels.iter().map(|p| p.x).collect()
    }

    #[test]
    fn wires() {
        // Through the middle of a row of pixels: all of those and no others.
        let picture = drawn(Vec2::new(0.0, 4.5), Vec2::new(9.0, 4.5), 1e10);
        for (i, value) in picture.iter().enumerate() {
            let expected = if i / 9 == 4 { 0.5 } else { 0.0 };
            assert!((value - expected).abs() < 1e-6, "pixel {i}: {value}");
        }
        let hidden = drawn(Vec2::new(4.5, 9.0), Vec2::new(4.5, 0.0), 1.0);
        assert!((hidden[4 * 9 + 4] - 0.5 * BEHIND).abs() < 1e-6);
        // Whatever lies outside, or is no number, draws nothing and ends.
        for (a, b) in [(-50.0, -40.0), (f32::NAN, 4.0), (f32::NEG_INFINITY, 2.0), (20.0, 30.0)] {
            assert!(drawn(Vec2::new(a, 1.0), Vec2::new(b, 2.0), 1e10).iter().all(|v| *v == 0.0));
        }
        let far = drawn(Vec2::new(-1e6, 4.5), Vec2::new(1e6, 4.5), 1e10);
        assert!(far[4 * 9 + 4] > 0.4);
    }
}
