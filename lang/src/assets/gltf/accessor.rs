//! Numbers in buffers: strides, component types, normalized integers, sparse changes.

use std::sync::Arc;

use serde_json::Value;

use super::container::{self, Parts, Uri};
use super::json::{index, list, text};
use super::{Fault, Faults};
use crate::files::Files;

/// What a component is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Component {
    /// 5120
    Byte,
    /// 5121
    UnsignedByte,
    /// 5122
    Short,
    /// 5123
    UnsignedShort,
    /// 5125
    UnsignedInt,
    /// 5126
    Float,
}

impl Component {
    fn of(code: usize) -> Option<Component> {
        Some(match code {
            5120 => Component::Byte,
            5121 => Component::UnsignedByte,
            5122 => Component::Short,
            5123 => Component::UnsignedShort,
            5125 => Component::UnsignedInt,
            5126 => Component::Float,
            _ => return None,
        })
    }

    /// Bytes.
    pub fn size(self) -> usize {
        match self {
            Component::Byte | Component::UnsignedByte => 1,
            Component::Short | Component::UnsignedShort => 2,
            Component::UnsignedInt | Component::Float => 4,
        }
    }

    /// Bytes and shorts may stand for 0..1 or -1..1.
    pub fn may_be_normalized(self) -> bool {
        self.size() < 4
    }

    fn read(self, bytes: &[u8]) -> f64 {
        match (self, bytes) {
            (Component::Byte, [a, ..]) => f64::from(*a as i8),
            (Component::UnsignedByte, [a, ..]) => f64::from(*a),
            (Component::Short, [a, b, ..]) => f64::from(i16::from_le_bytes([*a, *b])),
            (Component::UnsignedShort, [a, b, ..]) => f64::from(u16::from_le_bytes([*a, *b])),
            (Component::UnsignedInt, [a, b, c, d, ..]) => f64::from(u32::from_le_bytes([*a, *b, *c, *d])),
            (Component::Float, [a, b, c, d, ..]) => f64::from(f32::from_le_bytes([*a, *b, *c, *d])),
            _ => 0.0,
        }
    }

    fn normalize(self, value: f64) -> f64 {
        match self {
            Component::Byte => (value / 127.0).max(-1.0),
            Component::UnsignedByte => value / 255.0,
            Component::Short => (value / 32767.0).max(-1.0),
            Component::UnsignedShort => value / 65535.0,
            _ => value,
        }
    }
}

/// Bytes of an index of this component type; none where indices cannot have it.
pub fn index_size(code: usize) -> Option<usize> {
    [5121, 5123, 5125].contains(&code).then(|| Component::of(code)).flatten().map(Component::size)
}

/// How an element lies in memory.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    /// Of each number.
    pub component: Component,
    /// How many numbers.
    pub components: usize,
    /// 1, of a matrix more: each begins at a multiple of 4 bytes.
    pub columns: usize,
}

impl Layout {
    fn column(&self) -> usize {
        let bytes = self.components / self.columns * self.component.size();
        if self.columns > 1 { bytes.next_multiple_of(4) } else { bytes }
    }

    /// Bytes of an element. The last column of a matrix needs no padding behind it.
    pub fn size(&self) -> usize {
        self.column() * self.columns
    }
}

/// The layout of an accessor; none where its type or component type is not one of glTF's.
pub fn layout(accessor: &Value) -> Option<Layout> {
    let (components, columns) = match text(accessor, "type")? {
        "SCALAR" => (1, 1),
        "VEC2" => (2, 1),
        "VEC3" => (3, 1),
        "VEC4" => (4, 1),
        "MAT2" => (4, 2),
        "MAT3" => (9, 3),
        "MAT4" => (16, 4),
        _ => return None,
    };
    Some(Layout { component: Component::of(index(accessor, "componentType")?)?, components, columns })
}

/// The bytes of all buffers.
pub struct Buffers<'b> {
    buffers: Vec<Result<Bytes<'b>, Fault>>,
}

enum Bytes<'b> {
    Chunk(&'b [u8]),
    File(Arc<[u8]>),
    Own(Vec<u8>),
}

impl Bytes<'_> {
    fn get(&self) -> &[u8] {
        match self {
            Bytes::Chunk(bytes) => bytes,
            Bytes::File(bytes) => bytes,
            Bytes::Own(bytes) => bytes,
        }
    }
}

