//! The default scene of a document: its nodes in order, what each shows, and each mesh once.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, DMat4, DQuat, DVec3};
use kinora_scene::{Mesh, Placing};
use serde_json::Value;

use super::accessor::{Accessor, Buffers};
use super::clip;
use super::geometry::{self, Primitive, decompose, name_of};
use super::json::{extension, index, list, number, numbers, text};
use super::material::{self, Materials};
use super::table::{follow, is_known};
use super::{Bones, Fault, Faults, Images, Lamp, LampKind, Lens, Model, Part, Projection, Rig, Warnings};

/// Which primitive, with which coordinates.
type Key = (String, [usize; 2]);

/// What a node does to a primitive's form, before all nodes have become parts.
struct Loose {
    /// Index of the part that shows it.
    part: usize,
    primitive: Primitive,
    weights: Vec<f64>,
    /// The node of the file, and the part that it became.
    node: usize,
    of: usize,
    skinned: bool,
}

struct Build<'m, 'b> {
    root: &'m Value,
    buffers: &'m Buffers<'b>,
    nodes: &'m [Value],
    /// Parent of each node of the file, and its matrix in the model; none for nodes outside of the scene.
    worlds: Vec<Option<DMat4>>,
    known: HashMap<Key, Option<Primitive>>,
    /// Of primitives whose form a node decides: their meshes at rest.
    rest: HashMap<(Key, usize), Arc<Mesh>>,
    loose: Vec<Loose>,
    bytes: usize,
    /// Roots of the materials, by index and whether vertices have colours.
    roots: HashMap<(Option<usize>, bool), usize>,
}

/// Fills a model.
///
/// # Errors
/// It is too large, or something cannot be read.
pub fn build(
    root: &Value,
    buffers: &Buffers<'_>,
    images: &mut Images<'_, '_>,
    model: &mut Model,
) -> Result<(), Faults> {
    let nodes = list(root, "nodes");
    let mut warnings = Warnings::default();
    unsupported(root, &mut warnings);
    let mut build = Build {
        root,
        buffers,
        nodes,
        worlds: vec![None; nodes.len()],
        known: HashMap::new(),
        rest: HashMap::new(),
        loose: Vec::new(),
        bytes: 0,
        roots: HashMap::new(),
    };
    let order = build.order();
    let mut made = Vec::new();
    std::mem::swap(&mut made, &mut model.materials);
    let mut image = |at: usize| images.get(at);
    let mut materials = Materials { root, made, warnings: &mut warnings, image: &mut image, textures: HashMap::new() };
    let mut parts: Vec<Part> = Vec::new();
    let mut part_of: Vec<Option<usize>> = vec![None; nodes.len()];
    let mut flat = vec![false; nodes.len()];
    let scaled = clip::scaled(root);
    for (at, parent) in order {
        let Some(node) = nodes.get(at) else { continue };
        // What has no thickness in some direction is not seen, nor what is in it, unless a clip makes it larger.
        let singular = geometry::local(node).determinant() == 0.0 && !scaled.contains(&at);
        if singular || parent.is_some_and(|parent| flat[parent]) {
            if singular {
                materials.warnings.add(
                    format!("a scale of 0 (node `{}`)", name_of(node, "node", at)),
                    "the node and what is in it are left out",
                );
            }
            flat[at] = true;
            continue;
        }
        let outer = parent.and_then(|parent| part_of[parent]);
        let path = parent.and_then(|parent| parts.get(part_of[parent]?)?.path.clone());
        let index = build.place(at, node, outer, path, &mut parts, &mut materials);
        part_of[at] = Some(index);
        build.shapes(at, node, index, &mut parts, &mut materials)?;
    }
    model.materials = std::mem::take(&mut materials.made);
    let targets = |node: usize| {
        let mesh = nodes.get(node).and_then(|node| follow(root, "meshes", node, "mesh")).map(|(_, mesh)| mesh);
        mesh.and_then(|mesh| list(mesh, "primitives").first()).map_or(0, |first| list(first, "targets").len())
    };
    model.clips = clip::read(root, buffers, &part_of, targets, materials.warnings);
    if !model.clips.is_empty() {
        build.rigs(&part_of, &mut parts)?;
    }
    model.nodes = parts;
    model.material_names = names(root, "materials", "material");
    model.meshes = list(root, "meshes")
        .iter()
        .enumerate()
        .map(|(i, mesh)| {
            let count = |primitive: &Value| geometry::counts(root, primitive)[1];
            (name_of(mesh, "mesh", i), list(mesh, "primitives").iter().map(count).sum())
        })
        .collect();
    model.warnings = warnings;
    Ok(())
}

