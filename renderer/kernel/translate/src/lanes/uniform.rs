//! Which values are the same in all lanes, and which control flow needs masks.
//!
//! A variable is uniform if every store gives it a uniform value and stands where all lanes that can read it later run it
//! together. Those are the lanes in the variable's home: the innermost block with all its uses.

use std::collections::{HashMap, HashSet};

use naga::{AddressSpace, Block, Expression, Handle, LocalVariable, Module, Statement, SwitchCase};

/// Where a block stands in its function.
#[derive(Clone, Copy)]
struct Place {
    parent: usize,
    /// The index of the construct that decides whether a lane runs the block; `None` for a plain block.
    decider: Option<usize>,
    /// Whether the block may run more than once a call.
    repeats: bool,
}

/// What the lanes of one function have in common.
#[derive(Default)]
pub struct Uniform {
    varying: HashSet<Handle<Expression>>,
    varying_locals: HashSet<Handle<LocalVariable>>,
    places: Vec<Place>,
    /// By the address of a block: its index in `places`.
    ids: HashMap<*const Block, usize>,
    /// The constructs at which lanes part: by index, an `if`, `switch` or loop.
    masked: HashSet<usize>,
    constructs: usize,
    homes: HashMap<Handle<LocalVariable>, usize>,
}

/// Where a `break` leads.
#[derive(Clone, Copy)]
enum Target {
    Loop(usize),
    Switch(usize),
}

impl Uniform {
    /// Looks at a function until nothing more is found to differ between lanes. What a native function gives may always
    /// differ.
    pub fn new(module: &Module, function: &naga::Function, is_native: &dyn Fn(Handle<naga::Function>) -> bool) -> Self {
        let mut uniform = Self::default();
        uniform.places.push(Place { parent: 0, decider: None, repeats: false });
        uniform.map(&function.body, 0);
        let mut uses: HashMap<Handle<LocalVariable>, Vec<(usize, bool)>> = HashMap::new();
        uniform.uses(function, &function.body, &mut uses);
        for (local, uses) in uses {
            let home = uses.iter().map(|&(block, _)| block).reduce(|a, b| uniform.common(a, b)).unwrap_or(0);
            // Beside the place where it is used, a variable's first value must be the same for all: the one that it is
            // declared with if the home runs once a call, else one stored at the home's start.
            let fresh = !uniform.places[home].repeats || uses.first() == Some(&(home, true));
            uniform.homes.insert(local, if fresh { home } else { 0 });
        }
        loop {
            let before = (uniform.varying.len(), uniform.varying_locals.len(), uniform.masked.len());
            let mut walk = Walk { module, function, is_native, uniform: &mut uniform, targets: Vec::new() };
            walk.block(&function.body);
            if before == (uniform.varying.len(), uniform.varying_locals.len(), uniform.masked.len()) {
                return uniform;
            }
        }
    }

    /// Whether the value differs between lanes.
    pub fn varies(&self, handle: Handle<Expression>) -> bool {
        self.varying.contains(&handle)
    }

    /// Whether the variable's value differs between lanes.
    pub fn local_varies(&self, local: Handle<LocalVariable>) -> bool {
        self.varying_locals.contains(&local)
    }

    /// Whether lanes part at the construct whose first block this is.
    pub fn parts(&self, first: &Block) -> bool {
        let decider = self.ids.get(&std::ptr::from_ref(first)).and_then(|&id| self.places[id].decider);
        decider.is_none_or(|decider| self.masked.contains(&decider))
    }

    /// Whether all lanes that may read the variable later run this block, so that a store there needs no mask.
    pub fn stores_whole(&self, block: &Block, local: Handle<LocalVariable>) -> bool {
        let Some(&id) = self.ids.get(&std::ptr::from_ref(block)) else { return false };
        self.homes.get(&local).is_some_and(|&home| !self.parted(home, id))
    }

    /// Whether all lanes of the function that did not return run the block together.
    pub fn together(&self, block: &Block) -> bool {
        self.ids.get(&std::ptr::from_ref(block)).is_some_and(|&id| !self.parted(0, id))
    }

    fn map(&mut self, block: &Block, id: usize) {
        self.ids.insert(std::ptr::from_ref(block), id);
        let repeats = self.places[id].repeats;
        for statement in block {
            match statement {
                Statement::Block(inner) => self.child(inner, id, None, repeats),
                Statement::If { accept, reject, .. } => {
                    let decider = self.construct();
                    self.child(accept, id, Some(decider), repeats);
                    self.child(reject, id, Some(decider), repeats);
                }
                Statement::Switch { cases, .. } => {
                    let decider = self.construct();
                    cases.iter().for_each(|case| self.child(&case.body, id, Some(decider), repeats));
                }
                Statement::Loop { body, continuing, .. } => {
                    let decider = self.construct();
                    self.child(body, id, Some(decider), true);
                    // What the body declares lives on into the end of a turn.
                    let body = self.ids[&std::ptr::from_ref(body)];
                    self.child(continuing, body, None, true);
                }
                _ => {}
            }
        }
    }

