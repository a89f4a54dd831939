//! Meshes from files.

use glam::{Vec2, Vec3};
use kinora_lang::assets::read_mesh;
use kinora_scene::Mesh;

/// A unit square in the plane z = 0 with normals and uv, as one polygon, behind an element and a list of no interest.
fn header(format: &str, uv: (&str, &str)) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment a square\nobj_info none\nelement vertex 4\nproperty double x\nproperty float y\n\
         property short z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float {}\nproperty float {}\n\
         property uchar red\nelement face 1\nproperty list uchar float weights\nproperty list uint ushort vertex_index\n\
         end_header\n",
        uv.0, uv.1
    )
}

const CORNERS: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

fn ascii(uv: (&str, &str)) -> Vec<u8> {
    let mut text = header("ascii", uv);
    for [x, y] in CORNERS {
        text += &format!("{x} {y} 0 0 0 1 {x} {y} 255\n");
    }
    (text + "2 0.5 0.25 4 0 1 2 3\n").into_bytes()
}

fn binary(big: bool) -> Vec<u8> {
    let mut bytes = header(if big { "binary_big_endian" } else { "binary_little_endian" }, ("s", "t")).into_bytes();
    macro_rules! put {
        ($($value:expr),*) => { $(bytes.extend(if big { $value.to_be_bytes() } else { $value.to_le_bytes() });)* };
    }
    for [x, y] in CORNERS {
        put!(f64::from(x), y, 0i16, 0f32, 0f32, 1f32, x, y, 255u8);
    }
    put!(1u8, 0.5f32, 4u32, 0u16, 1u16, 2u16, 3u16);
    bytes
}

fn square(mesh: &Mesh) {
    mesh.validate().unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.positions, CORNERS.map(|[x, y]| Vec3::new(x, y, 0.0)));
    assert_eq!(mesh.normals, [Vec3::Z; 4]);
    assert_eq!(mesh.uvs, CORNERS.map(Vec2::from_array));
}

#[test]
fn ply_in_its_three_formats() {
    square(&read_mesh("a.ply", &ascii(("u", "v"))).unwrap());
    square(&read_mesh("a.PLY", &ascii(("s", "t"))).unwrap());
    square(&read_mesh("a.ply", &binary(false)).unwrap());
    square(&read_mesh("a.ply", &binary(true)).unwrap());
}

#[test]
fn obj() {
    let text = "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n\
                usemtl red\nf 1/1/1 2/2/1 3/3/1 4/4/1\n";
    square(&read_mesh("a.obj", text.as_bytes()).unwrap());
    let two = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\no a\nf 1//1 2//1 3//1\no b\nf -3 -2 -1\n";
    let mesh = read_mesh("a.obj", two.as_bytes()).unwrap();
    // What has no normals stays flat beside what has them.
    assert_eq!((mesh.triangles.len(), mesh.normals.len()), (2, 6));
    assert_eq!(mesh.normals.iter().filter(|normal| **normal == Vec3::ZERO).count(), 3);
    mesh.validate().unwrap();
}

#[test]
fn lies_about_sizes() {
    let check = |text: &str, message: &str| {
        assert_eq!(read_mesh("a.ply", text.as_bytes()).unwrap_err().message, message, "{text}");
    };
    let head =
        "ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nproperty float y\nproperty float z\n";
    check(
        &format!("{head}end_header\n"),
        "is not a valid PLY file: 99999999999 elements `vertex` do not fit into the file",
    );
    check(
        "ply\nformat ascii 1.0\nelement x 9\nend_header\n",
        "is not a valid PLY file: 9 elements `x` do not fit into the file",
    );
    check("ply\nformat ascii 1.0\nend_header\n", "is not a valid PLY file: its vertices have no x, y and z");
    check("", "is not a valid PLY file: it ends too early");
}

#[test]
fn damaged_files_never_fail() {
    let mut state = 1u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize
    };
    let obj = include_bytes!("assets/cube.obj").to_vec();
    let files = [("a.ply", ascii(("u", "v"))), ("a.ply", binary(true)), ("a.ply", binary(false)), ("a.obj", obj)];
    for round in 0..4000 {
        let (name, sound) = &files[round % files.len()];
        let mut bytes = sound.clone();
        for _ in 0..1 + next() % 4 {
            let at = next() % bytes.len();
            match next() % 3 {
                0 => bytes[at] = next() as u8,
                1 => bytes[at] = b"0123456789-./ e"[next() % 15],
                _ => bytes.truncate(at.max(1)),
            }
        }
        if let Ok(mesh) = read_mesh(name, &bytes) {
            let _ = mesh.validate();
        }
    }
}

#[test]
fn what_needs_more_memory_than_there_is() {
    use kinora_lang::files::Memory;
    use kinora_lang::source::{FileId, Source};
    use kinora_lang::{Overrides, eval, parse};

    // A strip of 20 000 triangles.
    let side = |i: u32| format!("v {i} 0 0\nv {i} 1 0\n");
    let cell = |i: u32| format!("f {} {} {}\nf {} {} {}\n", i, i + 1, i + 3, i, i + 3, i + 2);
    let strip: String = (0..10_001).map(side).chain((0..10_000).map(|i| cell(2 * i + 1))).collect();
    let files = Memory::new([("strip.obj", strip.as_bytes())]);
    let codes = |body: &str, memory: Option<u64>| {
        let text = format!("lang 1\ncamera {{ position: (0, 0, 9) }}\nsky {{ color: #fff }}\n{body}");
        let overrides = Overrides { memory, ..Overrides::default() };
        let found = eval(&parse(&Source::new(FileId(0), "a.kin", text)), &files, &overrides).err().unwrap_or_default();
        found.into_iter().map(|found| (found.code, found.message, found.notes, found.labels.len())).collect::<Vec<_>>()
    };
    let many = "for i in 0..2000 { mesh { file: \"strip.obj\", position: (0, i, 0) } }";
    let found = codes(many, None);
    let [(code, message, notes, labels)] = &found[..] else { panic!("{found:?}") };
    assert_eq!((*code, *labels), ("E1006", 1));
    assert_eq!(message, "the scene needs 8.9 GiB, limit 8.0 GiB");
    assert_eq!(notes[0], "`strip.obj`, 2000 times: 8.9 GiB");
    assert!(codes(many, Some(1 << 30)) == found, "less is never assumed");
    assert_eq!(codes(many, Some(16 << 30)), []);
    let copies = "mesh strip { file: \"strip.obj\" }\nfor i in 0..2000 { instance { of: strip, position: (0, i, 0) } }";
    assert_eq!(codes(copies, None), []);
}
