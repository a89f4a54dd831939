//! Geometry.

use std::rc::Rc;
use std::sync::Arc;

use glam::{DVec2, DVec3, Vec2};
use kinora_scene::{Animated, Frame, Mesh, Shape};

use super::{Lower, read};
use crate::diagnostic::Diagnostic;
use crate::eval::coerce::Data;
use crate::eval::machine::NodeValue;
use crate::schema::Kind;
use crate::source::Span;
use crate::value::NodeId;

/// A mesh that is still to be read or worked on.
#[derive(Debug, Clone)]
pub struct MeshRequest {
    /// Index into the scene's nodes.
    pub node: usize,
    /// Where it comes from.
    pub from: MeshFrom,
    /// The place that names it.
    pub span: Span,
    /// `smooth`, if set.
    pub smooth: Option<bool>,
    /// `fit`, if set: metres.
    pub fit: Option<f64>,
    /// The place that makes it of glass, if it is: its inside must then be closed.
    pub glass: Option<Span>,
    /// Whether it is made of what its file says.
    pub own_materials: bool,
}

impl MeshRequest {
    /// Whether it may have materials that give light.
    pub fn may_shine(&self) -> bool {
        let is_object = |file: &str| file.to_ascii_lowercase().ends_with(".obj");
        self.own_materials && matches!(&self.from, MeshFrom::File(file) if is_object(file))
    }
}

/// Where a mesh comes from.
#[derive(Debug, Clone)]
pub enum MeshFrom {
    /// A file, as written.
    File(Arc<str>),
    /// The scene itself.
    Lists(Mesh),
}