    fn construct(&mut self) -> usize {
        self.constructs += 1;
        self.constructs
    }

    fn child(&mut self, block: &Block, parent: usize, decider: Option<usize>, repeats: bool) {
        let id = self.places.len();
        self.places.push(Place { parent, decider, repeats });
        self.map(block, id);
    }

    fn decider(&self, block: &Block) -> usize {
        self.ids.get(&std::ptr::from_ref(block)).and_then(|&id| self.places[id].decider).unwrap_or(0)
    }

    fn depth(&self, mut id: usize) -> usize {
        let mut depth = 0;
        while id != 0 {
            id = self.places[id].parent;
            depth += 1;
        }
        depth
    }

    fn common(&self, mut a: usize, mut b: usize) -> usize {
        while a != b {
            if self.depth(a) >= self.depth(b) {
                a = self.places[a].parent;
            } else {
                b = self.places[b].parent;
            }
        }
        a
    }

    /// Whether lanes part on the way from `outer` to `inner`.
    fn parted(&self, outer: usize, mut inner: usize) -> bool {
        while inner != outer {
            if self.places[inner].decider.is_some_and(|decider| self.masked.contains(&decider)) || inner == 0 {
                return true;
            }
            inner = self.places[inner].parent;
        }
        false
    }

    /// The blocks that use each variable, in order, and whether the use stores all of it.
    fn uses(
        &self,
        function: &naga::Function,
        block: &Block,
        found: &mut HashMap<Handle<LocalVariable>, Vec<(usize, bool)>>,
    ) {
        let id = self.ids[&std::ptr::from_ref(block)];
        let root = |handle| root_of(function, handle);
        for statement in block {
            match statement {
                Statement::Emit(range) => {
                    for handle in range.clone() {
                        if let Expression::Load { pointer } = function.expressions[handle]
                            && let Some(local) = root(pointer)
                        {
                            found.entry(local).or_default().push((id, false));
                        }
                    }
                }
                Statement::Store { pointer, .. } => {
                    if let Some(local) = root(*pointer) {
                        let whole = matches!(function.expressions[*pointer], Expression::LocalVariable(_));
                        found.entry(local).or_default().push((id, whole));
                    }
                }
                Statement::Call { arguments, .. } => {
                    for local in arguments.iter().filter_map(|&argument| root(argument)) {
                        found.entry(local).or_default().push((id, false));
                    }
                }
                Statement::Block(inner) => self.uses(function, inner, found),
                Statement::If { accept, reject, .. } => {
                    self.uses(function, accept, found);
                    self.uses(function, reject, found);
                }
                Statement::Switch { cases, .. } => {
                    cases.iter().for_each(|case| self.uses(function, &case.body, found));
                }
                Statement::Loop { body, continuing, .. } => {
                    self.uses(function, body, found);
                    self.uses(function, continuing, found);
                }
                _ => {}
            }
        }
    }
}

/// The variable that a pointer points into.
pub fn root_of(function: &naga::Function, mut handle: Handle<Expression>) -> Option<Handle<LocalVariable>> {
    loop {
        match function.expressions[handle] {
            Expression::LocalVariable(local) => return Some(local),
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => handle = base,
            _ => return None,
        }
    }
}

struct Walk<'a> {
    module: &'a Module,
    function: &'a naga::Function,
    is_native: &'a dyn Fn(Handle<naga::Function>) -> bool,
    uniform: &'a mut Uniform,
    targets: Vec<(Target, usize)>,
}

