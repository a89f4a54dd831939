//! The Polygon File Format (Stanford), by ply-rs-bw: ascii and both binary orders; polygons become fans of triangles.

use std::io::ErrorKind;

use glam::{Vec2, Vec3};
use kinora_scene::Mesh;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

use super::AssetError;

/// A vertex or a face: a file has both, and other elements are read and forgotten.
#[derive(Default)]
struct Element {
    position: Vec3,
    normal: Vec3,
    uv: Vec2,
    /// Corners of a face; -1 for what cannot be an index.
    corners: Vec<i64>,
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Element::default()
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if let Some(number) = number(&value) {
            let to = match name {
                "x" => &mut self.position.x,
                "y" => &mut self.position.y,
                "z" => &mut self.position.z,
                "nx" => &mut self.normal.x,
                "ny" => &mut self.normal.y,
                "nz" => &mut self.normal.z,
                "u" | "s" | "texture_u" => &mut self.uv.x,
                "v" | "t" | "texture_v" => &mut self.uv.y,
                _ => return PropertyAccessResult::Ignored,
            };
            *to = number;
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
    if !has("face", "vertex_indices") && !has("face", "vertex_index") {
        return Err(AssetError::unusable("has no faces, only points"));
    }
    let with_normals = has("vertex", "nx") && has("vertex", "ny") && has("vertex", "nz");
    let with_uvs =
        [("u", "v"), ("s", "t"), ("texture_u", "texture_v")].iter().any(|(u, v)| has("vertex", u) && has("vertex", v));
    let payload = parser.read_payload(&mut reader, &header).map_err(|error| unreadable(&error))?;
    let vertices = payload.get("vertex").map_or(&[][..], Vec::as_slice);
    let mut mesh = Mesh { positions: vertices.iter().map(|vertex| vertex.position).collect(), ..Mesh::default() };
    if with_normals {
        mesh.normals = vertices.iter().map(|vertex| vertex.normal.normalize_or_zero()).collect();
    }
    if with_uvs {
        mesh.uvs = vertices.iter().map(|vertex| vertex.uv).collect();
    }
    for face in payload.get("face").map_or(&[][..], Vec::as_slice) {
        let mut corners = Vec::with_capacity(face.corners.len());
        for corner in &face.corners {
            match usize::try_from(*corner).ok().filter(|corner| *corner < vertices.len()) {
                Some(corner) => corners.push(corner as u32),
                None => {
                    let message = format!("refers to vertex {corner} of {}", vertices.len());
                    return Err(AssetError::unusable(message));
                }
            }
        }
        if let [first, rest @ ..] = corners.as_slice() {
            mesh.triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
        }
    }
    Ok(mesh)
}
