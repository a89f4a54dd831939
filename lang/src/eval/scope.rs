//! Names and what they stand for while a scene is evaluated.

use std::cell::RefCell;
use std::rc::Rc;

use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use crate::syntax::ast;
use crate::value::{NodeId, Value};

/// What a name stands for.
#[derive(Debug, Clone)]
pub enum Binding<'a> {
    /// A `let` or `param`, computed when it is first asked for.
    Let(Rc<LetCell<'a>>),
    /// A parameter or a loop's variable.
    Value(Value),
    /// A function.
    Fn(&'a ast::FnDecl),
    /// A prefab.
    Prefab(&'a ast::PrefabDecl),
    /// A named node.
    Node(NodeId),
    /// An imported file, by what it declares.
    Module(Rc<Scope<'a>>),
    /// A name of an imported file.
    Import(Rc<Scope<'a>>, &'a str),
    /// Something that is reported already, such as an import that leads nowhere.
    Opaque,
}

/// A `let` or `param` and its value.
#[derive(Debug)]
pub struct LetCell<'a> {
    /// The name, absent where it is missing.
    pub name: Option<&'a ast::Name>,
    /// The declared type.
    pub ty: Option<&'a ast::Type>,
    /// What is computed.
    pub value: &'a ast::Expr,
    /// Whether the command line gave the value.
    pub overridden: bool,
    /// How far it is.
    pub state: RefCell<LetState>,
}

/// How far a `let` is computed.
#[derive(Debug, Clone)]
pub enum LetState {
    /// Not yet.
    Waiting,
    /// It is being computed: asked for again, it depends on itself.
    Running,
    /// It is.
    Done(Value),
}

/// One block's names.
#[derive(Debug, Default)]
pub struct Scope<'a> {
    parent: Option<Rc<Scope<'a>>>,
    names: RefCell<Names<'a>>,
    of_turn: bool,
}

/// Names and what they stand for: a list, and a table beside it where there are many.
#[derive(Debug, Default)]
struct Names<'a> {
    list: SmallVec<[(&'a str, Binding<'a>); 1]>,
    table: FxHashMap<&'a str, usize>,
}

/// So many names are looked through faster than hashed.
const FEW: usize = 8;

impl<'a> Names<'a> {
    fn get(&self, name: &str) -> Option<&Binding<'a>> {
        match self.list.len() <= FEW {
            true => self.list.iter().find(|(own, _)| *own == name).map(|(_, binding)| binding),
            false => self.table.get(name).map(|at| &self.list[*at].1),
        }
    }

    fn insert(&mut self, name: &'a str, binding: Binding<'a>) {
        if self.get(name).is_some() {
            return;
        }
        self.list.push((name, binding));
        if self.list.len() > FEW {
            let first = self.table.len();
            self.table.extend(self.list.iter().enumerate().skip(first).map(|(at, (name, _))| (*name, at)));
        }
    }
}

impl<'a> Scope<'a> {
    /// A scope inside another.
    pub fn inside(parent: &Rc<Scope<'a>>) -> Rc<Scope<'a>> {
        Rc::new(Scope { parent: Some(parent.clone()), names: RefCell::default(), of_turn: false })
    }

    /// The scope of one turn of a loop or of one call: others of the same text may follow.
    pub fn of_turn(parent: &Rc<Scope<'a>>) -> Rc<Scope<'a>> {
        Rc::new(Scope { parent: Some(parent.clone()), names: RefCell::default(), of_turn: true })
    }

    /// Whether it is the scope of one turn or call.
    pub fn is_of_turn(&self) -> bool {
        self.of_turn
    }

    /// Whether nothing is around it.
    pub fn is_outermost(&self) -> bool {
        self.parent.is_none()
    }

    /// It and the scopes around it, from the inside out.
    pub fn around(self: &Rc<Scope<'a>>) -> impl Iterator<Item = &Rc<Scope<'a>>> {
        std::iter::successors(Some(self), |scope| scope.parent.as_ref())
    }

    /// Whether the scope itself declares the name.
    pub fn has(&self, name: &str) -> bool {
        self.names.borrow().get(name).is_some()
    }

    /// Declares a name; the first declaration of a name stays.
    pub fn declare(&self, name: &'a str, binding: Binding<'a>) {
        self.names.borrow_mut().insert(name, binding);
    }

    /// What the name stands for in this scope itself.
    pub fn own(&self, name: &str) -> Option<Binding<'a>> {
        self.names.borrow().get(name).cloned()
    }

    /// The value of a parameter or a loop's variable, if the innermost binding of the name is one.
    pub fn value(&self, name: &str) -> Option<Value> {
        let mut scope = Some(self);
        while let Some(here) = scope {
            match here.names.borrow().get(name) {
                Some(Binding::Value(value)) => return Some(value.clone()),
                Some(_) => return None,
                None => scope = here.parent.as_deref(),
            }
        }
        None
    }

    /// The innermost binding of the name that `wanted` accepts, with its scope.
    pub fn find(
        self: &Rc<Scope<'a>>,
        name: &str,
        wanted: impl Fn(&Binding<'a>) -> bool,
    ) -> Option<(Rc<Scope<'a>>, Binding<'a>)> {
        let mut scope = Some(self);
        while let Some(here) = scope {
            match here.names.borrow().get(name) {
                Some(Binding::Import(module, original)) => {
                    if let Some(binding) = module.offered(original).filter(&wanted) {
                        return Some((module.clone(), binding));
                    }
                }
                Some(binding) if wanted(binding) => return Some((here.clone(), binding.clone())),
                _ => {}
            }
            scope = here.parent.as_ref();
        }
        None
    }

    /// What a file's scope has for others: what it declares, and not what it imports.
    fn offered(&self, name: &str) -> Option<Binding<'a>> {
        self.own(name).filter(|binding| !matches!(binding, Binding::Module(_) | Binding::Import(..)))
    }

    /// As [`Scope::find`] for `name`, or for `module.name`, and how many names of the path that is.
    pub fn find_path(
        self: &Rc<Scope<'a>>,
        path: &[ast::Name],
        wanted: impl Fn(&Binding<'a>) -> bool,
    ) -> Option<(Rc<Scope<'a>>, Binding<'a>, usize)> {
        let first = path.first()?;
        let module = |binding: &Binding<'a>| path.len() > 1 && matches!(binding, Binding::Module(_));
        match self.find(&first.text, |binding| module(binding) || wanted(binding))? {
            (_, Binding::Module(module)) => {
                let binding = module.offered(&path.get(1)?.text).filter(wanted)?;
                Some((module, binding, 2))
            }
            (scope, binding) => Some((scope, binding, 1)),
        }
    }
}
