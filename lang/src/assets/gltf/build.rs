//! The default scene of a document: its nodes in order, what each shows, and each mesh once.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DMat4, DQuat, DVec3};
use kinora_scene::{Mesh, Placing};
use serde_json::Value;

use super::accessor::{Accessor, Buffers};
use super::geometry::{self, Pose, decompose, name_of};
use super::json::{extension, index, list, number, numbers, text};
use super::material::{self, Materials};
use super::table::{follow, is_known};
use super::{Fault, Faults, Images, Lamp, LampKind, Lens, Model, Part, Projection, Warnings};

/// Which primitive, with which coordinates and which pose.
type Key = (String, [usize; 2], Option<usize>);

struct Build<'m, 'b> {
    root: &'m Value,
    buffers: &'m Buffers<'b>,
    nodes: &'m [Value],
    /// Parent of each node of the file, and its matrix in the model; none for nodes outside of the scene.
    worlds: Vec<Option<DMat4>>,
    known: HashMap<Key, Option<Arc<Mesh>>>,
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
    for (at, parent) in order {
        let Some(node) = nodes.get(at) else { continue };
        // What has no thickness in some direction cannot be placed, nor what is in it.
        let singular = geometry::local(node).determinant() == 0.0;
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
    model.nodes = parts;
    model.material_names = names(root, "materials", "material");
    model.clips = names(root, "animations", "animation");
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
    if !list(root, "animations").is_empty() {
        warnings.add("animations", "they stand still for now");
    }
    if !list(root, "skins").is_empty() {
        warnings.add("skins", "they stand still for now, as the nodes are placed");
    }
    if list(root, "meshes").iter().any(|mesh| list(mesh, "primitives").iter().any(|part| part.get("targets").is_some()))
    {
        warnings.add("morph targets", "they stand still for now, with the file's weights");
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
            shape: None,
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
        let joints = self.joints(node)?;
        let skinned = !joints.is_empty();
        let pose = Pose { weights: geometry::weights(node, mesh), joints };
        // What follows its joints does not follow its node.
        let own = (skinned || node.get("weights").is_some()).then_some(at);
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
                own,
            );
            let shape = match self.known.get(&key) {
                Some(known) => known.clone(),
                None => {
                    let made = self.mesh(mesh, mesh_at, primitive, sets, &pose, materials.warnings)?;
                    self.known.insert(key, made.clone());
                    made
                }
            };
            let Some(shape) = shape else { continue };
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
            match parts.get_mut(part) {
                Some(own) if own.shape.is_none() && !skinned => own.shape = shape,
                _ => {
                    let name = format!("{}_{i}", name_of(node, "node", at));
                    let parent = if skinned { None } else { Some(part) };
                    parts.push(Part {
                        name,
                        path: None,
                        parent,
                        placing: Placing::default(),
                        shape,
                        camera: None,
                        light: None,
                    });
                }
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
        pose: &Pose,
        warnings: &mut Warnings,
    ) -> Result<Option<Arc<Mesh>>, Fault> {
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
        self.bytes += geometry::bytes(triangles.len(), vertices.min(3 * triangles.len()));
        if self.bytes > geometry::MESH_BYTES {
            return Err(Fault {
                code: "E0806",
                at: format!("/meshes/{mesh_at}"),
                message: format!("the meshes up to `{name}` take more than {} MiB", geometry::MESH_BYTES >> 20),
                help: "decimate it",
            });
        }
        let mut made = geometry::mesh(self.root, self.buffers, primitive, triangles, sets, pose)?;
        made.name.clone_from(&name);
        made.validate().map_err(|error| Fault {
            code: "E0803",
            at: format!("/meshes/{mesh_at}"),
            message: format!("mesh `{name}`: {error}"),
            help: "export it again",
        })?;
        Ok(Some(Arc::new(made)))
    }

    /// From the mesh in bind pose to the model, for each joint of a node's skin; empty without one.
    fn joints(&self, node: &Value) -> Result<Vec<DMat4>, Fault> {
        let Some((_, skin)) = follow(self.root, "skins", node, "skin") else { return Ok(Vec::new()) };
        let bind =
            index(skin, "inverseBindMatrices").map(|at| Accessor::open(self.root, self.buffers, at)).transpose()?;
        let matrix = |i: usize| match &bind {
            Some(accessor) => DMat4::from_cols_array(&std::array::from_fn(|c| accessor.number(i, c))),
            None => DMat4::IDENTITY,
        };
        let whole = |joint: &Value| super::json::whole(joint).map(|joint| joint as usize);
        let joints = list(skin, "joints").iter().enumerate();
        Ok(joints
            .map(|(i, joint)| {
                let world = whole(joint).and_then(|joint| self.worlds.get(joint).copied().flatten());
                world.unwrap_or(DMat4::IDENTITY) * matrix(i)
            })
            .collect())
    }
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
