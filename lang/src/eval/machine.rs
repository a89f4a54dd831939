//! What an evaluation carries along: its arena of operations, its nodes, what it has used up and what it has found.

use std::collections::HashSet;
use std::rc::Rc;

use kinora_scene::Placement;
use rustc_hash::FxHashMap;

use crate::diagnostic::{Diagnostic, Kept, Label};
use crate::eval::coerce::Data;
use crate::eval::graph::Graph;
use crate::eval::limits;
use crate::eval::scope::Scope;
use crate::eval::shared::Inline;
use crate::eval::watch::Watching;
use crate::library::is_path;
use crate::schema::{Kind, Property};
use crate::source::{FileId, Span, Texts};
use crate::syntax::ast;
use crate::value::{NodeId, Value};

/// The evaluator of a scene.
pub struct Machine<'a> {
    /// The scene's text, and those that it imports.
    pub source: &'a Texts,
    /// Operations on what moves.
    pub graph: Graph,
    /// Every node that was met.
    pub nodes: Vec<NodeSlot<'a>>,
    /// What the top level of the scene declares.
    pub globals: Rc<Scope<'a>>,
    /// What was found.
    pub diagnostics: Vec<Diagnostic>,
    seen: HashSet<(&'static str, Span, String)>,
    kept: Kept,
    /// The calls and loops that are running, innermost first.
    pub trace: Option<Rc<Trace<'a>>>,
    /// The lets and nodes that are running: name and place of the declaration.
    pub pending: Vec<(&'a str, Span)>,
    /// Functions and prefabs that called themselves without end, by the place of their heads.
    pub endless: HashSet<Span>,
    /// The last operation that made a number that is not finite.
    pub not_finite: Option<Span>,
    /// Which of the findings say where their values come from.
    pub explained: HashSet<usize>,
    /// Whether the scene only declares what others import: that it shows nothing is then no mistake.
    pub library: bool,
    /// The scene's `render` block.
    pub render: Option<&'a ast::Node>,
    /// An empty node that stands for mixes of materials, which are written as calls.
    pub mix: &'a ast::Node,
    /// Frames a second, once asked for.
    pub fps: Option<Option<f64>>,
    /// The scene's length in seconds and where it says so, once asked for.
    pub end: Option<Option<(f64, Span)>>,
    /// Whether a limit has ended the evaluation.
    pub stopped: bool,
    /// Calls running.
    pub calls: u32,
    depth: u32,
    fuel: u64,
    /// Copies of all nodes together.
    pub copies: usize,
    /// Nodes written as values that many turns share.
    pub inline: Inline<'a>,
    /// The names in each node written as a value inside of turns.
    pub inline_names: FxHashMap<*const ast::Node, Rc<[&'a str]>>,
    /// Expressions whose values somebody asks for.
    pub watched: Watching,
}

/// A node: what is written, and what became of it.
pub struct NodeSlot<'a> {
    /// What is written; of a mix of materials an empty stand-in.
    pub ast: &'a ast::Node,
    /// The call that made it, if it is a mix of materials.
    pub mixed: Option<Span>,
    /// Where.
    pub scope: Rc<Scope<'a>>,
    /// In which call.
    pub trace: Option<Rc<Trace<'a>>>,
    /// How far it is.
    pub state: NodeState<'a>,
    /// Of an instance: where it stands besides its own place, for other turns of the loop that it is written in.
    pub copies: Vec<Placement>,
}

impl NodeSlot<'_> {
    /// The place that stands for the node in a message: its name, its kind, or the call that made it.
    pub fn place(&self) -> Span {
        self.mixed.unwrap_or(self.ast.name.as_ref().map_or(self.ast.kind.span, |name| name.span))
    }
}

/// How far a node is evaluated.
#[derive(Clone)]
pub enum NodeState<'a> {
    /// Not yet.
    Waiting,
    /// It is being evaluated.
    Running,
    /// It is.
    Done(Rc<NodeValue<'a>>),
}

/// An evaluated node.
#[derive(Default)]
pub struct NodeValue<'a> {
    /// What it is.
    pub kind: NodeKind<'a>,
    /// What is set, `like` included; the first row of a property counts.
    pub properties: Vec<Set<'a>>,
    /// What it contains, in order.
    pub children: Vec<NodeId>,
    /// Of a prefab: the arguments given, and the names inside.
    pub arguments: Vec<(&'a str, Value)>,
    /// Of a prefab: the names inside.
    pub inner: Option<Rc<Scope<'a>>>,
}

