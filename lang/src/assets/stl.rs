//! STL, binary and ASCII. Its triangles have no corners in common: those in one place become one vertex. The normals of the
//! file are left out, since they say what the corners say.

use std::collections::HashMap;

use glam::Vec3;
use kinora_scene::Mesh;

use super::AssetError;

/// Header and count of a binary file.
const HEADER: usize = 84;
/// A triangle of it: normal, three corners, and two bytes that mean nothing.
const TRIANGLE: usize = 50;

pub(super) fn read(bytes: &[u8]) -> Result<Mesh, AssetError> {
    let count = bytes.get(80..HEADER).and_then(|count| Some(u32::from_le_bytes(count.try_into().ok()?)));
    let fits = count.is_some_and(|count| HEADER as u64 + TRIANGLE as u64 * u64::from(count) == bytes.len() as u64);
    // Some programs begin binary files with the word of the other kind.
    let begins = bytes.trim_ascii_start().starts_with(b"solid");
    match count {
        Some(count) if fits || !begins => binary(bytes, count),
        _ => ascii(bytes),
    }
}

fn invalid(reason: &str) -> AssetError {
    AssetError::unreadable(format!("is not a valid STL file: {reason}"))
}

#[derive(Default)]
struct Welded {
    mesh: Mesh,
    known: HashMap<[u32; 3], u32>,
}

impl Welded {
    fn corner(&mut self, p: Vec3) -> u32 {
        // -0 and 0 are one place.
        let key = (p + Vec3::ZERO).to_array().map(f32::to_bits);
        *self.known.entry(key).or_insert_with(|| {
            self.mesh.positions.push(p);
            self.mesh.positions.len() as u32 - 1
        })
    }
}

fn binary(bytes: &[u8], count: u32) -> Result<Mesh, AssetError> {
    let body = bytes.get(HEADER..).unwrap_or_default();
    let (whole, rest) = (body.len() / TRIANGLE, body.len() % TRIANGLE);
    if (whole as u64) < u64::from(count) {
        return Err(invalid(&format!("it ends after {whole} of {count} triangles")));
    }
    if whole as u64 > u64::from(count) || rest > 0 {
        return Err(invalid(&format!("it goes on after its {count} triangles")));
    }
    let mut welded = Welded::default();
    for triangle in body.as_chunks::<TRIANGLE>().0 {
        let number =
            |at: usize| f32::from_le_bytes([triangle[at], triangle[at + 1], triangle[at + 2], triangle[at + 3]]);
        let corners = [12, 24, 36].map(|at| welded.corner(Vec3::new(number(at), number(at + 4), number(at + 8))));
        welded.mesh.triangles.push(corners);
    }
    Ok(welded.mesh)
}

fn ascii(bytes: &[u8]) -> Result<Mesh, AssetError> {
    if !bytes.trim_ascii_start().starts_with(b"solid") {
        return Err(invalid("it is too short"));
    }
    let text = String::from_utf8_lossy(bytes);
    let mut welded = Welded::default();
    let mut corners: Vec<u32> = Vec::new();
    // What may come next: 0 a solid, 1 a facet or the end of the solid, 2 its loop, 3 corners, 4 the end of the facet.
    let mut state = 0;
    let mut last = 0;
    for (i, line) in text.lines().enumerate() {
        let mut words = line.split_ascii_whitespace();
        let Some(word) = words.next() else { continue };
        let wrong = || invalid(&format!("line {} cannot be read", i + 1));
        last = i + 1;
        state = match (state, word.to_ascii_lowercase().as_str()) {
            (0, "solid") => 1,
            (1, "endsolid") => 0,
            (1, "facet") => 2,
            (2, "outer") => 3,
            (3, "vertex") => {
                let mut number = || words.next().and_then(|word| word.parse::<f32>().ok()).ok_or_else(wrong);
                let p = Vec3::new(number()?, number()?, number()?);
                corners.push(welded.corner(p));
                3
            }
            (3, "endloop") => {
                let triangle: [u32; 3] = corners
                    .as_slice()
                    .try_into()
                    .map_err(|_| invalid(&format!("a facet has {} corners (line {})", corners.len(), i + 1)))?;
                welded.mesh.triangles.push(triangle);
                corners.clear();
                4
            }
            (4, "endfacet") => 1,
            _ => return Err(wrong()),
        };
    }
    if state != 0 {
        return Err(invalid(&format!("it ends too early, after line {last}")));
    }
    Ok(welded.mesh)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn binary_file(triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
        let mut bytes = vec![b' '; 80];
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for triangle in triangles {
            bytes.extend([0; 12]);
            bytes.extend(triangle.iter().flatten().flat_map(|x| x.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    const SQUARE: [[[f32; 3]; 3]; 2] =
        [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]], [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [-0.0, 1.0, 0.0]]];

    #[test]
    fn both_kinds_share_corners() {
        let mut bytes = binary_file(&SQUARE);
        bytes[..5].copy_from_slice(b"solid");
        let mut text = "solid a name\n".to_string();
        for triangle in SQUARE {
            text += "  facet normal 0 0 1\n outer loop\n";
            for [x, y, z] in triangle {
                text += &format!("vertex {x} {y} {z:e}\n");
            }
            text += "endloop\nendfacet\n\n";
        }
        text += "endsolid a name\n";
        for file in [bytes, text.into_bytes()] {
            let mesh = read(&file).expect("a square");
            assert_eq!(mesh.positions.len(), 4);
            assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        }
    }

    #[test]
    fn what_is_wrong_is_said() {
        let whole = binary_file(&SQUARE);
        let longer = [whole.as_slice(), &[0; 50]].concat();
        let said = |bytes: &[u8]| read(bytes).expect_err("broken").message;
        assert!(said(&whole[..whole.len() - 1]).contains("ends after 1 of 2 triangles"));
        assert!(said(&longer).contains("goes on after its 2 triangles"));
        assert!(said(b"").contains("too short"));
        assert!(said(b"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n").contains("ends too early"));
        assert!(said(b"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 x 0\n").contains("line 4"));
        assert!(said(b"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nendloop").contains("1 corners"));
    }
}