impl<'b> Buffers<'b> {
    /// Reads the buffers of a document; `name` is the model's path from the project's root. What cannot be read is a
    /// fault at once, but for what lies elsewhere on purpose: that is one only where it is used.
    pub fn read(parts: &Parts<'b>, name: &str, files: &dyn Files, faults: &mut Faults) -> Buffers<'b> {
        let mut buffers = Vec::new();
        for (i, buffer) in list(&parts.root, "buffers").iter().enumerate() {
            let at = format!("/buffers/{i}");
            let read = Buffers::one(parts, buffer, i, &at, name, files);
            let length = index(buffer, "byteLength").unwrap_or(0);
            let read = read.and_then(|bytes| match bytes.get().len() {
                found if found < length => {
                    Err(Fault::new(&at, format!("says {length} bytes, and has {found}"), "export the model again"))
                }
                _ => Ok(bytes),
            });
            if let Err(fault) = &read
                && fault.code != "E0704"
                && !fault.at.is_empty()
            {
                faults.push(fault.clone());
            }
            buffers.push(read);
        }
        Buffers { buffers }
    }

    fn one(
        parts: &Parts<'b>,
        buffer: &Value,
        i: usize,
        at: &str,
        name: &str,
        files: &dyn Files,
    ) -> Result<Bytes<'b>, Fault> {
        let Some(written) = text(buffer, "uri") else {
            return match (parts.chunk, parts.binary, i) {
                (Some(chunk), true, 0) => Ok(Bytes::Chunk(chunk)),
                (None, true, 0) => {
                    Err(Fault::new(at, "has no `uri`, and the GLB no BIN chunk", "export the model again"))
                }
                // For an extension to fill.
                _ => Err(Fault::new("", "a buffer without bytes is used", "export the model again")),
            };
        };
        let at = format!("{at}/uri");
        match container::uri(name, written, &at)? {
            Uri::Data(media, bytes) => match media.as_str() {
                "application/octet-stream" | "application/gltf-buffer" => Ok(Bytes::Own(bytes)),
                _ => Err(Fault::new(
                    &at,
                    format!("`{media}` is no media type of a buffer"),
                    "write `data:application/octet-stream;base64,`",
                )),
            },
            Uri::File(path) => container::fetch(files, &path, &at).map(Bytes::File),
            Uri::Elsewhere => Err(container::elsewhere(&at, written)),
        }
    }

    /// The bytes of a buffer view.
    ///
    /// # Errors
    /// The buffer could not be read.
    pub fn view(&self, root: &Value, view: usize) -> Result<&[u8], Fault> {
        let missing =
            || Fault::new(&format!("/bufferViews/{view}"), "does not fit its buffer", "export the model again");
        let object = list(root, "bufferViews").get(view).ok_or_else(missing)?;
        let buffer = index(object, "buffer").and_then(|buffer| self.buffers.get(buffer)).ok_or_else(missing)?;
        let bytes = buffer.as_ref().map_err(Clone::clone)?;
        let from = index(object, "byteOffset").unwrap_or(0);
        let to = from.checked_add(index(object, "byteLength").unwrap_or(0)).ok_or_else(missing)?;
        bytes.get().get(from..to).ok_or_else(missing)
    }
}

/// An accessor whose bytes are at hand.
pub struct Accessor<'b> {
    /// Elements.
    pub count: usize,
    layout: Layout,
    normalized: bool,
    /// None: all 0.
    bytes: Option<&'b [u8]>,
    stride: usize,
    /// Which elements are changed, ascending, and their bytes.
    changed: Vec<u32>,
    changes: &'b [u8],
}

