//! What no table can say: how the objects of a document fit together, and whether the numbers in the buffers keep what the
//! document promises. After these checks nothing that is read can fail.

use std::collections::{HashMap, HashSet};

use serde_json::Value;

use super::accessor::{self, Accessor, Buffers};
use super::json::{escape, extension, index, list, number, numbers, text};
use super::table::{follow, is_known};
use super::{Fault, Faults};

const AGAIN: &str = "export the model again, or check it with the Khronos glTF validator";

/// Most elements of all accessors together.
const ELEMENTS: u64 = 1 << 27;

/// What may be said before anything is followed: version and extensions.
pub fn asset(root: &Value, faults: &mut Faults) {
    let asset = root.get("asset").unwrap_or(&Value::Null);
    for name in ["version", "minVersion"] {
        let Some(version) = text(asset, name) else { continue };
        let numbers = version
            .split_once('.')
            .and_then(|(major, minor)| Some((major.parse::<u32>().ok()?, minor.parse::<u32>().ok()?)));
        let at = format!("/asset/{name}");
        match numbers {
            None => faults.push(Fault::new(&at, format!("`{version}` is no version of glTF"), AGAIN)),
            Some((2, minor)) if name == "version" || minor == 0 => {}
            Some(_) => faults.push(Fault::new(&at, format!("glTF {version} is not known"), "export it as glTF 2.0")),
        }
    }
    let used: HashSet<&str> = list(root, "extensionsUsed").iter().filter_map(Value::as_str).collect();
    for (i, name) in list(root, "extensionsRequired").iter().enumerate() {
        let Some(name) = name.as_str() else { continue };
        let at = format!("/extensionsRequired/{i}");
        if !used.contains(name) {
            faults.push(Fault::new(&at, format!("`{name}` is not named in `extensionsUsed`"), AGAIN));
        } else if !is_known(name) {
            faults.push(Fault {
                code: "E0802",
                at,
                message: format!("needs {name}, which is not supported"),
                help: match name {
                    "KHR_draco_mesh_compression" | "EXT_meshopt_compression" => "export it again without compression",
                    _ => "export it again without this extension",
                },
            });
        }
    }
}

/// Everything else, as far as it needs no bytes.
pub fn document(root: &Value, faults: &mut Faults) {
    let mut check = Check { root, faults, uses: HashMap::new(), quantized: false };
    check.quantized = list(root, "extensionsUsed").iter().any(|name| name == "KHR_mesh_quantization");
    check.buffer_views();
    check.accessors();
    check.images();
    check.meshes();
    check.nodes();
    check.skins();
    check.animations();
    check.cameras();
    check.lights();
}

struct Check<'c> {
    root: &'c Value,
    faults: &'c mut Faults,
    /// What each buffer view is for, once it is known.
    uses: HashMap<usize, &'static str>,
    quantized: bool,
}

impl<'c> Check<'c> {
    fn report(&mut self, at: impl AsRef<str>, message: impl Into<String>) {
        self.faults.push(Fault::new(at.as_ref(), message, AGAIN));
    }

