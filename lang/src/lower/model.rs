//! Models, and what refers into them: put aside until their files are read.

use std::rc::Rc;
use std::sync::Arc;

use super::{Lower, read};
use kinora_scene::Track;

use crate::diagnostic::Diagnostic;
use crate::eval::coerce::Data;
use crate::eval::machine::{NodeKind, NodeValue};
use crate::source::Span;
use crate::value::NodeId;

/// A model whose file is still to be read.
#[derive(Debug, Clone)]
pub struct ModelRequest {
    /// Index into the scene's nodes: what the model's own nodes move with.
    pub node: usize,
    /// The author's name, or the kind.
    pub name: String,
    /// The file, as written.
    pub file: Arc<str>,
    /// The place that names it.
    pub span: Span,
    /// What all of it is made of, if that is set: index into the scene's materials.
    pub material: Option<usize>,
    /// What nodes are made of: their path, the place of it, and the material.
    pub overrides: Vec<(Arc<str>, Span, usize)>,
    /// The clip that plays, and the place that names it.
    pub clip: Option<(Arc<str>, Span)>,
    /// The time that it plays at; none for the scene's.
    pub clock: Option<Arc<Track<f64>>>,
}

/// Who refers to a node or a camera inside a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InnerUse {
    /// This node moves with it.
    Parent(usize),
    /// This camera moves with it.
    CameraParent(usize),
    /// This camera looks at it.
    CameraTarget(usize),
    /// This light shines at it.
    LightTarget(usize),
    /// This node is copies of it.
    Copied(usize),
    /// It takes the picture.
    Picture,
}

/// A reference into a model, still to be followed.
#[derive(Debug, Clone)]
pub struct InnerRequest {
    /// Who refers.
    pub by: InnerUse,
    /// Index of the model's node in the scene.
    pub model: usize,
    /// Which node or camera.
    pub path: Arc<str>,
    /// The place that says so.
    pub span: Span,
}

impl<'a> Lower<'_, 'a> {
    /// The node that a property names. One inside a model is put aside for `by`; for now the model stands for it.
    pub(super) fn placed_node(&mut self, node: &Rc<NodeValue<'a>>, name: &str, by: InnerUse) -> Option<usize> {
        let set = read::set(node, name)?;
        match set.data.as_ref()? {
            Data::Node(id) => self.index_of(*id),
            Data::Inner(id, path) => {
                let model = self.index_of(*id)?;
                self.inner.push(InnerRequest { by, model, path: path.clone(), span: set.expr.span });
                Some(model)
            }
            _ => None,
        }
    }

    /// Puts a model aside.
    pub(super) fn model(&mut self, id: NodeId, node: &Rc<NodeValue<'a>>, index: usize) {
        let material = read::node(read::data(node, "material")).map(|id| self.material(Some(id)));
        let mut overrides = Vec::new();
        for child in &node.children {
            let Some(part) = self.machine.done(*child) else { continue };
            if !matches!(part.kind, NodeKind::Schema(kind) if kind.name == "override") {
                continue;
            }
            let Some(path) = self.machine.nodes.get(child.0 as usize).and_then(|slot| slot.ast.name.as_ref()) else {
                continue;
            };
            let Some(material) = read::node(read::data(&part, "material")) else { continue };
            let material = self.material(Some(material));
            overrides.push((path.text.clone(), path.span, material));
        }
        if !self.has(id, node, "file", "`file: \"...\"`, a glTF model") {
            return;
        }
        let Some(set) = read::set(node, "file") else { return };
        let Some(Data::Text(file)) = &set.data else { return };
        let (file, span) = (file.clone(), set.expr.span);
        let clip = read::set(node, "clip").and_then(|set| match &set.data {
            Some(Data::Text(name)) => Some((name.clone(), set.expr.span)),
            _ => None,
        });
        let clock = read::track_if_set(self.machine, node, "clip_time").map(Arc::new);
        if let (Some(set), None) = (read::set(node, "clip_time"), read::set(node, "clip")) {
            let diagnostic = Diagnostic::new("W0416", "`clip_time` has no effect without `clip`")
                .primary(self.machine.file(), set.name, "changes nothing")
                .help("say which clip plays: `clip: \"...\"`");
            self.report(id, diagnostic);
        }
        let name = self.name(id);
        self.models.push(ModelRequest { node: index, name, file, span, material, overrides, clip, clock });
    }
}
