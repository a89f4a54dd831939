//! OBJ files with materials, and the colours of PLY files: what they become.

use glam::{Vec3, Vec4};
use kinora_lang::diagnostic::Diagnostic;
use kinora_lang::files::Memory;
use kinora_lang::source::{FileId, Source};
use kinora_lang::{Overrides, eval, parse};
use kinora_scene::{Bsdf, Channel, Material, Mesh, Scene, Shape, Slot, Texture, Wrap};

const OBJECT: &str = "mtllib two words.mtl
o left
v 0 0 0
v 2 0 0
v 2 2 0
v 0 2 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
usemtl wood
f 1/1 2/2 3/3 4/4
o right
usemtl lamp
f 1/1 2/2 3/3
usemtl glass
f 1/1 3/3 4/4
usemtl steel
f -4/1 -3/2 -2/3
";

const MATERIALS: &str = "newmtl wood
Kd 0.5 0.25 1
Ks 0.5 0.5 0.5
Ns 30
Ni 1.5
d 0.5
map_Kd -s 2 3 -clamp on grey.png
map_d grey.png
map_Bump -bm 2 grey.png
newmtl lamp
Kd 0 0 0
Ke 4 2 0
newmtl glass
Kd 1 1 1
illum 7
Ni 1.4
newmtl steel
Kd 0.9 0.8 0.7
Pr 0.3
Pm 1
";

fn png() -> Vec<u8> {
    let picture = image::GrayImage::from_fn(2, 2, |x, y| image::Luma([(x * 200 + y * 50) as u8]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png).expect("memory is large enough");
    bytes.into_inner()
}

fn evaluate(text: &str) -> Result<(Scene, Vec<Diagnostic>), Vec<Diagnostic>> {
    let colors = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n\
        property list char ushort vertex_index\nend_header\n\
        0 0 0 255 0 128\n4 -2 0 255 0 128\n1 0 0 255 0 128\n4 2 0 255 0 128\n4 0 1 2 3\n";
    let picture = png();
    let files = Memory::new([
        ("parts/a.obj", OBJECT.as_bytes()),
        ("parts/two words.mtl", MATERIALS.as_bytes()),
        ("parts/grey.png", picture.as_slice()),
        ("colors.ply", colors.as_bytes()),
    ]);
    let source = Source::new(FileId(0), "a.kin", format!("lang 1\ncamera main {{ position: (0, 0, 4) }}\n{text}"));
    eval(&parse(&source), &files, &Overrides::default()).map(|done| (done.scene, done.warnings))
}

fn meshes(scene: &Scene) -> Vec<(&str, &Mesh, usize)> {
    let of = |node: &'_ kinora_scene::Node| match &node.shape {
        Some(Shape::Mesh(mesh)) => Some(mesh.clone()),
        _ => None,
    };
    scene
        .nodes
        .iter()
        .filter(|node| of(node).is_some())
        .map(|node| match &node.shape {
            Some(Shape::Mesh(mesh)) => (node.name.as_str(), &**mesh, node.material),
            _ => unreachable!("they have a mesh"),
        })
        .collect()
}

fn bsdf(scene: &Scene, at: usize) -> &Bsdf<kinora_scene::Animated> {
    &scene.materials[at].bsdf
}

#[test]
fn a_mesh_is_of_the_materials_of_its_file() {
    let (scene, warnings) = evaluate("mesh a { file: \"parts/a.obj\", fit: 1m }").expect("a scene");
    assert_eq!(warnings, [], "its own lamp shines");
    let parts = meshes(&scene);
    assert_eq!(
        parts.iter().map(|(name, mesh, _)| (*name, mesh.triangles.len())).collect::<Vec<_>>(),
        [("a", 2), ("lamp", 1), ("glass", 1), ("steel", 1)]
    );
    assert_eq!(parts[0].1.positions[0], Vec3::new(-0.5, -0.5, 0.0), "all of it is fitted at once");
    assert_eq!(scene.nodes.iter().filter(|node| node.parent == Some(0)).count(), 3);

    let wood: &Material<_> = &scene.materials[parts[0].2];
    assert_eq!(wood.opacity.constant(), Some(&0.5));
    let slots: Vec<Slot> = wood.maps.iter().map(|map| map.slot).collect();
    assert_eq!(slots, [Slot::Opacity, Slot::Normal { strength: 1.0 }]);
    let Bsdf::Glossy { base, ior, roughness, .. } = &wood.bsdf else { panic!("{:?}", wood.bsdf) };
    assert!((ior - 1.5).abs() < 1e-9, "the highlight of most programs is 4 %: {ior}");
    assert!((roughness.constant().expect("it rests") - (2.0_f64 / 32.0).powf(0.25)).abs() < 1e-9);
    let map = &scene.materials[*base].maps[0];
    let Texture::Image(picture) = &*map.texture else { panic!("{map:?}") };
    assert_eq!(
        (picture.scale.to_array(), picture.wrap, picture.channel),
        ([2.0, 3.0], [Wrap::Clamp; 2], Channel::Color)
    );
    let Bsdf::Diffuse { color, .. } = bsdf(&scene, *base) else { panic!("matt") };
    assert_eq!(color.constant(), Some(&Vec3::new(0.5, 0.25, 1.0)));

    assert_eq!(scene.materials[parts[1].2].emission, Vec3::new(4.0, 2.0, 0.0));
    assert!(
        matches!(bsdf(&scene, parts[2].2), Bsdf::Dielectric { ior, .. } if ior.constant().is_some_and(|n| (n - 1.4).abs() < 1e-6))
    );
    assert!(matches!(bsdf(&scene, parts[3].2), Bsdf::Glossy { metalness, .. } if metalness.constant() == Some(&1.0)));
}

#[test]
fn the_scene_may_say_what_a_mesh_is_made_of() {
    let text = "metal m { }\nmesh a { file: \"parts/a.obj\", material: m }\nsky { color: #fff }";
    let (scene, _) = evaluate(text).expect("a scene");
    assert_eq!(meshes(&scene).len(), 1);
    assert!(matches!(bsdf(&scene, meshes(&scene)[0].2), Bsdf::Metal { .. }));
}

#[test]
fn a_model_has_a_node_for_each_object() {
    let text = "metal m { }\nmodel a { file: \"parts/a.obj\"\n override \"left\" { material: m } }";
    let (scene, _) = evaluate(text).expect("a scene");
    let parts = meshes(&scene);
    assert_eq!(parts.iter().map(|(name, ..)| *name).collect::<Vec<_>>(), ["left", "right", "right", "right"]);
    assert!(matches!(bsdf(&scene, parts[0].2), Bsdf::Metal { .. }));
}

#[test]
fn colours_of_vertices_are_shown() {
    let (scene, _) = evaluate("mesh a { file: \"colors.ply\" }\nsky { color: #fff }").expect("a scene");
    let (_, mesh, material) = meshes(&scene)[0];
    let half = ((128.0_f32 / 255.0 + 0.055) / 1.055).powf(2.4);
    assert!((mesh.colors[0] - Vec4::new(1.0, 0.0, half, 1.0)).length() < 1e-5, "{:?}", mesh.colors[0]);
    assert!(matches!(&*scene.materials[material].maps[0].texture, Texture::VertexColor { .. }));
    // An arrow head: no triangle lies outside of it.
    assert!(mesh.triangles.iter().all(|t| t.contains(&2)), "{:?}", mesh.triangles);
}