    fn items(&self, array: &str) -> &'c [Value] {
        list(self.root, array)
    }

    fn use_of(&mut self, view: usize, what: &'static str, at: &str) {
        let before = *self.uses.entry(view).or_insert(what);
        if before != what {
            self.report(at, format!("buffer view {view} is for {before}, and is used for {what} here"));
        }
    }

    fn buffer_views(&mut self) {
        for (i, view) in self.items("bufferViews").iter().enumerate() {
            let at = format!("/bufferViews/{i}");
            let (offset, length) = (index(view, "byteOffset").unwrap_or(0), index(view, "byteLength").unwrap_or(0));
            let total =
                follow(self.root, "buffers", view, "buffer").and_then(|(_, buffer)| index(buffer, "byteLength"));
            if total.is_some_and(|total| offset.checked_add(length).is_none_or(|end| end > total)) {
                self.report(
                    &at,
                    format!(
                        "bytes {offset} to {} of a buffer of {}",
                        offset.saturating_add(length),
                        total.unwrap_or(0)
                    ),
                );
            }
            if let Some(stride) = index(view, "byteStride") {
                if stride % 4 != 0 {
                    self.report(format!("{at}/byteStride"), format!("{stride} is not a multiple of 4"));
                }
                if stride > length {
                    self.report(format!("{at}/byteStride"), format!("{stride} bytes, and the view has {length}"));
                }
            }
            match index(view, "target") {
                Some(34_962) => _ = self.uses.insert(i, "vertices"),
                Some(34_963) => {
                    self.uses.insert(i, "indices");
                    if view.get("byteStride").is_some() {
                        self.report(format!("{at}/byteStride"), "only views of vertices have a stride");
                    }
                }
                _ => {}
            }
        }
    }

    fn accessors(&mut self) {
        let mut elements = 0_u64;
        for (i, accessor) in self.items("accessors").iter().enumerate() {
            let at = format!("/accessors/{i}");
            let count = index(accessor, "count").unwrap_or(0);
            elements = elements.saturating_add(count as u64);
            // Some exporters write the offset 0 of what is sparse alone.
            let harmless = accessor.get("sparse").is_some() && index(accessor, "byteOffset") == Some(0);
            if accessor.get("byteOffset").is_some() && accessor.get("bufferView").is_none() && !harmless {
                self.report(format!("{at}/byteOffset"), "an offset without a `bufferView`");
            }
            let Some(layout) = accessor::layout(accessor) else { continue };
            if accessor.get("normalized") == Some(&Value::Bool(true)) && !layout.component.may_be_normalized() {
                self.report(format!("{at}/normalized"), "only bytes and shorts can be normalized");
            }
            for name in ["min", "max"] {
                let bounds = list(accessor, name).len();
                if accessor.get(name).is_some() && bounds != layout.components {
                    let message = format!("{} numbers are expected, found {bounds}", layout.components);
                    self.report(format!("{at}/{name}"), message);
                }
            }
            if let Some((_, view)) = follow(self.root, "bufferViews", accessor, "bufferView") {
                self.fits(&at, accessor, view, layout.columns > 1, layout.size(), layout.component.size(), count);
            }
            let Some(sparse) = accessor.get("sparse") else { continue };
            let at = format!("{at}/sparse");
            let changed = index(sparse, "count").unwrap_or(0);
            if changed > count {
                self.report(format!("{at}/count"), format!("changes {changed} elements of {count}"));
            }
            for (name, size, component) in
                [("indices", None, None), ("values", Some(layout.size()), Some(layout.component.size()))]
            {
                let part = sparse.get(name).unwrap_or(&Value::Null);
                let at = format!("{at}/{name}");
                let index_size = index(part, "componentType").and_then(accessor::index_size);
                if name == "indices" && index_size.is_none() {
                    self.report(format!("{at}/componentType"), "indices are unsigned bytes, shorts or ints");
                    continue;
                }
                let Some((_, view)) = follow(self.root, "bufferViews", part, "bufferView") else { continue };
                if view.get("byteStride").is_some() {
                    self.report(format!("{at}/bufferView"), "only views of vertices have a stride");
                }
                if view.get("target").is_some() {
                    self.report(format!("{at}/bufferView"), "a view of sparse values has no `target`");
                }
                let (size, component) = (size.or(index_size).unwrap_or(1), component.or(index_size).unwrap_or(1));
                self.fits(&at, part, view, false, size, component, changed);
            }
        }
        if elements > ELEMENTS {
            let message = format!("the accessors have {} M elements, limit {} M", elements >> 20, ELEMENTS >> 20);
            self.faults.push(Fault { code: "E0806", at: "/accessors".into(), message, help: "decimate it" });
        }
    }

    /// Whether `count` elements lie in a view, and where they may.
    #[allow(clippy::too_many_arguments)]
    fn fits(
        &mut self,
        at: &str,
        part: &Value,
        view: &Value,
        matrix: bool,
        size: usize,
        component: usize,
        count: usize,
    ) {
        let offset = index(part, "byteOffset").unwrap_or(0);
        let total = index(view, "byteOffset").unwrap_or(0).saturating_add(offset);
        if !total.is_multiple_of(component) || !offset.is_multiple_of(component) {
            self.report(
                format!("{at}/byteOffset"),
                format!("byte {total} of the buffer is not a multiple of {component}"),
            );
        } else if matrix && !total.is_multiple_of(4) {
            self.report(format!("{at}/byteOffset"), "matrices begin at multiples of 4 bytes");
        }
        let stride = index(view, "byteStride").unwrap_or(size);
        if stride < size {
            self.report(at, format!("elements of {size} bytes every {stride} bytes"));
        }
        let length = index(view, "byteLength").unwrap_or(0);
        let end =
            count.saturating_sub(1).checked_mul(stride).and_then(|last| last.checked_add(size)?.checked_add(offset));
        if end.is_none_or(|end| end > length) {
            let message =
                format!("{count} elements of {size} bytes from byte {offset} do not fit in a view of {length} bytes");
            self.faults.push(Fault { code: "E0803", at: at.to_string(), message, help: AGAIN });
        }
    }

    fn images(&mut self) {
        for (i, image) in self.items("images").iter().enumerate() {
            let at = format!("/images/{i}");
            match (image.get("uri"), index(image, "bufferView")) {
                (Some(_), Some(_)) => self.report(&at, "has both `uri` and `bufferView`"),
                (None, None) => self.report(&at, "has neither `uri` nor `bufferView`"),
                (None, Some(view)) => {
                    if image.get("mimeType").is_none() {
                        self.report(&at, "`mimeType` is missing");
                    }
                    self.use_of(view, "an image", &format!("{at}/bufferView"));
                    if self.items("bufferViews").get(view).is_some_and(|view| view.get("byteStride").is_some()) {
                        self.report(format!("{at}/bufferView"), "only views of vertices have a stride");
                    }
                }
                (Some(_), None) => {}
            }
        }
    }

    fn meshes(&mut self) {
        // Accessors by buffer view without a stride: several need one.
        let mut sharing: HashMap<usize, usize> = HashMap::new();
        for (i, mesh) in self.items("meshes").iter().enumerate() {
            let at = format!("/meshes/{i}");
            let primitives = list(mesh, "primitives");
            let targets = |primitive: &Value| list(primitive, "targets").len();
            let first = primitives.first().map_or(0, targets);
            for (j, primitive) in primitives.iter().enumerate() {
                let at = format!("{at}/primitives/{j}");
                if targets(primitive) != first {
                    self.report(
                        format!("{at}/targets"),
                        "all primitives of a mesh have the same number of morph targets",
                    );
                }
                self.primitive(primitive, &at, &mut sharing);
            }
            let weights = list(mesh, "weights").len();
            if mesh.get("weights").is_some() && weights != first {
                self.report(format!("{at}/weights"), format!("{weights} weights for {first} morph targets"));
            }
        }
    }

    fn primitive(&mut self, primitive: &'c Value, at: &str, sharing: &mut HashMap<usize, usize>) {
        let empty = serde_json::Map::new();
        let attributes = primitive.get("attributes").and_then(Value::as_object).unwrap_or(&empty);
        let count_of = |check: &Self, name: &Value| {
            let accessor = check
                .items("accessors")
                .get(usize::try_from(name.as_u64().or_else(|| super::json::whole(name))?).ok()?)?;
            index(accessor, "count")
        };
        let count =
            attributes.get("POSITION").or_else(|| attributes.values().next()).and_then(|name| count_of(self, name));
        for (name, accessor) in attributes {
            let at = format!("{at}/attributes/{}", escape(name));
            self.attribute(name, accessor, &at, false, sharing);
            let own = count_of(self, accessor);
            if own != count {
                let message =
                    format!("{} elements, and another attribute has {}", own.unwrap_or(0), count.unwrap_or(0));
                self.report(&at, message);
            }
        }
        let numbered = |prefix: &str| {
            attributes
                .keys()
                .filter(|name| name.strip_prefix(prefix).is_some_and(|rest| canonical(rest).is_some()))
                .count()
        };
        for prefix in ["TEXCOORD_", "COLOR_", "JOINTS_", "WEIGHTS_"] {
            let count = numbered(prefix);
            if let Some(missing) = (0..count).find(|i| !attributes.contains_key(&format!("{prefix}{i}"))) {
                self.report(
                    format!("{at}/attributes"),
                    format!("{prefix}{missing} is missing, and there are higher ones"),
                );
            }
        }
        if numbered("JOINTS_") != numbered("WEIGHTS_") {
            self.report(format!("{at}/attributes"), "as many `JOINTS_` as `WEIGHTS_` are expected");
        }
        if let Some((accessor_index, accessor)) = follow(self.root, "accessors", primitive, "indices") {
            let at = format!("{at}/indices");
            let layout = accessor::layout(accessor);
            let fits = layout.is_some_and(|layout| {
                layout.components == 1 && index(accessor, "componentType").and_then(accessor::index_size).is_some()
            });
            if !fits || accessor.get("normalized") == Some(&Value::Bool(true)) {
                self.report(
                    &at,
                    format!("indices are unsigned bytes, shorts or ints, and accessor {accessor_index} is not"),
                );
            }
            if let Some((view_index, view)) = follow(self.root, "bufferViews", accessor, "bufferView") {
                if view.get("byteStride").is_some() {
                    self.report(&at, "a buffer view of indices has no stride");
                }
                self.use_of(view_index, "indices", &at);
            }
        }
        for (k, target) in list(primitive, "targets").iter().enumerate() {
            for (name, accessor) in target.as_object().unwrap_or(&empty) {
                let at = format!("{at}/targets/{k}/{}", escape(name));
                self.attribute(name, accessor, &at, true, sharing);
                if !attributes.contains_key(name) {
                    self.report(&at, format!("the mesh has no {name} to change"));
                } else if count_of(self, accessor) != count {
                    self.report(&at, "has another number of elements than what it changes");
                }
            }
        }
        if let Some((_, material)) = follow(self.root, "materials", primitive, "material") {
            let mut wanted = Vec::new();
            coordinates(material, "", &mut wanted);
            for (set, texture) in wanted {
                if !attributes.contains_key(&format!("TEXCOORD_{set}")) {
                    self.report(
                        format!("{at}/material"),
                        format!("{texture} of its material needs TEXCOORD_{set}, which is missing"),
                    );
                }
            }
        }
    }

    fn attribute(&mut self, name: &str, accessor: &Value, at: &str, morph: bool, sharing: &mut HashMap<usize, usize>) {
        let custom = name.starts_with('_');
        let wanted = if custom { Some("") } else { semantic(name, morph) };
        let Some(wanted) = wanted else {
            self.report(at, format!("{name} is no attribute of glTF; the name of an own one begins with `_`"));
            return;
        };
        let Some(accessor_index) = super::json::whole(accessor).map(|index| index as usize) else { return };
        let Some(accessor) = self.items("accessors").get(accessor_index) else { return };
        if index(accessor, "componentType") == Some(5125) {
            self.report(at, "attributes cannot be unsigned ints");
        }
        if !custom && !self.has_format(accessor, wanted) {
            let kind = text(accessor, "type").unwrap_or("?");
            let component = index(accessor, "componentType").unwrap_or(0);
            self.report(at, format!("{name} cannot be a {kind} of component type {component}"));
        }
        if wanted == "POSITION" && (accessor.get("min").is_none() || accessor.get("max").is_none()) {
            self.report(at, "an accessor of POSITION has `min` and `max`");
        }
        let Some((view_index, view)) = follow(self.root, "bufferViews", accessor, "bufferView") else { return };
        self.use_of(view_index, "vertices", at);
        let offset = index(accessor, "byteOffset").unwrap_or(0);
        let size = accessor::layout(accessor).map_or(4, |layout| layout.size());
        let stride = index(view, "byteStride");
        let many = index(accessor, "count").unwrap_or(0) > 1;
        if !offset.is_multiple_of(4)
            || !index(view, "byteOffset").unwrap_or(0).is_multiple_of(4)
            || (many && !stride.unwrap_or(size).is_multiple_of(4))
        {
            self.report(at, "vertices lie at multiples of 4 bytes");
        }
        if stride.is_none() && *sharing.entry(view_index).or_insert(accessor_index) != accessor_index {
            self.report(at, format!("buffer view {view_index} has several attributes and no `byteStride`"));
        }
    }

    fn has_format(&self, accessor: &Value, semantic: &str) -> bool {
        let kind = text(accessor, "type").unwrap_or("");
        let component = index(accessor, "componentType").unwrap_or(0);
        let normalized = accessor.get("normalized") == Some(&Value::Bool(true));
        let (byte, ubyte, short, ushort, float) = (5120, 5121, 5122, 5123, 5126);
        let quantized = self.quantized;
        let unsigned = component == float || (normalized && [ubyte, ushort].contains(&component));
        let signed = component == float || (quantized && normalized && [byte, short].contains(&component));
        let small = component == float || (quantized && [byte, ubyte, short, ushort].contains(&component));
        match semantic {
            "POSITION" => kind == "VEC3" && small,
            // Morph targets are differences.
            "CHANGE" => kind == "VEC3" && (signed || small),
            "NORMAL" => kind == "VEC3" && signed,
            "TANGENT" => kind == "VEC4" && signed,
            "TEXCOORD" => kind == "VEC2" && (unsigned || small),
            "COLOR" => (kind == "VEC3" || kind == "VEC4") && unsigned,
            "COLOR CHANGE" => kind == "VEC3" || kind == "VEC4",
            "JOINTS" => kind == "VEC4" && [ubyte, ushort].contains(&component) && !normalized,
            "WEIGHTS" => kind == "VEC4" && unsigned,
            _ => true,
        }
    }

    fn nodes(&mut self) {
        let nodes = self.items("nodes");
        let mut parent: Vec<Option<usize>> = vec![None; nodes.len()];
        for (i, node) in nodes.iter().enumerate() {
            let at = format!("/nodes/{i}");
            for (k, child) in list(node, "children").iter().enumerate() {
                let Some(child) = super::json::whole(child).map(|child| child as usize) else { continue };
                match parent.get_mut(child) {
                    Some(slot @ None) => *slot = Some(i),
                    Some(Some(_)) => {
                        self.report(
                            format!("{at}/children/{k}"),
                            format!("node {child} is a child of another node already"),
                        );
                    }
                    None => {}
                }
            }
            self.node(node, &at);
        }
        // Every node has one parent at most: whoever does not reach a root is on a circle, or below one.
        let mut good = vec![false; nodes.len()];
        for start in 0..nodes.len() {
            let (mut path, mut at, mut on) = (Vec::new(), Some(start), HashSet::new());
            while let Some(here) = at.filter(|here| !good[*here]) {
                if !on.insert(here) {
                    self.report(format!("/nodes/{here}"), "a node is its own ancestor");
                    break;
                }
                path.push(here);
                at = parent[here];
            }
            for here in path {
                good[here] = true;
            }
        }
        for (i, scene) in self.items("scenes").iter().enumerate() {
            for (k, node) in list(scene, "nodes").iter().enumerate() {
                let inner = super::json::whole(node).and_then(|node| parent.get(node as usize).copied().flatten());
                if let Some(outer) = inner {
                    self.report(
                        format!("/scenes/{i}/nodes/{k}"),
                        format!("node {node} is a child of node {outer}, not a root"),
                    );
                }
            }
        }
    }

    fn node(&mut self, node: &Value, at: &str) {
        let placed = ["translation", "rotation", "scale"].iter().any(|name| node.get(name).is_some());
        if let Some(matrix) = numbers::<16>(node, "matrix") {
            let at = format!("{at}/matrix");
            if placed {
                self.report(&at, "has both a matrix and a translation, rotation or scale");
            }
            if matrix[3] != 0.0 || matrix[7] != 0.0 || matrix[11] != 0.0 || matrix[15] != 1.0 {
                self.report(&at, "the last row of the matrix is not 0 0 0 1");
            }
        }
        if let Some(rotation) = numbers::<4>(node, "rotation") {
            let length = rotation.iter().map(|part| part * part).sum::<f64>().sqrt();
            // As the Khronos validator: what four numbers of a byte each can miss.
            if (length - 1.0).abs() > 0.007_69 {
                self.report(format!("{at}/rotation"), format!("the quaternion has length {length:.4}, not 1"));
            }
        }
        let mesh = follow(self.root, "meshes", node, "mesh").map(|(_, mesh)| mesh);
        for name in ["skin", "weights"] {
            if node.get(name).is_some() && mesh.is_none() {
                self.report(format!("{at}/{name}"), format!("`{name}` without a `mesh`"));
            }
        }
        let Some(mesh) = mesh else { return };
        let primitives = list(mesh, "primitives");
        let targets = primitives.first().map_or(0, |primitive| list(primitive, "targets").len());
        let weights = list(node, "weights").len();
        if node.get("weights").is_some() && weights != targets {
            self.report(format!("{at}/weights"), format!("{weights} weights for {targets} morph targets"));
        }
        let skinned = |primitive: &Value| primitive.get("attributes").is_some_and(|set| set.get("JOINTS_0").is_some());
        if node.get("skin").is_some() && !primitives.iter().any(skinned) {
            self.report(at, "has a skin, and its mesh has no joints");
        }
    }

    fn skins(&mut self) {
        for (i, skin) in self.items("skins").iter().enumerate() {
            let Some((_, accessor)) = follow(self.root, "accessors", skin, "inverseBindMatrices") else { continue };
            let at = format!("/skins/{i}/inverseBindMatrices");
            if text(accessor, "type") != Some("MAT4") || index(accessor, "componentType") != Some(5126) {
                self.report(&at, "must be matrices of floats");
            }
            if index(accessor, "count").unwrap_or(0) < list(skin, "joints").len() {
                self.report(&at, "there are fewer matrices than joints");
            }
        }
    }

    fn animations(&mut self) {
        for (i, animation) in self.items("animations").iter().enumerate() {
            let at = format!("/animations/{i}");
            let samplers = list(animation, "samplers");
            let mut targets = HashSet::new();
            for (k, channel) in list(animation, "channels").iter().enumerate() {
                let at = format!("{at}/channels/{k}");
                if index(channel, "sampler").is_some_and(|sampler| sampler >= samplers.len()) {
                    self.report(format!("{at}/sampler"), format!("the animation has {} samplers", samplers.len()));
                }
                let target = channel.get("target").unwrap_or(&Value::Null);
                let (node, path) = (index(target, "node"), text(target, "path").unwrap_or(""));
                if node.is_some() && !targets.insert((node, path)) {
                    self.report(format!("{at}/target"), "another channel moves the same");
                }
                let target = node.and_then(|node| self.items("nodes").get(node));
                if path != "weights" && target.is_some_and(|node| node.get("matrix").is_some()) {
                    self.report(format!("{at}/target/node"), "a node with a matrix cannot be moved");
                }
                if let (Some(target), Some(k)) = (target, index(channel, "sampler")) {
                    self.moved(target, path, samplers.get(k), &at, &format!("/animations/{i}/samplers/{k}"));
                }
            }
            for (k, sampler) in samplers.iter().enumerate() {
                let at = format!("{at}/samplers/{k}");
                let Some((_, input)) = follow(self.root, "accessors", sampler, "input") else { continue };
                let Some((_, output)) = follow(self.root, "accessors", sampler, "output") else { continue };
                if text(input, "type") != Some("SCALAR") || index(input, "componentType") != Some(5126) {
                    self.report(format!("{at}/input"), "times are floats");
                }
                if input.get("min").is_none() || input.get("max").is_none() {
                    self.report(format!("{at}/input"), "an accessor of times has `min` and `max`");
                }
                let (times, values) = (index(input, "count").unwrap_or(0), index(output, "count").unwrap_or(0));
                let each = if text(sampler, "interpolation") == Some("CUBICSPLINE") { 3 } else { 1 };
                if each == 3 && times == 1 {
                    self.report(format!("{at}/input"), "a cubic spline has two keys or more");
                }
                if times > 0 && values < times.saturating_mul(each) {
                    self.report(format!("{at}/output"), format!("{values} values for {times} times"));
                }
            }
        }
    }

    /// Whether the values of a sampler are what a channel of this path moves.
    fn moved(&mut self, node: &Value, path: &str, sampler: Option<&Value>, at: &str, sampler_at: &str) {
        let Some(sampler) = sampler else { return };
        let Some((_, input)) = follow(self.root, "accessors", sampler, "input") else { return };
        let Some((_, output)) = follow(self.root, "accessors", sampler, "output") else { return };
        let kind = match path {
            "translation" | "scale" => "VEC3",
            "rotation" => "VEC4",
            "weights" => "SCALAR",
            // For extensions.
            _ => return,
        };
        let mut each = if text(sampler, "interpolation") == Some("CUBICSPLINE") { 3 } else { 1 };
        if path == "weights" {
            let mesh = follow(self.root, "meshes", node, "mesh").map(|(_, mesh)| mesh);
            let first = mesh.and_then(|mesh| list(mesh, "primitives").first());
            let targets = first.map_or(0, |primitive| list(primitive, "targets").len());
            if targets == 0 {
                return self.report(format!("{at}/target"), "the node's mesh has no morph targets to weigh");
            }
            each *= targets;
        }
        let code = index(output, "componentType").unwrap_or(0);
        let whole = output.get("normalized") == Some(&Value::Bool(true)) && (5120..=5123).contains(&code);
        if text(output, "type") != Some(kind) || !(code == 5126 || whole && kind != "VEC3") {
            let found = text(output, "type").unwrap_or("?");
            let message = format!("a {path} cannot be a {found} of component type {code}");
            self.report(format!("{sampler_at}/output"), message);
        }
        let (times, values) = (index(input, "count").unwrap_or(0), index(output, "count").unwrap_or(0));
        if values > times.saturating_mul(each) || path == "weights" && values != times.saturating_mul(each) {
            let message = format!("{values} values for {times} times, {} are expected", times.saturating_mul(each));
            self.report(format!("{sampler_at}/output"), message);
        }
    }

    fn cameras(&mut self) {
        for (i, camera) in self.items("cameras").iter().enumerate() {
            let at = format!("/cameras/{i}");
            let kind = text(camera, "type").unwrap_or("");
            if ["perspective", "orthographic"].contains(&kind) && camera.get(kind).is_none() {
                self.report(&at, format!("`{kind}` is missing"));
            }
            if camera.get("perspective").is_some() && camera.get("orthographic").is_some() {
                self.report(&at, "is perspective and orthographic at once");
            }
            for kind in ["perspective", "orthographic"] {
                let Some(lens) = camera.get(kind) else { continue };
                let (near, far) = (number(lens, "znear"), number(lens, "zfar"));
                if near.zip(far).is_some_and(|(near, far)| far <= near) {
                    self.report(format!("{at}/{kind}/zfar"), "must be greater than `znear`");
                }
                for name in ["xmag", "ymag"] {
                    if number(lens, name) == Some(0.0) {
                        self.report(format!("{at}/{kind}/{name}"), "must not be 0");
                    }
                }
            }
        }
    }

    fn lights(&mut self) {
        let lights = extension(self.root, "KHR_lights_punctual").map_or(&[][..], |root| list(root, "lights"));
        for (i, light) in lights.iter().enumerate() {
            let at = format!("/extensions/KHR_lights_punctual/lights/{i}");
            let kind = text(light, "type").unwrap_or("");
            if kind == "spot" && light.get("spot").is_none() {
                self.report(&at, "`spot` is missing");
            }
            if let Some(spot) = light.get("spot") {
                let inner = number(spot, "innerConeAngle").unwrap_or(0.0);
                let outer = number(spot, "outerConeAngle").unwrap_or(std::f64::consts::FRAC_PI_4);
                if inner >= outer {
                    self.report(format!("{at}/spot"), "`innerConeAngle` must be less than `outerConeAngle`");
                }
            }
        }
        for (i, node) in self.items("nodes").iter().enumerate() {
            let Some(light) = extension(node, "KHR_lights_punctual") else { continue };
            let at = format!("/nodes/{i}/extensions/KHR_lights_punctual/light");
            match index(light, "light") {
                None => self.report(&at, "`light` is missing"),
                Some(light) if light >= lights.len() => {
                    self.report(&at, format!("index {light}, and the file has {} lights", lights.len()));
                }
                Some(_) => {}
            }
        }
    }
}