impl<'a> Lower<'_, 'a> {
    pub(super) fn shape(
        &mut self,
        id: NodeId,
        node: &Rc<NodeValue<'a>>,
        kind: &Kind,
        index: usize,
    ) -> Option<Shape<Animated>> {
        Some(match kind.name {
            "sphere" => Shape::Sphere { radius_m: read::track(self.machine, node, "radius") },
            "box" => Shape::Box { size_m: read::vector(node, "size") },
            "quad" => {
                let size_m = match read::parts(node, "size").as_slice() {
                    [x, y] => DVec2::new(*x, *y),
                    _ => DVec2::ONE,
                };
                Shape::Quad { frame: self.frame(id, node), size_m }
            }
            "torus" => Shape::Torus { radius_m: read::number(node, "radius"), tube_m: read::number(node, "tube") },
            "disk" => {
                let frame = Frame::facing(read::vector(node, "normal"), DVec3::Y);
                let frame = frame.unwrap_or(Frame { x: DVec3::X, y: DVec3::NEG_Z, z: DVec3::Y });
                Shape::Disk { frame, radius_m: read::number(node, "radius") }
            }
            "cylinder" | "cone" | "capsule" => {
                let (radius_m, height_m) = (read::number(node, "radius"), read::number(node, "height"));
                let capped = read::number(node, "capped") != 0.0;
                match kind.name {
                    "cylinder" => Shape::Cylinder { radius_m, height_m, capped },
                    "cone" => Shape::Cone { radius_m, height_m, capped },
                    _ => {
                        self.low_capsule(id, node, [radius_m, height_m], capped);
                        Shape::Capsule { radius_m, height_m, capped }
                    }
                }
            }
            "plane" => Shape::Plane { frame: self.frame(id, node) },
            "mesh" => {
                self.mesh(id, node, index);
                Shape::Mesh(Arc::default())
            }
            "model" => {
                self.model(id, node, index);
                return None;
            }
            _ => return None,
        })
    }

    /// E0401: the round ends of a capsule do not fit into its height.
    fn low_capsule(&mut self, id: NodeId, node: &Rc<NodeValue<'a>>, [radius, height]: [f64; 2], capped: bool) {
        let least = 2.0 * radius;
        let failed =
            ["radius", "height"].iter().any(|name| read::set(node, name).is_some_and(|set| set.data.is_none()));
        // What is written as twice the radius may be off by rounding.
        if failed || (if capped { height >= least * (1.0 - 1e-9) } else { height > least }) {
            return;
        }
        let span = read::set(node, "height").or(read::set(node, "radius")).map_or(self.span(id), |set| set.expr.span);
        let message = format!("a capsule of radius {radius} must be {least} high or more");
        let diagnostic = match capped {
            true => {
                Diagnostic::new("E0401", message).help("`height` includes the round ends: raise it, or use a `sphere`")
            }
            false => Diagnostic::new("E0401", "nothing is left of the capsule without its round ends")
                .help("raise its `height`, which includes the round ends"),
        };
        self.report(id, diagnostic.primary(self.machine.file(), span, format!("its ends alone are {least} high")));
    }

    fn frame(&mut self, id: NodeId, node: &Rc<NodeValue<'a>>) -> Frame {
        let (normal, up) = (read::vector(node, "normal"), read::vector(node, "up"));
        if let Some(frame) = Frame::facing(normal, up) {
            return frame;
        }
        let set = read::set(node, "normal").or(read::set(node, "up"));
        let failed = ["normal", "up"].iter().any(|name| read::set(node, name).is_some_and(|set| set.data.is_none()));
        if !failed {
            let span = set.map_or(self.span(id), |set| set.expr.span);
            let diagnostic = Diagnostic::new("E0405", "`normal` and `up` give no direction for the width")
                .primary(self.machine.file(), span, "parallel to `up`, along x")
                .help("give another `up`, for example `up: (0, 1, 0)`");
            self.report(id, diagnostic);
        }
        Frame { x: DVec3::X, y: DVec3::NEG_Z, z: DVec3::Y }
    }

    /// E0401: the light of an infinite plane has no sum.
    pub(super) fn power_of_plane(
        &mut self,
        id: NodeId,
        node: &Rc<NodeValue<'a>>,
        shape: Option<&Shape<Animated>>,
        material: usize,
    ) {
        let Some(Shape::Plane { .. }) = shape else { return };
        let Some(set) = read::set(node, "material") else { return };
        let Some(power) = self.made_of.get(material).and_then(|made_of| made_of.power) else { return };
        let file = self.machine.file();
        let diagnostic = Diagnostic::new("E0401", "an infinite plane cannot have a `power`")
            .primary(file, set.expr.span, "its light has no sum")
            .label(file, power, "power is set here")
            .help("use `radiance`, or a `quad`");
        self.report(id, diagnostic);
    }

    fn mesh(&mut self, id: NodeId, node: &Rc<NodeValue<'a>>, index: usize) {
        let file = self.machine.file();
        let (path, positions) = (read::set(node, "file"), read::set(node, "positions"));
        if let (Some(path), Some(positions)) = (path, positions) {
            let diagnostic = Diagnostic::new("E0206", "a mesh takes `file` or `positions`, not both")
                .primary(file, positions.name, "says where the triangles come from")
                .label(file, path.name, "says it too")
                .help("remove one");
            self.report(id, diagnostic);
            return;
        }
        let kind = self.machine.nodes.get(id.0 as usize).map_or(Span::at(0), |slot| slot.ast.kind.span);
        let (from, span) = if let Some(set) = path {
            let Some(Data::Text(path)) = &set.data else { return };
            (MeshFrom::File(path.clone()), set.expr.span)
        } else if let Some(set) = positions {
            let indices = read::set(node, "indices");
            if indices.is_none() {
                let diagnostic = Diagnostic::new("E0207", "`mesh` with `positions` needs `indices`")
                    .primary(file, set.name, "which of them make triangles?")
                    .help("add `indices: [0, 1, 2]`, three a triangle");
                self.report(id, diagnostic);
                return;
            }
            let Some(mesh) = self.lists(id, node) else { return };
            (MeshFrom::Lists(mesh), set.name)
        } else {
            let diagnostic = Diagnostic::new("E0207", "`mesh` needs `file`")
                .primary(file, kind, "where do its triangles come from?")
                .help("add `file: \"...\"`, or `positions` and `indices`");
            self.report(id, diagnostic);
            return;
        };
        let smooth = read::number_if_set(node, "smooth").map(|value| value != 0.0);
        let fit = read::number_if_set(node, "fit");
        let own_materials = read::set(node, "material").is_none();
        self.meshes.push(MeshRequest { node: index, from, span, smooth, fit, glass: None, own_materials });
    }

    fn lists(&mut self, id: NodeId, node: &Rc<NodeValue<'a>>) -> Option<Mesh> {
        let rows = |name: &str| match read::set(node, name) {
            None => Some(Arc::default()),
            Some(set) => match &set.data {
                Some(Data::Rows(rows)) => Some(rows.clone()),
                _ => None,
            },
        };
        let (positions, indices) = (rows("positions")?, rows("indices")?);
        let (normals, uvs) = (rows("normals")?, rows("uvs")?);
        let place = read::set(node, "indices").map_or(Span::at(0), |set| set.expr.span);
        let file = self.machine.file();
        if indices.len() % 3 != 0 {
            let message = format!("a triangle has 3 indices, {} are not divisible by 3", indices.len());
            let diagnostic = Diagnostic::new("E0803", message).primary(file, place, "three a triangle");
            self.report(id, diagnostic);
            return None;
        }
        let mut flat = Vec::with_capacity(indices.len());
        for row in indices.iter() {
            let index = row[0];
            if !(0.0..positions.len() as f64).contains(&index) {
                let message = format!("mesh `{}` refers to vertex {index} of {}", self.name(id), positions.len());
                let diagnostic = Diagnostic::new("E0803", message)
                    .primary(file, place, "there is no such vertex")
                    .help("vertices are counted from 0");
                self.report(id, diagnostic);
                return None;
            }
            flat.push(index as u32);
        }
        let point = |row: &[f64; 3]| DVec3::from_array(*row).as_vec3();
        Some(Mesh {
            name: self.name(id),
            positions: positions.iter().map(point).collect(),
            normals: normals.iter().map(|row| point(row).normalize_or_zero()).collect(),
            uvs: uvs.iter().map(|row| Vec2::new(row[0] as f32, row[1] as f32)).collect(),
            triangles: flat.as_chunks::<3>().0.to_vec(),
            ..Mesh::default()
        })
    }
}
