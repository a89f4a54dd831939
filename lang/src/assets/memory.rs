//! What a scene takes while it is rendered, by what it is made of: said before anything is, since a process that takes more
//! than there is is ended by the system without a word.

use std::collections::HashMap;
use std::sync::Arc;

use kinora_scene::{Image, Paint, Shape, SkyLight, Texture};

use crate::diagnostic::Diagnostic;
use crate::lower::Lowered;
use crate::source::{Span, Texts};

/// A triangle where it is written out in the world: as it is traced, its share of the tree, and what building that takes.
/// Measured of a million: 240.
const TRIANGLE: u64 = 240;
/// A node or a copy, likewise.
const NODE: u64 = 600;
/// Texels lie in the picture and once more for the kernel.
const TIMES_TEXELS: u64 = 2;

/// Something that takes memory.
struct User {
    name: String,
    times: u64,
    bytes: u64,
    span: Option<Span>,
}

/// E1006, where the scene needs more than `limit` bytes: with what takes the most of it.
pub fn judge(lowered: &Lowered, source: &Texts, limit: u64) -> Option<Diagnostic> {
    let mut users = of_geometry(lowered);
    users.extend(of_pictures(lowered));
    let needed = users.iter().fold(0_u64, |sum, user| sum.saturating_add(user.bytes));
    if needed <= limit {
        return None;
    }
    users.sort_by_key(|user| std::cmp::Reverse(user.bytes));
    let gib = |bytes: u64| format!("{:.1} GiB", bytes as f64 / f64::from(1 << 30));
    let mut found = Diagnostic::new("E1006", format!("the scene needs {}, limit {}", gib(needed), gib(limit)));
    if let Some(span) = users.iter().find_map(|user| user.span) {
        found = found.primary(source.id, span, "takes the most of it");
    }
    for User { name, times, bytes, .. } in users.iter().take(3) {
        let often = if *times > 1 { format!(", {times} times") } else { String::new() };
        found = found.note(format!("{name}{often}: {}", gib(*bytes)));
    }
    Some(found.help("what is there many times is there once as an `instance { of: name }`"))
}

fn of_geometry(lowered: &Lowered) -> Vec<User> {
    let scene = &lowered.scene;
    let asked: HashMap<usize, Span> = (lowered.meshes.iter().map(|mesh| (mesh.node, mesh.span)))
        .chain(lowered.models.iter().map(|model| (model.node, model.span)))
        .collect();
    let mut spans: Vec<Option<Span>> = Vec::with_capacity(scene.nodes.len());
    let mut meshes: HashMap<&str, User> = HashMap::new();
    let mut nodes = User { name: "nodes and copies".into(), times: 1, bytes: 0, span: None };
    for (index, node) in scene.nodes.iter().enumerate() {
        // What a file brings moves with the node that asks for it.
        let above = node.parent.and_then(|parent| spans.get(parent).copied().flatten());
        let span = asked.get(&index).copied().or(above);
        spans.push(span);
        let copies = node.copies.as_ref().map_or(0, |copies| copies.at.len() as u64);
        nodes.bytes = nodes.bytes.saturating_add((copies + 1).saturating_mul(NODE));
        if let Some(Shape::Mesh(mesh)) = &node.shape {
            let new = || User { name: format!("`{}`", mesh.name), times: 0, bytes: 0, span };
            let user = meshes.entry(&mesh.name).or_insert_with(new);
            user.times += 1;
            user.bytes = user.bytes.saturating_add((mesh.triangles.len() as u64).saturating_mul(TRIANGLE));
        }
    }
    let mut users: Vec<User> = meshes.into_values().collect();
    users.sort_by(|a, b| a.name.cmp(&b.name));
    users.push(nodes);
    users
}

fn of_pictures(lowered: &Lowered) -> Vec<User> {
    let scene = &lowered.scene;
    let mut images: Vec<&Arc<Image>> = Vec::new();
    let mut open: Vec<&Texture> =
        scene.materials.iter().flat_map(|material| &material.maps).map(|map| &*map.texture).collect();
    while let Some(texture) = open.pop() {
        match texture {
            Texture::Image(picture) => images.push(&picture.image),
            Texture::Checker { a, b, .. } => open.extend([a, b].into_iter().filter_map(|paint| match paint {
                Paint::Texture(inner) => Some(&**inner),
                Paint::Color(_) => None,
            })),
            _ => {}
        }
    }
    images.sort_by_key(|image| Arc::as_ptr(image));
    images.dedup_by_key(|image| Arc::as_ptr(image));
    let mut users: Vec<User> = images.into_iter().map(|image| of_image(image)).collect();
    if let Some(SkyLight::Map { image, .. }) = scene.sky.as_ref().map(|sky| &sky.light) {
        users.push(of_image(image));
    }
    users.sort_by(|a, b| a.name.cmp(&b.name));
    users
}

fn of_image(image: &Image) -> User {
    User { name: format!("`{}`", image.name), times: 1, bytes: TIMES_TEXELS * image.texels().bytes(), span: None }
}