/// What an attribute of that name must be like; none for a name that glTF does not know.
fn semantic(name: &str, morph: bool) -> Option<&'static str> {
    if let ("POSITION" | "NORMAL" | "TANGENT", true) = (name, morph) {
        return Some(if name == "POSITION" { "POSITION" } else { "CHANGE" });
    }
    match name {
        "POSITION" => return Some("POSITION"),
        "NORMAL" => return Some("NORMAL"),
        "TANGENT" => return Some("TANGENT"),
        _ => {}
    }
    let (prefix, number) = name.split_once('_')?;
    canonical(number)?;
    match (prefix, morph) {
        ("TEXCOORD", _) => Some("TEXCOORD"),
        ("COLOR", false) => Some("COLOR"),
        ("COLOR", true) => Some("COLOR CHANGE"),
        ("JOINTS", false) => Some("JOINTS"),
        ("WEIGHTS", false) => Some("WEIGHTS"),
        _ => None,
    }
}

/// A number as attributes have it: without leading zeros.
fn canonical(digits: &str) -> Option<u32> {
    let number: u32 = digits.parse().ok()?;
    (number.to_string() == digits).then_some(number)
}

/// The sets of texture coordinates that a material asks for, with the name of the texture.
pub fn coordinates(value: &Value, name: &str, found: &mut Vec<(usize, String)>) {
    let Some(map) = value.as_object() else { return };
    if name.ends_with("Texture") && map.contains_key("index") {
        let moved = extension(value, "KHR_texture_transform").and_then(|moved| index(moved, "texCoord"));
        found.push((moved.or_else(|| index(value, "texCoord")).unwrap_or(0), name.to_string()));
    }
    for (name, value) in map {
        if name != "extras" {
            coordinates(value, name, found);
        }
    }
}

