//! The Polygon File Format (Stanford), by ply-rs-bw: ascii and both binary orders; polygons and strips become triangles,
//! colours of vertices linear: whole numbers are sRGB-encoded, others are taken as they are.

use std::io::ErrorKind;

use glam::{Vec2, Vec3, Vec4};
use kinora_scene::Mesh;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

use super::AssetError;
use super::shape::add_polygon;
use crate::builtin::color::srgb_to_linear;

/// A vertex or a face: a file has both, and other elements are read and forgotten.
struct Element {
    position: Vec3,
    normal: Vec3,
    uv: Vec2,
    color: Vec4,
    /// Corners of a face; -1 for what cannot be an index.
    corners: Vec<i64>,
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Element { position: Vec3::ZERO, normal: Vec3::ZERO, uv: Vec2::ZERO, color: Vec4::ONE, corners: Vec::new() }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if let Some(number) = number(&value) {
            let color = match name {
                "red" | "diffuse_red" => Some(&mut self.color.x),
                "green" | "diffuse_green" => Some(&mut self.color.y),
                "blue" | "diffuse_blue" => Some(&mut self.color.z),
                _ => None,
            };
            if let Some(to) = color {
                *to = match most(&value) {
                    Some(most) => srgb_to_linear(f64::from(number / most).clamp(0.0, 1.0)) as f32,
                    None => number,
                };
                return PropertyAccessResult::Set;
            }
            let to = match name {
                "x" => &mut self.position.x,
                "y" => &mut self.position.y,
                "z" => &mut self.position.z,
                "nx" => &mut self.normal.x,
                "ny" => &mut self.normal.y,
                "nz" => &mut self.normal.z,
                "u" | "s" | "texture_u" => &mut self.uv.x,
                "v" | "t" | "texture_v" => &mut self.uv.y,
                "alpha" => &mut self.color.w,
                _ => return PropertyAccessResult::Ignored,
            };
            *to = match most(&value).filter(|_| name == "alpha") {
                Some(most) => number / most,
                None => number,
            };
            return PropertyAccessResult::Set;
        }
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        self.corners = match value {
            Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListFloat(list) => list.into_iter().map(|v| whole(f64::from(v))).collect(),
            Property::ListDouble(list) => list.into_iter().map(whole).collect(),
            _ => return PropertyAccessResult::Ignored,
        };
        PropertyAccessResult::Set
    }
}

fn number(value: &Property) -> Option<f32> {
    Some(match value {
        Property::Char(v) => f32::from(*v),
        Property::UChar(v) => f32::from(*v),
        Property::Short(v) => f32::from(*v),
        Property::UShort(v) => f32::from(*v),
        Property::Int(v) => *v as f32,
        Property::UInt(v) => *v as f32,
        Property::Float(v) => *v,
        Property::Double(v) => *v as f32,
        _ => return None,
    })
}

/// The largest value of a type that counts in whole numbers.
fn most(value: &Property) -> Option<f32> {
    Some(match value {
        Property::Char(_) => 127.0,
        Property::UChar(_) => 255.0,
        Property::Short(_) => 32_767.0,
        Property::UShort(_) => 65_535.0,
        Property::Int(_) => i32::MAX as f32,
        Property::UInt(_) => u32::MAX as f32,
        _ => return None,
    })
}

fn whole(value: f64) -> i64 {
    if value.fract() == 0.0 && value.abs() < 1e15 { value as i64 } else { -1 }
}

pub(super) fn read(bytes: &[u8]) -> Result<Mesh, AssetError> {
    let invalid = |reason: &str| AssetError::unreadable(format!("is not a valid PLY file: {reason}"));
    let unreadable = |error: &ParseError| match (error.kind(), error.line()) {
        (ErrorKind::UnexpectedEof, _) => invalid("it ends too early"),
        (_, Some(line)) => invalid(&format!("line {line} cannot be read")),
        (_, None) => invalid("it cannot be read"),
    };
    let parser = Parser::<Element>::new();
    let mut reader = Reader::new(bytes);
    let header = parser.read_header(&mut reader).map_err(|error| unreadable(&error))?;
    for (name, element) in &header.elements {
        // Every element takes a byte at least, so a greater count is a lie that would only cost memory.
        if element.count > bytes.len() || element.properties.is_empty() && element.count > 0 {
            return Err(invalid(&format!("{} elements `{name}` do not fit into the file", element.count)));
        }
    }
    let has = |element: &str, property: &str| {
        header.elements.get(element).is_some_and(|element| element.properties.contains_key(property))
    };
    if !["x", "y", "z"].iter().all(|name| has("vertex", name)) {
        return Err(invalid("its vertices have no x, y and z"));
    }
    let faces = ["face", "tristrips"].map(|kind| has(kind, "vertex_indices") || has(kind, "vertex_index"));
    if faces == [false; 2] {
        return Err(AssetError::unusable("has no faces, only points"));
    }
    let with_normals = has("vertex", "nx") && has("vertex", "ny") && has("vertex", "nz");
    let with_uvs =
        [("u", "v"), ("s", "t"), ("texture_u", "texture_v")].iter().any(|(u, v)| has("vertex", u) && has("vertex", v));
    let with_colors = ["", "diffuse_"]
        .iter()
        .any(|prefix| ["red", "green", "blue"].iter().all(|color| has("vertex", &format!("{prefix}{color}"))));
    let payload = parser.read_payload(&mut reader, &header).map_err(|error| unreadable(&error))?;
    let vertices = payload.get("vertex").map_or(&[][..], Vec::as_slice);
    let mut mesh = Mesh { positions: vertices.iter().map(|vertex| vertex.position).collect(), ..Mesh::default() };
    if with_normals {
        mesh.normals = vertices.iter().map(|vertex| vertex.normal.normalize_or_zero()).collect();
    }
    if with_uvs {
        mesh.uvs = vertices.iter().map(|vertex| vertex.uv).collect();
    }
    if with_colors {
        mesh.colors = vertices.iter().map(|vertex| vertex.color).collect();
    }
    let corner = |corner: i64| match usize::try_from(corner).ok().filter(|corner| *corner < vertices.len()) {
        Some(corner) => Ok(corner as u32),
        None => Err(AssetError::unusable(format!("refers to vertex {corner} of {}", vertices.len()))),
    };
    for face in payload.get("face").map_or(&[][..], Vec::as_slice) {
        let corners = face.corners.iter().map(|index| corner(*index)).collect::<Result<Vec<_>, _>>()?;
        add_polygon(&mesh.positions, &corners, &mut mesh.triangles);
    }
    for strips in payload.get("tristrips").map_or(&[][..], Vec::as_slice) {
        // -1 begins another one.
        for strip in strips.corners.split(|index| *index == -1) {
            let corners = strip.iter().map(|index| corner(*index)).collect::<Result<Vec<_>, _>>()?;
            let triangles = corners.windows(3).enumerate();
            mesh.triangles
                .extend(triangles.map(|(i, t)| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] }));
        }
    }
    Ok(mesh)
}
