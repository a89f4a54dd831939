//! Nodes in order: parents before their children.

use std::rc::Rc;

use glam::DVec3;
use kinora_scene::{Copies, Node, Placement, Placing, Track};

use super::{InnerUse, Lower, read};
use crate::diagnostic::Diagnostic;
use crate::eval::coerce::Data;
use crate::eval::items::placement;
use crate::eval::machine::{NodeKind, NodeValue};
use crate::schema::Sort;
use crate::source::Span;
use crate::value::NodeId;

impl<'a> Lower<'_, 'a> {
    /// The scene's index of a node that is placed.
    pub(super) fn index_of(&self, id: NodeId) -> Option<usize> {
        self.first.get(&id).and_then(|at| self.order.get(*at).copied())
    }

    /// Puts parents before children; gives the parent of each placed node, by its index in `found.placed`.
    pub(super) fn order(&mut self) -> Vec<Option<usize>> {
        for (at, (id, _)) in self.found.placed.iter().enumerate() {
            self.first.entry(*id).or_insert(at);
        }
        let mut parents: Vec<Option<usize>> = Vec::with_capacity(self.found.placed.len());
        for (id, enclosing) in self.found.placed.clone() {
            let node = self.machine.done(id).unwrap_or_default();
            let given = match read::data(&node, "parent") {
                Some(Data::Node(parent) | Data::Inner(parent, _)) => Some(*parent),
                _ => None,
            };
            parents.push(match given {
                Some(parent) => self.first.get(&parent).copied(),
                None => enclosing,
            });
        }
        let mut order = vec![usize::MAX; parents.len()];
        let mut next = 0;
        let mut on_path = vec![false; parents.len()];
        for start in 0..parents.len() {
            let mut path = Vec::new();
            let mut at = Some(start);
            while let Some(here) = at {
                if order[here] != usize::MAX {
                    break;
                }
                if on_path[here] {
                    self.circle(&path, here);
                    parents[here] = None;
                    break;
                }
                on_path[here] = true;
                path.push(here);
                at = parents[here];
            }
            for here in path.into_iter().rev() {
                on_path[here] = false;
                order[here] = next;
                next += 1;
            }
        }
        self.order = order;
        parents
    }

    /// E0505.
    fn circle(&mut self, path: &[usize], here: usize) {
        let start = path.iter().position(|at| *at == here).unwrap_or(0);
        let ring: Vec<NodeId> =
            path.iter().skip(start).filter_map(|at| self.found.placed.get(*at).map(|placed| placed.0)).collect();
        let Some(first) = ring.first().copied() else { return };
        let name = self.name(first);
        let mut diagnostic = Diagnostic::new("E0505", format!("`{name}` is positioned relative to itself"));
        for (i, id) in ring.iter().enumerate().take(6) {
            let parent = ring.get(i + 1).copied().unwrap_or(first);
            let text = format!("`{}` moves with `{}`", self.name(*id), self.name(parent));
            let node = self.machine.done(*id).unwrap_or_default();
            let span = read::set(&node, "parent").map_or(self.span(*id), |set| set.expr.span);
            diagnostic = match i {
                0 => diagnostic.primary(self.machine.file(), span, text),
                _ => diagnostic.label(self.machine.file(), span, text),
            };
        }
        self.report(first, diagnostic.help("give one of them a fixed position"));
    }

    /// The scene's nodes.
    pub(super) fn nodes(&mut self, parents: &[Option<usize>]) -> Vec<Node> {
        let mut nodes: Vec<Option<Node>> = vec![None; parents.len()];
        for (at, (id, _)) in self.found.placed.clone().into_iter().enumerate() {
            let parent = parents.get(at).copied().flatten().and_then(|parent| self.order.get(parent).copied());
            let index = self.order.get(at).copied().unwrap_or(0);
            let node = self.machine.done(id).unwrap_or_default();
            let built = self.placed(id, &node, index, parent);
            if let Some(slot) = nodes.get_mut(index) {
                *slot = Some(built);
            }
        }
        nodes.into_iter().flatten().collect()
    }

    fn placed(&mut self, id: NodeId, node: &Rc<NodeValue<'a>>, index: usize, parent: Option<usize>) -> Node {
        if let Some(Data::Inner(..)) = read::data(node, "parent") {
            self.placed_node(node, "parent", InnerUse::Parent(index));
        }
        let shape = match node.kind {
            NodeKind::Schema(kind) if kind.sort == Sort::Shape => self.shape(id, node, kind, index),
            _ => None,
        };
        let material = match (&shape, read::set(node, "material")) {
            // A group has no surface: any index will do, and the default one need not be made for it.
            (None, _) => 0,
            (Some(_), Some(set)) => self.material(read::node(set.data.as_ref())),
            (Some(_), None) => self.material(None),
        };
        self.power_of_plane(id, node, shape.as_ref(), material);
        if let Some(request) = self.meshes.last_mut().filter(|request| request.node == index)
            && self.made_of.get(material).is_some_and(|made_of| made_of.glass)
        {
            request.glass = read::set(node, "material").map(|set| set.expr.span);
        }
        let (placing, visible) = match node.kind {
            NodeKind::Schema(_) => (
                Placing {
                    position: read::track(self.machine, node, "position"),
                    rotation: read::track(self.machine, node, "rotation"),
                    scale: read::track_if_set(self.machine, node, "scale").unwrap_or(Track::Const(DVec3::ONE)),
                },
                read::track(self.machine, node, "visible"),
            ),
            _ => (Placing::default(), true.into()),
        };
        let copies = self.copies(id, node, index);
        // Where there are many, each has its place.
        let placing =
            if copies.as_ref().is_some_and(|copies| copies.at.len() > 1) { Placing::default() } else { placing };
        let only_copied = self.found.only_copied.contains(&id);
        Node {
            name: self.name(id),
            parent,
            placing,
            shape,
            material,
            visible,
            copies,
            only_copied,
            form: None,
            vanishes: false,
        }
    }

    /// Whether a property is set; E0207 without. `help`: what may be added.
    pub(super) fn has(&mut self, id: NodeId, node: &Rc<NodeValue<'a>>, name: &str, help: &str) -> bool {
        let found = read::set(node, name).is_some();
        if let (false, NodeKind::Schema(kind)) = (found, node.kind) {
            let span = self.machine.nodes.get(id.0 as usize).map_or(Span::at(0), |slot| slot.ast.kind.span);
            let diagnostic = Diagnostic::new("E0207", format!("`{}` needs `{name}`", kind.name))
                .primary(self.machine.file(), span, format!("nothing says `{name}`"))
                .help(format!("add {help}"));
            self.report(id, diagnostic);
        }
        found
    }

    fn copies(&mut self, id: NodeId, node: &Rc<NodeValue<'a>>, index: usize) -> Option<Box<Copies>> {
        let NodeKind::Schema(kind) = node.kind else { return None };
        if kind.name != "instance" {
            return None;
        }
        if !self.has(id, node, "of", "`of: tree`: a shape, a model, a group or a prefab") {
            return None;
        }
        let material = read::node(read::data(node, "material")).map(|id| self.material(Some(id)));
        let of = self.placed_node(node, "of", InnerUse::Copied(index))?;
        let more = self.machine.nodes.get_mut(id.0 as usize).map(|slot| std::mem::take(&mut slot.copies));
        let more = more.unwrap_or_default();
        let mut at = Vec::with_capacity(more.len() + 1);
        at.push(if more.is_empty() { Placement::IDENTITY } else { placement(node)? });
        at.extend(more);
        Some(Box::new(Copies { of, at, material }))
    }

    /// E0504: what holds copies of itself. Gives the nodes that do.
    pub(super) fn copied_into_itself(&mut self, nodes: &mut [Node]) {
        // Of each node: what is copied in it and below it.
        let mut inside: Vec<Vec<usize>> = vec![Vec::new(); nodes.len()];
        for index in (0..nodes.len()).filter(|index| nodes[*index].copies.is_some()) {
            let of = nodes[index].copies.as_ref().map_or(index, |copies| copies.of);
            let mut at = Some(index);
            let mut steps = 0;
            while let Some(here) = at.filter(|_| steps <= nodes.len()) {
                if let Some(inside) = inside.get_mut(here).filter(|inside| !inside.contains(&of)) {
                    inside.push(of);
                }
                at = nodes.get(here).and_then(|node| node.parent);
                steps += 1;
            }
        }
        for index in 0..nodes.len() {
            let Some(of) = nodes[index].copies.as_ref().map(|copies| copies.of) else { continue };
            let mut known = vec![of];
            let (mut next, mut circular) = (0, false);
            while let Some(here) = known.get(next).copied().filter(|_| !circular) {
                next += 1;
                for &more in inside.get(here).into_iter().flatten() {
                    circular |= more == of;
                    if !known.contains(&more) {
                        known.push(more);
                    }
                }
            }
            if circular {
                nodes[index].copies = None;
                let at = self.order.iter().position(|order| *order == index);
                let Some((id, _)) = at.and_then(|at| self.found.placed.get(at)).copied() else { continue };
                let node = self.machine.done(id).unwrap_or_default();
                let span = read::set(&node, "of").map_or(self.span(id), |set| set.expr.span);
                let name = nodes.get(of).map_or(String::new(), |node| node.name.clone());
                let diagnostic = Diagnostic::new("E0504", format!("`{name}` contains copies of itself without end"))
                    .primary(self.machine.file(), span, "one more of what it stands in")
                    .help("take the instance out of it");
                self.report(id, diagnostic);
            }
        }
    }
}
