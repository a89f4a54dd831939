//! How far what a pixel shows moves in the picture until the next frame.

use glam::{DAffine3, DVec2, DVec3, Vec2, Vec4};
use kinora_kernel::generated::NONE;

use crate::film::Survey;
use crate::project::Projector;

/// Where something is placed now and at the next frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved {
    pub from: DAffine3,
    pub to: DAffine3,
}

impl Moved {
    // To the bit where it was, if it stays.
    fn point(&self, p: DVec3) -> DVec3 {
        if self.from == self.to { p } else { self.to.transform_point3(self.from.inverse().transform_point3(p)) }
    }
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
        let whole = |high: f32, low: f32| (high as u32) << 16 | low as u32;
        let (shape, copy) = (whole(shape.x, shape.y), whole(shape.z, shape.w));
        let Some(own) = self.shapes.get(shape as usize) else { return p };
        match self.shapes.get(copy as usize).filter(|_| copy != NONE) {
            Some(copy) if own.from != own.to => {
                copy.to.transform_point3(own.point(copy.from.inverse().transform_point3(p)))
            }
            Some(copy) => copy.point(p),
            None => own.point(p),
        }
    }
}