fn names(root: &Value, array: &str, kind: &str) -> Vec<String> {
    list(root, array).iter().enumerate().map(|(i, object)| name_of(object, kind, i)).collect()
}

/// What the whole file has and is not read.
fn unsupported(root: &Value, warnings: &mut Warnings) {
    for name in list(root, "extensionsUsed").iter().filter_map(Value::as_str) {
        if !is_known(name) {
            warnings.add(format!("the extension {name}"), "what it says is left out");
        }
    }
    for (i, material) in list(root, "materials").iter().enumerate() {
        let mode = text(material, "alphaMode").unwrap_or("OPAQUE");
        if !["OPAQUE", "MASK", "BLEND"].contains(&mode) {
            warnings.add(format!("alphaMode `{mode}` of material {i}"), "it is opaque");
        }
    }
}

impl Build<'_, '_> {
    /// The nodes of the default scene, parents before their children, with their parents; and where each is.
    fn order(&mut self) -> Vec<(usize, Option<usize>)> {
        let scenes = list(self.root, "scenes");
        let scene = index(self.root, "scene").or(if scenes.is_empty() { None } else { Some(0) });
        let whole = |value: &Value| super::json::whole(value).map(|index| index as usize);
        let roots: Vec<usize> = match scene.and_then(|scene| scenes.get(scene)) {
            Some(scene) => list(scene, "nodes").iter().filter_map(whole).collect(),
            None => {
                let mut inner = vec![false; self.nodes.len()];
                for child in self.nodes.iter().flat_map(|node| list(node, "children")).filter_map(whole) {
                    if let Some(slot) = inner.get_mut(child) {
                        *slot = true;
                    }
                }
                (0..self.nodes.len()).filter(|at| !inner[*at]).collect()
            }
        };
        let mut order = Vec::new();
        let mut open: Vec<(usize, Option<usize>)> = roots.into_iter().rev().map(|root| (root, None)).collect();
        while let Some((at, parent)) = open.pop() {
            let Some(node) = self.nodes.get(at) else { continue };
            let outer = parent.and_then(|parent| self.worlds[parent]).unwrap_or(DMat4::IDENTITY);
            self.worlds[at] = Some(outer * geometry::local(node));
            order.push((at, parent));
            open.extend(list(node, "children").iter().rev().filter_map(whole).map(|child| (child, Some(at))));
        }
        order
    }

    /// Puts a node among the parts; a sheared one is two. Gives the index of the inner one.
    fn place(
        &self,
        at: usize,
        node: &Value,
        outer: Option<usize>,
        path: Option<String>,
        parts: &mut Vec<Part>,
        materials: &mut Materials<'_>,
    ) -> usize {
        let name = name_of(node, "node", at);
        let path = path.map_or_else(|| name.clone(), |outer| format!("{outer}/{name}"));
        let (scales, rotations, position, sheared) = match node.get("matrix") {
            Some(_) => {
                let matrix = geometry::local(node);
                let (scales, rotations, sheared) = decompose(matrix);
                (scales, rotations, matrix.w_axis.truncate(), sheared)
            }
            None => {
                let (scale, rotation, position) = geometry::parts(node);
                ([scale, DVec3::ONE], [rotation, DQuat::IDENTITY], position, false)
            }
        };
        if sheared {
            materials.warnings.add(format!("a sheared matrix (node `{name}`)"), "glTF has none; it is taken as it is");
        }
        let placing = |scale: DVec3, rotation: DQuat, position: DVec3| Placing {
            position: position.into(),
            rotation: rotation.into(),
            scale: scale.into(),
        };
        let camera = follow(self.root, "cameras", node, "camera").map(|(_, camera)| Lens {
            name: text(camera, "name").filter(|name| !name.is_empty()).unwrap_or(&name).to_string(),
            projection: match camera.get("orthographic") {
                Some(lens) => Projection::Orthographic(2.0 * number(lens, "ymag").unwrap_or(1.0).abs()),
                None => {
                    let lens = camera.get("perspective").unwrap_or(&Value::Null);
                    Projection::Perspective(geometry::factor(lens, "yfov", 0.7).min(3.1))
                }
            },
        });
        let light = extension(node, "KHR_lights_punctual")
            .and_then(|light| index(light, "light"))
            .and_then(|light| list(extension(self.root, "KHR_lights_punctual")?, "lights").get(light))
            .and_then(|light| lamp(light, &name, materials.warnings));
        let part = |name: &str, parent, placing| Part {
            name: name.to_string(),
            path: None,
            parent,
            placing,
            of: None,
            shape: None,
            form: None,
            camera: None,
            light: None,
        };
        let mut outer = outer;
        if sheared {
            parts.push(part(&name, outer, placing(scales[0], rotations[0], position)));
            outer = Some(parts.len() - 1);
        }
        let inner = match sheared {
            true => placing(DVec3::ONE, rotations[1], DVec3::ZERO),
            false => placing(scales[0], rotations[0], position),
        };
        parts.push(Part { path: Some(path), camera, light, ..part(&name, outer, inner) });
        parts.len() - 1
    }

