//! How far what a pixel shows moves in the picture until the next frame.

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3, Vec2, Vec4};
use kinora_kernel::generated::NONE;
use kinora_scene::Mesh;

use crate::film::Survey;
use crate::project::Projector;

/// Where something is placed now and at the next frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Moved {
    pub from: DAffine3,
    pub to: DAffine3,
    /// Its mesh now and then, of the same triangles; `None` if it keeps its form.
    pub meshes: Option<[Arc<Mesh>; 2]>,
}

impl Moved {
    fn stays(&self) -> bool {
        self.from == self.to && self.meshes.is_none()
    }

    // To the bit where it was, if it stays.
    fn point(&self, p: DVec3, primitive: u32) -> DVec3 {
        if self.stays() {
            return p;
        }
        let own = self.from.inverse().transform_point3(p);
        let bent = self.meshes.as_ref().and_then(|[now, next]| bent(now, next, primitive as usize, own));
        self.to.transform_point3(bent.unwrap_or(own))
    }
}

/// Where a point of a triangle goes with its corners; `None` for a triangle without area.
fn bent(now: &Mesh, next: &Mesh, triangle: usize, p: DVec3) -> Option<DVec3> {
    let corners = |mesh: &Mesh| {
        let [a, b, c] = mesh.triangles.get(triangle)?.map(|v| mesh.positions.get(v as usize).map(|p| p.as_dvec3()));
        Some([a?, b?, c?])
    };
    let ([a, b, c], [a2, b2, c2]) = (corners(now)?, corners(next)?);
    let (u, v) = (b - a, c - a);
    let normal = u.cross(v);
    let area2 = normal.length_squared();
    let share = |a: DVec3, b: DVec3| a.cross(b).dot(normal) / area2;
    let (s, t) = (share(p - a, v), share(u, p - a));
    (area2 > 0.0).then(|| a2 + s * (b2 - a2) + t * (c2 - a2))
}

/// The camera and everything that it may show.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    pub now: Projector,
    pub next: Projector,
    /// By the shapes' indices; those of a part move in its space.
    pub shapes: Vec<Moved>,
}

impl Motion {
    /// Pixels to the right and down, of the first sample of `survey`; 0 where one of the two frames does not show it.
    pub fn of(&self, survey: &Survey) -> Vec2 {
        let [.., position, shape] = *survey;
        let p = position.truncate().as_dvec3();
        let (from, to) = match position.w {
            0.0 if p == DVec3::ZERO => return Vec2::ZERO,
            0.0 => (self.now.direction(p), self.next.direction(p)),
            _ => {
                let seen = |camera: &Projector, p: DVec3| camera.point(camera.in_camera(p));
                (seen(&self.now, p), seen(&self.next, self.moved(p, shape)))
            }
        };
        let way = from.zip(to).map_or(DVec2::ZERO, |(from, to)| self.next.way(from, to)).as_vec2();
        if way.is_finite() { way } else { Vec2::ZERO }
    }

    fn moved(&self, p: DVec3, shape: Vec4) -> DVec3 {
        let whole = |high: f32, place: u32| (high as u32) << 8 | (shape.w as u32) >> place & 0xff;
        let (copy, primitive) = (whole(shape.y, 8), whole(shape.z, 0));
        let shape = whole(shape.x, 16);
        let Some(own) = self.shapes.get(shape as usize) else { return p };
        match self.shapes.get(copy as usize).filter(|_| copy != NONE) {
            Some(copy) if !own.stays() => {
                copy.to.transform_point3(own.point(copy.from.inverse().transform_point3(p), primitive))
            }
            Some(copy) => copy.point(p, NONE),
            None => own.point(p, primitive),
        }
    }
}