/// What is in the buffers: finite numbers within the bounds that the document gives, indices of vertices that are there.
pub fn content(root: &Value, buffers: &Buffers<'_>, faults: &mut Faults) {
    for (i, accessor) in list(root, "accessors").iter().enumerate() {
        if accessor.get("bufferView").is_none() && accessor.get("sparse").is_none() {
            continue;
        }
        let at = format!("/accessors/{i}");
        let open = match Accessor::open(root, buffers, i) {
            Ok(open) => open,
            // Of unknown kind: only who uses it has a problem.
            Err(_) => continue,
        };
        if let Some(fault) = open.fault(accessor, &at) {
            faults.push(fault);
        }
    }
    let mut seen = HashSet::new();
    for (i, animation) in list(root, "animations").iter().enumerate() {
        for (k, sampler) in list(animation, "samplers").iter().enumerate() {
            let Some(input) = index(sampler, "input").filter(|input| seen.insert((*input, usize::MAX))) else {
                continue;
            };
            let Ok(open) = Accessor::open(root, buffers, input) else { continue };
            let at = format!("/animations/{i}/samplers/{k}/input");
            let time = |key: usize| open.number(key, 0);
            if open.count > 0 && time(0) < 0.0 {
                faults.push(Fault::new(&at, format!("the first key is at {} s, before the beginning", time(0)), AGAIN));
            }
            let late = (1..open.count).find(|key| time(*key) <= time(key - 1));
            if let Some(key) = late {
                let message = format!("the key at {} s comes after the key at {} s", time(key), time(key - 1));
                faults.push(Fault::new(&at, message, AGAIN));
            }
        }
    }
    for (i, mesh) in list(root, "meshes").iter().enumerate() {
        for (j, primitive) in list(mesh, "primitives").iter().enumerate() {
            let Some(indices) = index(primitive, "indices") else { continue };
            let at = format!("/meshes/{i}/primitives/{j}/indices");
            let position = primitive.get("attributes").and_then(|attributes| index(attributes, "POSITION"));
            let Some(count) = position.and_then(|at| index(list(root, "accessors").get(at)?, "count")) else {
                continue;
            };
            if !seen.insert((indices, count)) {
                continue;
            }
            let Ok(open) = Accessor::open(root, buffers, indices) else { continue };
            if let Some(vertex) = (0..open.count).map(|k| open.whole(k)).find(|vertex| *vertex as usize >= count) {
                let name = text(mesh, "name").map_or_else(|| i.to_string(), |name| format!("`{name}`"));
                faults.push(Fault {
                    code: "E0803",
                    at,
                    message: format!("mesh {name} refers to vertex {vertex} of {count}"),
                    help: AGAIN,
                });
            }
        }
    }
}