    /// Gives a node its mesh: the first primitive is the node's own, others are parts in it.
    fn shapes(
        &mut self,
        at: usize,
        node: &Value,
        part: usize,
        parts: &mut Vec<Part>,
        materials: &mut Materials<'_>,
    ) -> Result<(), Fault> {
        let Some((mesh_at, mesh)) = follow(self.root, "meshes", node, "mesh") else { return Ok(()) };
        let skin = follow(self.root, "skins", node, "skin").map(|(_, skin)| skin);
        let weights = geometry::weights(node, mesh);
        for (i, primitive) in list(mesh, "primitives").iter().enumerate() {
            let material = index(primitive, "material");
            let sets = material::sets(material.and_then(|at| list(self.root, "materials").get(at)));
            let key = (
                format!(
                    "{} {}",
                    primitive.get("attributes").unwrap_or(&Value::Null),
                    index(primitive, "indices").map_or(-1, |at| at as i64)
                ) + &format!(
                    " {} {}",
                    index(primitive, "mode").unwrap_or(4),
                    primitive.get("targets").map_or(0, |_| mesh_at + 1)
                ),
                sets,
            );
            let made = match self.known.get(&key) {
                Some(known) => known.clone(),
                None => {
                    let made = self.mesh(mesh, mesh_at, primitive, sets, materials.warnings)?;
                    self.known.insert(key.clone(), made.clone());
                    made
                }
            };
            let Some(made) = made else { continue };
            let skin = skin.filter(|_| made.influences.is_some());
            let skinned = skin.is_some();
            let still = skin.is_none() && (made.targets.is_empty() || weights.iter().all(|weight| *weight == 0.0));
            let shape = match (still, self.rest.get(&(key.clone(), at))) {
                (true, _) => made.mesh.clone(),
                (false, Some(known)) => known.clone(),
                (false, None) => {
                    let joints = skin.map(|skin| self.joints(skin)).transpose()?;
                    let held = made.influences.as_deref().zip(joints.as_deref());
                    let mesh = Arc::new(made.mesh.formed(&made.targets, &weights, held));
                    sound(&mesh, mesh_at)?;
                    self.rest.insert((key, at), mesh.clone());
                    mesh
                }
            };
            let colored = !shape.colors.is_empty();
            let root = match self.roots.get(&(material, colored)) {
                Some(root) => *root,
                None => {
                    let root = materials.build(material, colored)?;
                    self.roots.insert((material, colored), root);
                    root
                }
            };
            let shape = Some((shape, root));
            let shown = match parts.get_mut(part) {
                Some(own) if own.shape.is_none() && !skinned => {
                    own.shape = shape;
                    part
                }
                _ => {
                    let name = format!("{}_{i}", name_of(node, "node", at));
                    let parent = if skinned { None } else { Some(part) };
                    parts.push(Part {
                        name,
                        path: None,
                        parent,
                        placing: Placing::default(),
                        of: Some(part),
                        shape,
                        form: None,
                        camera: None,
                        light: None,
                    });
                    parts.len() - 1
                }
            };
            if skinned || !made.targets.is_empty() {
                let weights = weights.clone();
                self.loose.push(Loose { part: shown, primitive: made, weights, node: at, of: part, skinned });
            }
        }
        Ok(())
    }

    fn mesh(
        &mut self,
        mesh: &Value,
        mesh_at: usize,
        primitive: &Value,
        sets: [usize; 2],
        warnings: &mut Warnings,
    ) -> Result<Option<Primitive>, Fault> {
        let name = name_of(mesh, "mesh", mesh_at);
        let Some(triangles) = geometry::triangles(self.root, self.buffers, primitive)? else {
            if primitive.get("attributes").is_some_and(|set| set.get("POSITION").is_none()) {
                warnings.add("a primitive without POSITION", "it is left out");
            } else {
                warnings.add("points and lines", "they are left out");
            }
            return Ok(None);
        };
        if triangles.is_empty() {
            return Ok(None);
        }
        let [vertices, _] = geometry::counts(self.root, primitive);
        let targets = list(primitive, "targets").len();
        let vertices = vertices.min(3 * triangles.len());
        self.bytes = self.bytes.saturating_add(geometry::bytes(
            triangles.len(),
            vertices,
            targets,
            geometry::joint_sets(primitive),
        ));
        if self.bytes > geometry::MESH_BYTES {
            return Err(Fault {
                code: "E0806",
                at: format!("/meshes/{mesh_at}"),
                message: format!("the meshes up to `{name}` take more than {} MiB", geometry::MESH_BYTES >> 20),
                help: "decimate it",
            });
        }
        let (mut mesh, targets, influences) = geometry::mesh(self.root, self.buffers, primitive, triangles, sets)?;
        mesh.name = name;
        sound(&mesh, mesh_at)?;
        Ok(Some(Primitive { mesh: Arc::new(mesh), targets: Arc::new(targets), influences: influences.map(Arc::new) }))
    }