impl Walk<'_> {
    fn varies(&self, handle: Handle<Expression>) -> bool {
        let any = |list: &[Handle<Expression>]| list.iter().any(|&part| self.varies(part));
        match self.function.expressions[handle] {
            Expression::Literal(_) | Expression::Constant(_) | Expression::ZeroValue(_) => false,
            Expression::FunctionArgument(_) => true,
            // A pointer: what it is indexed with decides.
            Expression::GlobalVariable(global) => !matches!(
                self.module.global_variables[global].space,
                AddressSpace::Uniform | AddressSpace::Storage { .. }
            ),
            Expression::LocalVariable(local) => self.uniform.varying_locals.contains(&local),
            _ if self.uniform.varying.contains(&handle) => true,
            Expression::CallResult(_) => false,
            Expression::Compose { ref components, .. } => any(components),
            Expression::Splat { value, .. } => self.varies(value),
            Expression::Swizzle { vector, .. } => self.varies(vector),
            Expression::Access { base, index } => any(&[base, index]),
            Expression::AccessIndex { base, .. } => self.varies(base),
            Expression::Load { pointer } => self.varies(pointer),
            Expression::Unary { expr, .. } | Expression::As { expr, .. } => self.varies(expr),
            Expression::Binary { left, right, .. } => any(&[left, right]),
            Expression::Select { condition, accept, reject } => any(&[condition, accept, reject]),
            Expression::Relational { argument, .. } => self.varies(argument),
            Expression::Math { arg, arg1, arg2, arg3, .. } => {
                [Some(arg), arg1, arg2, arg3].into_iter().flatten().any(|part| self.varies(part))
            }
            Expression::ArrayLength(_) => false,
            _ => true,
        }
    }

    fn mask(&mut self, decider: usize) {
        self.uniform.masked.insert(decider);
    }

    fn id(&self, block: &Block) -> usize {
        self.uniform.ids.get(&std::ptr::from_ref(block)).copied().unwrap_or(0)
    }

    fn block(&mut self, block: &Block) {
        let id = self.id(block);
        for statement in block {
            match statement {
                Statement::Emit(range) => {
                    for handle in range.clone() {
                        if self.varies(handle) {
                            self.uniform.varying.insert(handle);
                        }
                    }
                }
                Statement::Store { pointer, value } => {
                    let Some(local) = root_of(self.function, *pointer) else { continue };
                    let home = self.uniform.homes.get(&local).copied().unwrap_or(0);
                    if self.varies(*pointer) || self.varies(*value) || self.uniform.parted(home, id) {
                        self.uniform.varying_locals.insert(local);
                    }
                }
                Statement::Call { function, arguments, result } => {
                    let mut varies = (self.is_native)(*function);
                    for &argument in arguments {
                        varies |= self.varies(argument);
                        if let Some(local) = root_of(self.function, argument)
                            && matches!(self.function.expressions[argument], Expression::LocalVariable(_))
                        {
                            self.uniform.varying_locals.insert(local);
                            varies = true;
                        }
                    }
                    if let Some(result) = result
                        && varies
                    {
                        self.uniform.varying.insert(*result);
                    }
                }
                Statement::Block(inner) => self.block(inner),
                Statement::If { condition, accept, reject } => {
                    if self.varies(*condition) {
                        self.mask(self.uniform.decider(accept));
                    }
                    self.block(accept);
                    self.block(reject);
                }
                Statement::Switch { selector, cases } => self.switch(*selector, cases, id),
                Statement::Loop { body, continuing, break_if } => {
                    let decider = self.uniform.decider(body);
                    self.targets.push((Target::Loop(decider), self.id(body)));
                    self.block(body);
                    self.block(continuing);
                    self.targets.pop();
                    if break_if.is_some_and(|condition| self.varies(condition)) {
                        self.mask(decider);
                    }
                }
                Statement::Break => {
                    if let Some(&(Target::Loop(decider) | Target::Switch(decider), outer)) = self.targets.last() {
                        self.leave(decider, outer, id);
                    }
                }
                Statement::Continue => {
                    let innermost = self.targets.iter().rposition(|(target, _)| matches!(target, Target::Loop(_)));
                    let Some(innermost) = innermost else { continue };
                    let outer = self.targets[innermost].1;
                    for i in innermost..self.targets.len() {
                        let (Target::Loop(decider) | Target::Switch(decider), _) = self.targets[i];
                        self.leave(decider, outer, id);
                    }
                }
                Statement::Return { .. } => {
                    for i in 0..self.targets.len() {
                        let (Target::Loop(decider) | Target::Switch(decider), _) = self.targets[i];
                        if matches!(self.targets[i].0, Target::Loop(_)) || self.uniform.parted(0, id) {
                            self.mask(decider);
                        }
                    }
                }
                _ => {}
            }
        }
    }

    /// Lanes that leave a construct one by one part there.
    fn leave(&mut self, decider: usize, outer: usize, id: usize) {
        if self.uniform.parted(outer, id) {
            self.mask(decider);
        }
    }

    fn switch(&mut self, selector: Handle<Expression>, cases: &[SwitchCase], outer: usize) {
        let Some(first) = cases.first() else { return };
        let decider = self.uniform.decider(&first.body);
        if self.varies(selector) {
            self.mask(decider);
        }
        self.targets.push((Target::Switch(decider), outer));
        cases.iter().for_each(|case| self.block(&case.body));
        self.targets.pop();
    }
}