impl<'b> Accessor<'b> {
    /// Opens an accessor of a document that was checked.
    ///
    /// # Errors
    /// Its kind is unknown, or its buffer could not be read.
    pub fn open(root: &Value, buffers: &'b Buffers<'_>, at: usize) -> Result<Accessor<'b>, Fault> {
        let pointer = format!("/accessors/{at}");
        let unknown = || Fault::new(&pointer, "has a type that is not one of glTF's", "export the model again");
        let accessor = list(root, "accessors").get(at).ok_or_else(unknown)?;
        let layout = layout(accessor).ok_or_else(unknown)?;
        let count = index(accessor, "count").unwrap_or(0);
        let tail = |part: &Value, view: usize| {
            let from = index(part, "byteOffset").unwrap_or(0);
            buffers.view(root, view).map(|bytes| bytes.get(from..).unwrap_or_default())
        };
        let view = index(accessor, "bufferView");
        let bytes = view.map(|view| tail(accessor, view)).transpose()?;
        let stride = view.and_then(|view| index(list(root, "bufferViews").get(view)?, "byteStride"));
        let mut changed = Vec::new();
        let mut changes: &[u8] = &[];
        if let Some(sparse) = accessor.get("sparse") {
            let part = |name: &str| {
                let part = sparse.get(name)?;
                Some((part, index(part, "bufferView")?))
            };
            let (indices, view) = part("indices").ok_or_else(unknown)?;
            let component = index(indices, "componentType").and_then(Component::of).ok_or_else(unknown)?;
            let bytes = tail(indices, view)?;
            let count = index(sparse, "count").unwrap_or(0);
            changed =
                bytes.chunks_exact(component.size()).take(count).map(|bytes| component.read(bytes) as u32).collect();
            let (values, view) = part("values").ok_or_else(unknown)?;
            changes = tail(values, view)?;
        }
        let normalized = accessor.get("normalized") == Some(&Value::Bool(true));
        Ok(Accessor { count, layout, normalized, bytes, stride: stride.unwrap_or(layout.size()), changed, changes })
    }

    /// How many numbers an element has.
    pub fn components(&self) -> usize {
        self.layout.components
    }

    fn raw(&self, element: usize, component: usize) -> f64 {
        let layout = &self.layout;
        let rows = layout.components / layout.columns;
        let inner = component / rows * layout.column() + component % rows * layout.component.size();
        let (bytes, from) = match self.changed.binary_search(&(element as u32)) {
            Ok(at) if !self.changed.is_empty() => (Some(self.changes), at * layout.size() + inner),
            _ => (self.bytes, element * self.stride + inner),
        };
        bytes.and_then(|bytes| bytes.get(from..)).map_or(0.0, |bytes| layout.component.read(bytes))
    }

    /// A number of an element: normalized integers as 0..1 or -1..1.
    pub fn number(&self, element: usize, component: usize) -> f64 {
        let raw = self.raw(element, component);
        if self.normalized { self.layout.component.normalize(raw) } else { raw }
    }

    /// The first numbers of an element.
    pub fn get<const N: usize>(&self, element: usize) -> [f32; N] {
        std::array::from_fn(|component| self.number(element, component) as f32)
    }

    /// An element that is an index.
    pub fn whole(&self, element: usize) -> u32 {
        self.raw(element, 0) as u32
    }

    /// The first number that is not finite or breaks the bounds of the document, or a sparse index that is out of order.
    pub fn fault(&self, accessor: &Value, at: &str) -> Option<Fault> {
        const AGAIN: &str = "export the model again, or check it with the Khronos glTF validator";
        let sparse = format!("{at}/sparse/indices");
        if let Some(pair) = self.changed.windows(2).find(|pair| pair[0] >= pair[1]) {
            let message = format!("the indices do not ascend: {} comes before {}", pair[0], pair[1]);
            return Some(Fault::new(&sparse, message, AGAIN));
        }
        if let Some(last) = self.changed.last().filter(|last| **last as usize >= self.count) {
            return Some(Fault::new(&sparse, format!("changes element {last} of {}", self.count), AGAIN));
        }
        let mut bounds = vec![[f64::INFINITY, f64::NEG_INFINITY]; self.layout.components];
        for element in 0..self.count {
            for (component, bounds) in bounds.iter_mut().enumerate() {
                let value = self.raw(element, component);
                if !value.is_finite() {
                    return Some(Fault {
                        code: "E0803",
                        at: at.to_string(),
                        message: format!("element {element} is not a finite number"),
                        help: AGAIN,
                    });
                }
                *bounds = [bounds[0].min(value), bounds[1].max(value)];
            }
        }
        for (name, which) in [("min", 0), ("max", 1)] {
            let given: Vec<f64> = list(accessor, name).iter().filter_map(Value::as_f64).collect();
            for (component, (given, found)) in given.iter().zip(&bounds).enumerate() {
                // Exporters round: what no picture shows is no fault.
                let slack = 1e-4 * (1.0 + found[0].abs().max(found[1].abs()));
                if self.count > 0 && (given - found[which]).abs() > slack {
                    let message = format!("says {given}, and the elements have {}", found[which]);
                    return Some(Fault::new(&format!("{at}/{name}/{component}"), message, AGAIN));
                }
            }
        }
        None
    }
}
