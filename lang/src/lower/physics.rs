//! Rigid bodies, what holds them together, and how they are simulated.

use std::collections::{HashMap, HashSet};
use std::f64::consts::PI;
use std::rc::Rc;

use glam::DVec3;
use kinora_scene::{Body, BodyKind, Clock, Collider, Joint, JointKind, Mass, Node, Physics, Shape, Simulation, Track};

use super::{Lower, read};
use crate::diagnostic::{Applicability, Diagnostic};
use crate::dimension::{Dimension, short};
use crate::eval::coerce::Data;
use crate::eval::items::set_twice;
use crate::eval::machine::{NodeKind, NodeValue};
use crate::files::resolve;
use crate::source::Span;
use crate::value::{NodeId, Number, Value};

/// A node that moves: whose, by its index, which property, and where that is written.
struct Mover {
    node: usize,
    property: &'static str,
    span: Span,
}

impl<'a> Lower<'_, 'a> {
    pub(super) fn physics(&mut self, nodes: &[Node], clock: &Clock) -> Physics {
        self.only_one("simulation", |found| &found.simulations);
        let simulation = self.simulation(clock);
        let mut ids = vec![NodeId(u32::MAX); nodes.len()];
        for ((id, _), index) in self.found.placed.iter().zip(&self.order) {
            if let Some(slot) = ids.get_mut(*index) {
                *slot = *id;
            }
        }
        let mut bodies = Vec::new();
        for index in 0..nodes.len() {
            bodies.extend(self.body(index, nodes, &ids));
        }
        let kinds: HashMap<usize, BodyKind> = bodies.iter().map(|body| (body.node, body.kind)).collect();
        for body in &bodies {
            self.carried(body, &kinds, nodes, &ids);
        }
        let mut joints = Vec::new();
        // What is copied by `like` is met more than once, and holds the same bodies each time.
        let mut known = HashSet::new();
        for id in std::mem::take(&mut self.found.joints).into_iter().filter(|id| known.insert(*id)) {
            joints.extend(self.joint(id, &kinds));
        }
        Physics { simulation, bodies, joints, baked: None }
    }

    fn simulation(&mut self, clock: &Clock) -> Simulation {
        let scene = &self.machine.source.source(0).name;
        let stem = scene.rsplit('/').next().unwrap_or_default();
        let stem = stem.strip_suffix(".kin").unwrap_or(stem).to_string();
        let found = self.found.simulations.first().copied();
        let found = found.and_then(|id| Some((id, self.machine.done(id)?)));
        let name = found.as_ref().and_then(|(id, _)| {
            self.machine.nodes.get(id.0 as usize)?.ast.name.as_ref().map(|name| name.text.to_string())
        });
        let default = format!("cache/{}.bake", name.unwrap_or(stem));
        let from = scene.to_string();
        let mut simulation = Simulation {
            duration_s: clock.duration_s,
            bake: resolve(&from, &default).unwrap_or(default),
            ..Simulation::default()
        };
        let Some((id, node)) = found else { return simulation };
        simulation.gravity = read::vector(&node, "gravity");
        simulation.rate_hz = read::number(&node, "rate");
        simulation.duration_s = read::number_if_set(&node, "duration").unwrap_or(simulation.duration_s);
        let Some((written, span)) = read::set(&node, "bake").and_then(|set| match &set.data {
            Some(Data::Text(text)) => Some((text.clone(), set.expr.span)),
            _ => None,
        }) else {
            return simulation;
        };
        let file = self.machine.file();
        if !written.to_ascii_lowercase().ends_with(".bake") {
            let diagnostic = Diagnostic::new("E0401", "the file of a bake must end in `.bake`")
                .primary(file, span, "another kind of file")
                .help(
                    "it is written anew whenever the simulation changes: give it a name of its own, \"cache/a.bake\"",
                );
            self.report(id, diagnostic);
            return simulation;
        }
        let from = self.machine.source.source(span.start).name.to_string();
        match resolve(&from, &written) {
            Ok(path) => simulation.bake = path,
            Err(error) => self.report(id, error.diagnostic(file, span)),
        }
        simulation
    }

    /// The body that a node is, if it is one.
    fn body(&mut self, index: usize, nodes: &[Node], ids: &[NodeId]) -> Option<Body> {
        let id = *ids.get(index)?;
        let owner = self.machine.done(id)?;
        let is_body = |machine: &super::Machine<'a>, child: NodeId| {
            machine.done(child).filter(|node| matches!(node.kind, NodeKind::Schema(kind) if kind.name == "rigid_body"))
        };
        let mut found = owner.children.iter().filter_map(|child| Some((*child, is_body(self.machine, *child)?)));
        let (part, node) = found.next()?;
        let second = found.next();
        if let Some((second, _)) = second {
            let diagnostic = set_twice("rigid_body", self.machine.file(), self.span(second), self.span(part));
            self.report(id, diagnostic);
        }
        let kind = match read::word(&node, "kind") {
            "fixed" => BodyKind::Fixed,
            "kinematic" => BodyKind::Kinematic,
            _ => BodyKind::Dynamic,
        };
        let collider = match read::word(&node, "collider") {
            "box" => Collider::Box,
            "sphere" => Collider::Sphere,
            "capsule" => Collider::Capsule,
            "cylinder" => Collider::Cylinder,
            "convex_hull" => Collider::ConvexHull,
            "mesh" => Collider::Mesh,
            _ => Collider::Auto,
        };
        let body = Body {
            node: index,
            kind,
            mass: match read::number_if_set(&node, "mass") {
                Some(kg) => Mass::Total(kg),
                None => Mass::Density(read::number(&node, "density")),
            },
            friction: read::number(&node, "friction"),
            restitution: read::number(&node, "restitution"),
            velocity: read::vector(&node, "velocity"),
            angular_velocity: read::vector(&node, "angular_velocity"),
            linear_damping: read::number(&node, "linear_damping"),
            angular_damping: read::number(&node, "angular_damping"),
            collider,
            impulse: read::vector(&node, "impulse"),
            impulse_at_s: read::number(&node, "impulse_at"),
        };
        self.not_both(part, &node, "a body", ["mass", "density"], "how heavy it is");
        self.not_copied(id, part, index, nodes, ids);
        self.ruled_out(part, &node, kind);
        let shape = nodes.get(index).and_then(|node| node.shape.as_ref());
        self.collides(id, part, &node, &body, matches!(shape, Some(Shape::Plane { .. })));
        self.stands_still(id, part, &body, nodes, ids);
        Some(body)
    }

    /// E0910: a body that is in no place of its own.
    fn not_copied(&mut self, id: NodeId, part: NodeId, index: usize, nodes: &[Node], ids: &[NodeId]) {
        let mut at = Some(index);
        while let Some(here) = at {
            let Some(node) = nodes.get(here) else { return };
            if node.only_copied {
                let name = self.name(id);
                let diagnostic = Diagnostic::new("E0910", format!("`{name}` is only there for its instances"))
                    .primary(self.machine.file(), self.span(part), "a body is in one place")
                    .help("write `rigid_body { }` inside the `instance`");
                let diagnostic = match ids.get(here).filter(|_| here != index) {
                    Some(whole) => diagnostic.label(self.machine.file(), self.span(*whole), "only shown by instances"),
                    None => diagnostic,
                };
                self.report(id, diagnostic);
                return;
            }
            at = node.parent;
        }
    }

    /// W0416: what a body that no force moves does not have.
    fn ruled_out(&mut self, part: NodeId, node: &Rc<NodeValue<'a>>, kind: BodyKind) {
        let word = match kind {
            BodyKind::Dynamic => {
                if let (Some(set), None) = (read::set(node, "impulse_at"), read::set(node, "impulse")) {
                    let diagnostic = Diagnostic::new("W0416", "`impulse_at` has no effect without `impulse`")
                        .primary(self.machine.file(), set.name, "changes nothing")
                        .help("add the push: `impulse: (0, 1N*s, 0)`");
                    self.report(part, diagnostic);
                }
                return;
            }
            BodyKind::Fixed => "fixed",
            BodyKind::Kinematic => "kinematic",
        };
        let forced = [
            "density",
            "mass",
            "velocity",
            "angular_velocity",
            "linear_damping",
            "angular_damping",
            "impulse",
            "impulse_at",
        ];
        for name in forced {
            let Some(set) = read::set(node, name) else { continue };
            let mut diagnostic = Diagnostic::new("W0416", format!("`{name}` has no effect with `kind: {word}`"))
                .primary(self.machine.file(), set.name, "changes nothing")
                .help("remove it, or make the body dynamic");
            if let Some(kind) = read::set(node, "kind") {
                diagnostic = diagnostic.label(self.machine.file(), kind.expr.span, "no force moves it");
            }
            self.report(part, diagnostic);
        }
    }

    /// E0902: what has no inside cannot be moved by forces, and what has no end has nothing about it.
    fn collides(&mut self, id: NodeId, part: NodeId, node: &Rc<NodeValue<'a>>, body: &Body, plane: bool) {
        let file = self.machine.file();
        let chosen = read::set(node, "collider").map_or(self.span(part), |set| set.expr.span);
        let dynamic = body.kind == BodyKind::Dynamic;
        let diagnostic =
            if plane && dynamic {
                Diagnostic::new("E0902", "an infinite `plane` cannot be moved by forces")
                    .primary(file, self.span(part), "dynamic, where nothing else is said")
                    .label(file, self.span(id), "without end")
                    .help("write `kind: fixed`")
            } else if plane && !matches!(body.collider, Collider::Auto | Collider::Mesh) {
                Diagnostic::new("E0902", "nothing is about an infinite `plane`")
                    .primary(file, chosen, "has an end")
                    .label(file, self.span(id), "has none")
                    .help("leave `collider` out: a plane collides as a plane")
            } else if dynamic && body.collider == Collider::Mesh {
                let diagnostic = Diagnostic::new("E0902", "dynamic bodies need a convex or primitive collider")
                    .primary(file, chosen, "triangles have no inside");
                match self.machine.text(chosen) {
                    "mesh" => diagnostic.note("`auto` makes hulls of its convex parts").fix(
                        Applicability::Maybe,
                        "write `collider: convex_hull`",
                        file,
                        chosen,
                        "convex_hull",
                    ),
                    _ => diagnostic.help("write `collider: convex_hull`, or `auto` for hulls of its convex parts"),
                }
            } else {
                return;
            };
        self.report(part, diagnostic);
    }

    /// E0903 and E0904: what moves a body besides forces, and what changes its size.
    fn stands_still(&mut self, id: NodeId, part: NodeId, body: &Body, nodes: &[Node], ids: &[NodeId]) {
        let file = self.machine.file();
        let name = self.name(id);
        let sized = self.movers(body.node, nodes, ids, &["scale"]).or_else(|| match &nodes.get(body.node)?.shape {
            Some(Shape::Sphere { radius_m }) if radius_m.constant().is_none() => {
                let set = self.machine.done(id)?;
                let span = read::set(&set, "radius")?.expr.span;
                Some(Mover { node: body.node, property: "radius", span })
            }
            _ => None,
        });
        if let Some(mover) = sized {
            let whose = if mover.node == body.node { String::new() } else { format!(" of what `{name}` moves with") };
            let diagnostic = Diagnostic::new(
                "E0904",
                format!("`{}`{whose} is animated: colliders cannot change size", mover.property),
            )
            .primary(file, mover.span, "changes over time")
            .label(file, self.span(part), format!("makes `{name}` a body"))
            .help("animate a shape that is no body");
            self.report(id, diagnostic);
            return;
        }
        let word = match body.kind {
            BodyKind::Dynamic => "dynamic",
            BodyKind::Fixed => "fixed",
            BodyKind::Kinematic => return,
        };
        let Some(mover) = self.movers(body.node, nodes, ids, &["position", "rotation"]) else { return };
        let whose = match ids.get(mover.node).filter(|_| mover.node != body.node) {
            Some(other) => format!(" of `{}`, which `{name}` moves with,", self.name(*other)),
            None => String::new(),
        };
        let message = format!("`{}`{whose} is animated but the body is {word}", mover.property);
        let diagnostic = Diagnostic::new("E0903", message)
            .primary(file, mover.span, "moves it")
            .label(file, self.span(part), format!("a {word} body"))
            .help("write `kind: kinematic` for a body that its keys move");
        self.report(id, diagnostic);
    }

    /// What of these properties is animated, of the node or of what it moves with.
    fn movers(&self, from: usize, nodes: &[Node], ids: &[NodeId], properties: &[&'static str]) -> Option<Mover> {
        let mut at = Some(from);
        while let Some(index) = at {
            let node = nodes.get(index)?;
            for property in properties {
                let still = match *property {
                    "position" => is_constant(&node.placing.position),
                    "rotation" => is_constant(&node.placing.rotation),
                    _ => is_constant(&node.placing.scale),
                };
                if !still {
                    let id = *ids.get(index)?;
                    let set = self.machine.done(id)?;
                    let span = read::set(&set, property).map_or(self.span(id), |set| set.expr.span);
                    return Some(Mover { node: index, property, span });
                }
            }
            at = node.parent;
        }
        None
    }

    /// E0903: what no force moves, in what forces move.
    fn carried(&mut self, body: &Body, kinds: &HashMap<usize, BodyKind>, nodes: &[Node], ids: &[NodeId]) {
        let word = match body.kind {
            BodyKind::Dynamic => return,
            BodyKind::Fixed => "fixed",
            BodyKind::Kinematic => "kinematic",
        };
        let mut at = nodes.get(body.node).and_then(|node| node.parent);
        while let Some(index) = at {
            if kinds.get(&index) == Some(&BodyKind::Dynamic) {
                let (Some(id), Some(other)) = (ids.get(body.node), ids.get(index)) else { return };
                let (name, whole) = (self.name(*id), self.name(*other));
                let message = format!("`{name}` is {word} but moves with `{whole}`, which forces move");
                let diagnostic = Diagnostic::new("E0903", message)
                    .primary(self.machine.file(), self.span(*id), format!("a {word} body"))
                    .label(self.machine.file(), self.span(*other), "a dynamic body")
                    .help("write it beside, and join the two with a `joint` of `kind: fixed`");
                self.report(*id, diagnostic);
                return;
            }
            at = nodes.get(index).and_then(|node| node.parent);
        }
    }

    fn joint(&mut self, id: NodeId, kinds: &HashMap<usize, BodyKind>) -> Option<Joint> {
        let node = self.machine.done(id)?;
        let needed = [("kind", "`kind: hinge`"), ("a", "`a: door`, a body"), ("b", "`b: frame`, a body")];
        let mut whole = true;
        for (name, help) in needed {
            whole &= self.has(id, &node, name, help);
        }
        let word = read::word(&node, "kind");
        if !whole || word.is_empty() {
            return None;
        }
        self.without_effect_on(id, &node, word);
        let (a, b) = (self.jointed(id, &node, "a", kinds), self.jointed(id, &node, "b", kinds));
        let (a, b) = (a?, b?);
        let dynamic = |index: usize| kinds.get(&index) == Some(&BodyKind::Dynamic);
        if a == b || !(dynamic(a) || dynamic(b)) {
            let (file, span) = (self.machine.file(), read::set(&node, "b").map_or(self.span(id), |set| set.expr.span));
            let first = read::set(&node, "a").map_or(span, |set| set.expr.span);
            let diagnostic = if a == b {
                Diagnostic::new("E0909", "a joint needs two different bodies")
                    .primary(file, span, "the same body again")
                    .label(file, first, "one body")
                    .help("to hold it in the world, join it to a body with `kind: fixed`")
            } else {
                Diagnostic::new("E0909", "a joint needs a dynamic body")
                    .primary(file, span, "no force moves this one")
                    .label(file, first, "nor this one")
                    .help("make one of them `kind: dynamic`")
            };
            self.report(id, diagnostic);
            return None;
        }
        let axis = match word {
            "hinge" | "slider" if self.has(id, &node, "axis", "`axis: (0, 1, 0)`, in the world") => {
                read::vector(&node, "axis")
            }
            "hinge" | "slider" => return None,
            _ => DVec3::Y,
        };
        let angular = word == "hinge";
        let kind = match word {
            "fixed" => JointKind::Fixed,
            "ball" => JointKind::Ball,
            "hinge" | "slider" => {
                let limits = self.limits(id, &node, angular);
                let motor_velocity = self.motor(id, &node, angular);
                match angular {
                    true => JointKind::Hinge { axis, limits, motor_velocity },
                    false => JointKind::Slider { axis, limits, motor_velocity },
                }
            }
            _ => {
                self.has(id, &node, "stiffness", "`stiffness: 100N/m`");
                JointKind::Spring {
                    length_m: read::number_if_set(&node, "length"),
                    stiffness: read::number(&node, "stiffness"),
                    damping: read::number(&node, "damping"),
                }
            }
        };
        let anchor = read::set(&node, "anchor").map(|_| read::vector(&node, "anchor"));
        Some(Joint { name: self.name(id), a, b, anchor, kind })
    }

    /// The body that a joint holds, by its node's index; E0204 where the node is none.
    fn jointed(
        &mut self,
        id: NodeId,
        node: &Rc<NodeValue<'a>>,
        name: &str,
        kinds: &HashMap<usize, BodyKind>,
    ) -> Option<usize> {
        let set = read::set(node, name)?;
        let (place, of) = match set.data.as_ref()? {
            Data::Node(of) => (self.index_of(*of), *of),
            Data::Inner(of, _) => (None, *of),
            _ => return None,
        };
        if let Some(index) = place.filter(|index| kinds.contains_key(index)) {
            return Some(index);
        }
        let what = match (place, self.found.unknown) {
            // What it is cannot be told.
            (None, true) => return None,
            (None, false) if matches!(set.data, Some(Data::Inner(..))) => "is inside a model, where nothing is a body",
            (None, false) => "is not in the scene",
            (Some(_), _) => "is no body: it has no `rigid_body`",
        };
        let diagnostic = Diagnostic::new("E0204", format!("`{}` {what}", self.name(of)))
            .primary(self.machine.file(), set.expr.span, "a joint holds bodies")
            .label(self.machine.file(), self.span(of), "declared here")
            .help("write `rigid_body { }` in it, or `rigid_body { kind: fixed }` for what stays where it is");
        self.report(id, diagnostic);
        None
    }

    /// W0416: what only joints of another kind have.
    fn without_effect_on(&mut self, id: NodeId, node: &Rc<NodeValue<'a>>, kind: &str) {
        let (turns, springs) = (["axis", "limits", "motor_velocity"], ["length", "stiffness", "damping"]);
        let none: &[&str] = &[];
        let wrong = match kind {
            "hinge" | "slider" => [&springs[..], none],
            "spring" => [&turns[..], none],
            _ => [&turns[..], &springs[..]],
        };
        for name in wrong.into_iter().flatten() {
            let Some(set) = read::set(node, name) else { continue };
            let help =
                if springs.contains(name) { "only a `spring` has it" } else { "a `hinge` and a `slider` have it" };
            let mut diagnostic = Diagnostic::new("W0416", format!("`{name}` has no effect with `kind: {kind}`"))
                .primary(self.machine.file(), set.name, "changes nothing")
                .help(help);
            if let Some(word) = read::set(node, "kind") {
                diagnostic = diagnostic.label(self.machine.file(), word.expr.span, "of another kind");
            }
            self.report(id, diagnostic);
        }
    }

    fn limits(&mut self, id: NodeId, node: &Rc<NodeValue<'a>>, angular: bool) -> Option<[f64; 2]> {
        let set = read::set(node, "limits")?;
        let parts = set.data.as_ref()?.constants()?;
        let &[low, high] = parts.as_slice() else { return None };
        let span = set.expr.span;
        if let Value::Range(from, to) = &set.value {
            self.in_unit(id, [*from, *to], span, angular, "limits")?;
        }
        if low > high {
            let unit = if angular { "deg" } else { "m" };
            let shown = |value: f64| short(if angular { value.to_degrees() } else { value });
            let diagnostic = Diagnostic::new("E0401", "limits must go from the smaller to the larger")
                .primary(self.machine.file(), span, format!("from {}{unit} to {}{unit}", shown(low), shown(high)))
                .help("swap the two");
            self.report(id, diagnostic);
            return None;
        }
        // A hinge cannot tell a turn more from a turn less.
        let most = PI + 1e-9;
        if angular && (low < -most || high > most) {
            let diagnostic = Diagnostic::new("E0401", "limits of a hinge must be within -180deg..180deg")
                .primary(self.machine.file(), span, "further than once round")
                .help("leave `limits` out for a hinge that turns all the way");
            self.report(id, diagnostic);
            return None;
        }
        Some([low, high])
    }

    fn motor(&mut self, id: NodeId, node: &Rc<NodeValue<'a>>, angular: bool) -> Option<f64> {
        let set = read::set(node, "motor_velocity")?;
        let velocity = set.data.as_ref()?.constants()?.first().copied()?;
        if let Value::Number(number) = &set.value {
            self.in_unit(id, [*number; 2], set.expr.span, angular, "motor_velocity")?;
        }
        Some(velocity)
    }

    /// E0302: an angle where a length is wanted, or the other way round.
    fn in_unit(&mut self, id: NodeId, numbers: [Number; 2], span: Span, angular: bool, property: &str) -> Option<()> {
        let limits = property == "limits";
        let (kind, wanted, example) = match (angular, limits) {
            (true, true) => ("hinge", Dimension::ANGLE, "-30deg..90deg"),
            (true, false) => ("hinge", Dimension::SPIN, "90deg/s"),
            (false, true) => ("slider", Dimension::LENGTH, "-10cm..10cm"),
            (false, false) => ("slider", Dimension::SPEED, "10cm/s"),
        };
        let fits = |number: &Number| {
            number.dimension == wanted
                || number.is_bare_zero()
                || (wanted == Dimension::LENGTH && number.dimension.is_none())
        };
        let Some(wrong) = numbers.iter().find(|number| !fits(number)).map(|number| number.dimension) else {
            return Some(());
        };
        let (asked, found) = (wanted.with_article(), wrong.with_article());
        let diagnostic = Diagnostic::new("E0302", format!("expected {asked}, found {found}"))
            .primary(self.machine.file(), span, format!("`{property}` of a {kind} is {asked}"))
            .help(format!("write for example `{example}`"));
        self.report(id, diagnostic);
        None
    }
}

fn is_constant<T>(track: &Track<T>) -> bool {
    track.constant().is_some()
}