    /// From the mesh in bind pose to each joint of a skin.
    fn bind(&self, skin: &Value) -> Result<Vec<DAffine3>, Fault> {
        let bind =
            index(skin, "inverseBindMatrices").map(|at| Accessor::open(self.root, self.buffers, at)).transpose()?;
        let matrix = |i: usize| match &bind {
            Some(accessor) => DMat4::from_cols_array(&std::array::from_fn(|c| accessor.number(i, c))),
            None => DMat4::IDENTITY,
        };
        Ok((0..list(skin, "joints").len()).map(|i| DAffine3::from_mat4(matrix(i))).collect())
    }

    /// From the mesh in bind pose to the model as it is at rest, for each joint of a skin.
    fn joints(&self, skin: &Value) -> Result<Vec<DAffine3>, Fault> {
        let whole = |joint: &Value| super::json::whole(joint).map(|joint| joint as usize);
        let world = |joint: &Value| whole(joint).and_then(|joint| self.worlds.get(joint).copied().flatten());
        let placed = |joint: &Value| world(joint).map_or(DAffine3::IDENTITY, DAffine3::from_mat4);
        let joints = list(skin, "joints").iter().zip(self.bind(skin)?);
        Ok(joints.map(|(joint, bind)| placed(joint) * bind).collect())
    }

    /// What changes forms where clips move them, now that all nodes are parts.
    fn rigs(&mut self, part_of: &[Option<usize>], parts: &mut [Part]) -> Result<(), Fault> {
        let whole = |joint: &Value| super::json::whole(joint).map(|joint| joint as usize);
        let mut binds: HashMap<usize, Arc<Vec<DAffine3>>> = HashMap::new();
        for Loose { part, primitive, weights, node, of, skinned } in std::mem::take(&mut self.loose) {
            let skin = self.nodes.get(node).and_then(|node| follow(self.root, "skins", node, "skin"));
            let skin = match skin.filter(|_| skinned).zip(primitive.influences) {
                Some(((at, skin), influences)) => {
                    let bind = match binds.get(&at) {
                        Some(bind) => bind.clone(),
                        None => binds.entry(at).or_insert(Arc::new(self.bind(skin)?)).clone(),
                    };
                    let joint = |joint: &Value| whole(joint).and_then(|joint| part_of.get(joint).copied().flatten());
                    Some(Bones { joints: list(skin, "joints").iter().map(joint).collect(), bind, influences })
                }
                None => None,
            };
            let rig = Rig { mesh: primitive.mesh, targets: primitive.targets, weights, part: of, skin };
            if let Some(slot) = parts.get_mut(part) {
                slot.form = Some(rig);
            }
        }
        Ok(())
    }
}

/// E0803: a mesh that cannot be shown.
fn sound(mesh: &Mesh, at: usize) -> Result<(), Fault> {
    mesh.validate().map_err(|error| Fault {
        code: "E0803",
        at: format!("/meshes/{at}"),
        message: format!("mesh `{}`: {error}", mesh.name),
        help: "export it again",
    })
}

/// A light of KHR_lights_punctual.
fn lamp(light: &Value, node: &str, warnings: &mut Warnings) -> Option<Lamp> {
    let kind = match text(light, "type")? {
        "directional" => LampKind::Sun,
        "point" => LampKind::Point,
        "spot" => {
            let spot = light.get("spot").unwrap_or(&Value::Null);
            let outer = geometry::factor(spot, "outerConeAngle", std::f64::consts::FRAC_PI_4);
            LampKind::Spot([geometry::factor(spot, "innerConeAngle", 0.0), outer])
        }
        other => {
            warnings.add(format!("a light of type `{other}`"), "it is left out");
            return None;
        }
    };
    if light.get("range").is_some() {
        warnings.add("the range of a light", "it shines as far as light goes");
    }
    Some(Lamp {
        name: text(light, "name").filter(|name| !name.is_empty()).unwrap_or(node).to_string(),
        color: numbers::<3>(light, "color").unwrap_or([1.0; 3]),
        intensity: geometry::factor(light, "intensity", 1.0),
        kind,
    })
}