/// What a node is.
#[derive(Clone, Copy, Default)]
pub enum NodeKind<'a> {
    /// A kind of the schema.
    Schema(&'static Kind),
    /// A call of a prefab.
    Prefab(&'a ast::PrefabDecl),
    /// Reported.
    #[default]
    Unknown,
}

/// A property that is set.
#[derive(Clone)]
pub struct Set<'a> {
    /// Which.
    pub property: &'static Property,
    /// What to; `None` where it is in error.
    pub data: Option<Data>,
    /// The same before it was fitted to the property's type.
    pub value: Value,
    /// The place of its name.
    pub name: Span,
    /// What is written.
    pub expr: &'a ast::Expr,
}

/// A running call or turn of a loop.
pub struct Trace<'a> {
    /// The one around it.
    pub parent: Option<Rc<Trace<'a>>>,
    /// What is called; nothing in a turn of a loop.
    pub name: Option<&'a str>,
    /// Where.
    pub span: Span,
    /// With what.
    pub given: Vec<Given<'a>>,
    /// Where the given values are computed.
    pub env: Rc<Scope<'a>>,
}

/// A value that a call or a loop gives a name.
pub struct Given<'a> {
    /// The name.
    pub name: &'a str,
    /// The value.
    pub value: Value,
    /// What is written for it, if anything is.
    pub expr: Option<&'a ast::Expr>,
}

impl Trace<'_> {
    fn show(&self, source: &Texts) -> String {
        let values: Vec<String> =
            self.given.iter().take(4).map(|given| format!("{}: {}", given.name, given.value.show())).collect();
        let with = if values.is_empty() { String::new() } else { format!(" with {}", values.join(", ")) };
        let name = self.name.map_or_else(|| "a loop".into(), |name| format!("`{name}`"));
        format!("in {name}{with}, {}", source.line(self.span.start))
    }
}

impl<'a> Machine<'a> {
    /// An evaluator that has seen nothing.
    pub fn new(source: &'a Texts, mix: &'a ast::Node) -> Machine<'a> {
        Machine {
            source,
            graph: Graph::default(),
            nodes: Vec::new(),
            globals: Rc::default(),
            diagnostics: Vec::new(),
            seen: HashSet::new(),
            kept: Kept::default(),
            trace: None,
            pending: Vec::new(),
            endless: HashSet::new(),
            not_finite: None,
            explained: HashSet::new(),
            library: false,
            render: None,
            mix,
            fps: None,
            end: None,
            stopped: false,
            calls: 0,
            depth: 0,
            fuel: limits::FUEL,
            copies: 0,
            inline: Inline::default(),
            inline_names: FxHashMap::default(),
            watched: Watching::default(),
        }
    }

    /// The file's number.
    pub fn file(&self) -> FileId {
        self.source.id
    }

    /// Adds a finding, once a place, with the calls that led to it.
    pub fn report(&mut self, mut diagnostic: Diagnostic) {
        if self.stopped {
            return;
        }
        self.out_of_library(&mut diagnostic);
        // "Not yet" is said once a thing, everything else once a place.
        let key = match (diagnostic.code, diagnostic.place()) {
            ("E1101", _) | (_, None) => (diagnostic.code, Span::at(0), diagnostic.message.clone()),
            (code, Some((_, place))) => (code, place, String::new()),
        };
        if !self.seen.insert(key) {
            return;
        }
        if !self.kept.takes(&diagnostic) {
            return;
        }
        self.note_trace(&mut diagnostic);
        self.diagnostics.push(diagnostic);
    }

    /// Notes of the calls and loops around: the three nearest; of what calls itself without end, the three that it began
    /// with and the last.
    fn note_trace(&self, diagnostic: &mut Diagnostic) {
        let all = std::iter::successors(self.trace.as_deref(), |here| here.parent.as_deref());
        if !matches!(diagnostic.code, "E1001" | "E0504") {
            diagnostic.notes.extend(all.take(3).map(|here| here.show(self.source)));
            return;
        }
        let all: Vec<&Trace<'_>> = all.collect();
        let Some((last, before)) = all.split_first() else { return };
        diagnostic.notes.extend(before.iter().rev().take(3).map(|here| here.show(self.source)));
        if let Some(more @ 1..) = before.len().checked_sub(3) {
            diagnostic.notes.push(format!("and {more} more of them, then"));
        }
        diagnostic.notes.push(last.show(self.source));
    }

    /// What goes wrong inside the standard library is about the call that led there: that becomes the place.
    fn out_of_library(&self, diagnostic: &mut Diagnostic) {
        let inside = |span: Span| !self.source.is_own(span.start) && is_path(&self.source.source(span.start).name);
        let Some((_, place)) = diagnostic.place().filter(|(_, span)| inside(*span)) else { return };
        let mut trace = self.trace.as_ref();
        while let Some(here) = trace {
            if !inside(here.span) {
                let what = self.text(place);
                let text = if what.len() < 60 { format!("`{what}` in there") } else { String::new() };
                for label in &mut diagnostic.labels {
                    label.primary = false;
                }
                diagnostic.labels.insert(0, Label { file: self.file(), span: here.span, text, primary: true });
                diagnostic.fixes.clear();
                return;
            }
            trace = here.parent.as_ref();
        }
    }

    /// Reports and gives the value that nothing is derived from.
    pub fn error(&mut self, diagnostic: Diagnostic) -> Value {
        self.report(diagnostic);
        Value::Error
    }

    /// Reports and ends the evaluation.
    pub fn stop(&mut self, diagnostic: Diagnostic) {
        self.report(diagnostic);
        self.stopped = true;
    }

    /// "Not yet", once for `what`.
    pub fn later(&mut self, what: &str, span: Span) -> Value {
        let diagnostic = not_yet(what, self.file(), span);
        self.error(diagnostic)
    }

    /// Uses up steps; false once there are none left.
    pub fn step(&mut self, cost: u64, span: Span) -> bool {
        if self.stopped {
            return false;
        }
        match self.fuel.checked_sub(cost) {
            Some(rest) => self.fuel = rest,
            None => {
                let line = self.source.line(span.start);
                let diagnostic = Diagnostic::new("E1003", "evaluation took too many steps")
                    .primary(self.file(), span, "the steps ran out here")
                    .note(format!("the limit is {} steps; {line} used the last one", limits::FUEL))
                    .help("make loops shorter, or compute less in each turn");
                self.stop(diagnostic);
            }
        }
        !self.stopped
    }

    /// Goes one level deeper, at a cost in steps; every `true` needs a [`Machine::leave`].
    pub fn enter(&mut self, cost: u64, span: Span) -> bool {
        if self.stopped || !self.step(cost, span) {
            return false;
        }
        if self.depth >= limits::DEPTH {
            let diagnostic = Diagnostic::new("E1001", "evaluation is nested too deeply")
                .primary(self.file(), span, "too deep here")
                .help("split long chains of values that depend on one another");
            self.stop(diagnostic);
            return false;
        }
        if self.graph.size() > limits::OPERATIONS {
            let limit = crate::eval::expr::spaced(limits::OPERATIONS as f64);
            let diagnostic = Diagnostic::new("E1004", format!("more than {limit} operations over time"))
                .primary(self.file(), span, "the last one")
                .help("compute less from `time` and `keys`");
            self.stop(diagnostic);
            return false;
        }
        self.depth += 1;
        true
    }

    /// Comes back from [`Machine::enter`].
    pub fn leave(&mut self) {
        self.depth -= 1;
    }

    /// Runs `body` as part of a call or a turn of a loop.
    pub fn traced<T>(
        &mut self,
        name: Option<&'a str>,
        span: Span,
        given: Vec<Given<'a>>,
        env: &Rc<Scope<'a>>,
        body: impl FnOnce(&mut Self) -> T,
    ) -> T {
        let outer = self.trace.clone();
        self.trace = Some(Rc::new(Trace { parent: outer.clone(), name, span, given, env: env.clone() }));
        let result = body(self);
        self.trace = outer;
        result
    }

    /// The text of a place.
    pub fn text(&self, span: Span) -> &'a str {
        self.source.slice(span)
    }

    /// The node's value, if it is evaluated.
    pub fn done(&self, id: NodeId) -> Option<Rc<NodeValue<'a>>> {
        match self.nodes.get(id.0 as usize).map(|slot| &slot.state) {
            Some(NodeState::Done(value)) => Some(value.clone()),
            _ => None,
        }
    }

    /// As a message names the value; nodes by what they can be used as.
    pub fn describe(&self, value: &Value) -> String {
        match value {
            Value::Node(id) => match self.done(*id).map(|node| node.kind) {
                Some(NodeKind::Schema(kind)) => kind.sort.with_article().into(),
                Some(NodeKind::Prefab(_)) => "a prefab".into(),
                _ => "a node".into(),
            },
            value => value.with_article(),
        }
    }
}

/// The answer to what comes later.
pub fn not_yet(what: &str, file: FileId, span: Span) -> Diagnostic {
    Diagnostic::new("E1101", format!("not yet: {what}"))
        .primary(file, span, "understood, but this version cannot do it")
        .note("it is part of the language and comes in a later version")
}
