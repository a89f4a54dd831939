//! Statements on lanes: control flow becomes masks where lanes part, and stays control flow where they do not.

use naga::valid::FunctionInfo;
use naga::{AddressSpace, Block, Expression, Handle, Module, Statement, SwitchCase, SwitchValue, Type, TypeInner};

use super::uniform::{Uniform, root_of};
use super::value::Lanes;
use super::{lane_type, select, splat};
use crate::expression::{self, Values};
use crate::items::{Callee, Items};
use crate::types::{Reason, rust_type};

/// A longer uniform expression gets a `let` of its own.
const LONGEST_INLINE: usize = 160;
/// A side of an `if` with no more expressions than this runs without a look at who asked for it.
const CHEAP: usize = 12;

/// One function as a method.
pub fn function(
    module: &Module,
    items: &Items,
    info: &FunctionInfo,
    function: &naga::Function,
    name: &str,
) -> Result<String, Reason> {
    let mut names = items.names.clone();
    let mask = names.unique("mask");
    let mut arguments = Vec::new();
    let mut signature = format!("    #[function]\n    pub fn {name}(&self, {mask}: w::M");
    for argument in &function.arguments {
        let name = names.unique(argument.name.as_deref().unwrap_or("argument"));
        signature += &format!(", {name}: {}", lane_type(module, argument.ty)?);
        arguments.push(name);
    }
    signature.push(')');
    if let Some(result) = &function.result {
        signature += &format!(" -> {}", lane_type(module, result.ty)?);
    }
    let scalar = Values {
        module,
        items,
        info,
        function,
        names,
        arguments,
        locals: Default::default(),
        texts: Default::default(),
        tables: Default::default(),
        statics: Vec::new(),
    };
    let lanes = Lanes {
        scalar,
        uniform: Uniform::new(module, function, &|callee| {
            matches!(items.functions.get(&callee), Some(Callee::Native(_)))
        }),
        locals: Default::default(),
        texts: Default::default(),
        before: Vec::new(),
        mask: mask.clone(),
        rows: Vec::new(),
    };
    let mut body = Body {
        lanes,
        lines: Vec::new(),
        depth: 2,
        labels: 0,
        mask: mask.clone(),
        targets: Vec::new(),
        returned: None,
        exit: Exit::Function,
    };
    body.line(format!("let mut {mask} = {mask};"));
    body.start()?;
    body.block(&function.body)?;
    let mut text = signature + " {\n";
    for line in &body.lanes.scalar.statics {
        text += &format!("        {line}\n");
    }
    for line in &body.lines {
        text += line;
        text.push('\n');
    }
    if let Some(returned) = &body.returned
        && function.result.is_some()
        && !always_returns(&function.body)
    {
        text += &format!("        {}\n", returned.value);
    }
    Ok(text + "    }\n")
}

/// Where `break` and `continue` lead.
#[derive(Clone)]
enum Target<'a> {
    Loop {
        label: usize,
        /// The mask of the lanes that are still in the loop, where lanes leave it one by one.
        lanes: Option<String>,
        continuing: &'a Block,
        break_if: Option<Handle<Expression>>,
    },
    Switch {
        label: usize,
        /// The mask of the lanes that left it, where lanes part.
        out: Option<String>,
    },
}

/// Where to go when no lane is left.
#[derive(Clone, Copy)]
enum Exit {
    Function,
    Label(usize),
    Turn,
}

/// What lanes that returned before others left behind.
struct Returned {
    value: String,
    /// The mask of the lanes that did not.
    live: String,
}

struct Body<'a> {
    lanes: Lanes<'a>,
    lines: Vec<String>,
    depth: usize,
    labels: usize,
    /// The variable with the lanes that run the statement at hand.
    mask: String,
    targets: Vec<Target<'a>>,
    returned: Option<Returned>,
    exit: Exit,
}

impl<'a> Body<'a> {
    fn line(&mut self, text: impl AsRef<str>) {
        self.lines.push(format!("{}{}", "    ".repeat(self.depth), text.as_ref()));
    }

    fn flush(&mut self) {
        for line in std::mem::take(&mut self.lanes.before) {
            self.line(line);
        }
    }

    fn label(&mut self) -> usize {
        self.labels += 1;
        self.labels
    }

    fn name(&mut self, name: &str) -> String {
        self.lanes.scalar.names.unique(name)
    }

    fn value(&mut self, handle: Handle<Expression>) -> Result<String, Reason> {
        self.lanes.mask.clone_from(&self.mask);
        let text = self.lanes.value(handle)?;
        self.flush();
        Ok(text)
    }

    fn start(&mut self) -> Result<(), Reason> {
        let (module, function) = (self.lanes.scalar.module, self.lanes.scalar.function);
        if returns_apart(&self.lanes.uniform, &function.body) {
            let (value, live) = (self.name("returned"), self.name("live"));
            if let Some(result) = &function.result {
                let zero = self.lanes.zero(result.ty)?;
                self.line(format!("let mut {value} = {zero};"));
            }
            self.line(format!("let mut {live} = {};", self.mask));
            self.returned = Some(Returned { value, live });
        }
        for (handle, local) in function.local_variables.iter() {
            let name = self.name(local.name.as_deref().unwrap_or("local"));
            let value = match local.init {
                Some(init) => expression::constant(module, self.lanes.scalar.items, &function.expressions, init)?,
                None => expression::zero(module, local.ty)?,
            };
            if self.lanes.uniform.local_varies(handle) {
                let value = splat(module, local.ty, &value)?;
                self.line(format!("let mut {name}: {} = {value};", lane_type(module, local.ty)?));
            } else {
                self.line(format!("let mut {name}: {} = {value};", rust_type(module, local.ty)?));
                self.lanes.scalar.locals.insert(handle, name.clone());
            }
            self.lanes.locals.insert(handle, name);
        }
        Ok(())
    }

    fn block(&mut self, block: &'a Block) -> Result<(), Reason> {
        let rows = self.lanes.rows.len();
        block.iter().try_for_each(|statement| self.statement(statement, block))?;
        self.lanes.rows.truncate(rows);
        Ok(())
    }

    fn nested(&mut self, block: &'a Block) -> Result<(), Reason> {
        self.depth += 1;
        self.block(block)?;
        self.depth -= 1;
        Ok(())
    }

    /// A block under a mask of its own.
    fn masked(&mut self, block: &'a Block, mask: &str, exit: Exit) -> Result<(), Reason> {
        let outer = (std::mem::replace(&mut self.mask, mask.to_owned()), std::mem::replace(&mut self.exit, exit));
        self.nested(block)?;
        (self.mask, self.exit) = outer;
        Ok(())
    }

    fn emit(&mut self, handle: Handle<Expression>) -> Result<(), Reason> {
        let values = &mut self.lanes.scalar;
        if matches!(values.inner(handle), TypeInner::Pointer { .. } | TypeInner::ValuePointer { .. }) {
            return Ok(());
        }
        let count = values.info[handle].ref_count;
        let named = values.function.named_expressions.get(&handle).cloned();
        if count == 0 {
            return Ok(());
        }
        if self.lanes.varies(handle) {
            self.lanes.texts.remove(&handle);
            self.lanes.mask.clone_from(&self.mask);
            let text = self.lanes.compute(handle)?;
            self.flush();
            let variable = matches!(self.lanes.scalar.function.expressions[handle], Expression::Load { .. });
            let path = text.bytes().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'.'));
            if path && !variable {
                self.lanes.texts.insert(handle, text);
            } else {
                self.bind(handle, &text, named);
            }
            return Ok(());
        }
        let values = &mut self.lanes.scalar;
        values.texts.remove(&handle);
        let text = values.value(handle)?;
        let named = named.filter(|_| !values.tables.contains_key(&handle));
        let variable = match values.function.expressions[handle] {
            Expression::Load { pointer } => match *values.inner(pointer) {
                TypeInner::Pointer { space, .. } | TypeInner::ValuePointer { space, .. } => {
                    space == AddressSpace::Function
                }
                _ => true,
            },
            _ => false,
        };
        let cheap = text.bytes().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'.'));
        if named.is_some() || variable || (count > 1 && !cheap) || text.len() > LONGEST_INLINE {
            self.bind_scalar(handle, &text, named);
        } else {
            values.texts.insert(handle, text);
        }
        Ok(())
    }

    fn bind(&mut self, handle: Handle<Expression>, text: &str, named: Option<String>) {
        let name = self.name(&named.unwrap_or_else(|| format!("e{}", handle.index())));
        self.line(format!("let {name} = {text};"));
        self.lanes.texts.insert(handle, name);
    }

    fn bind_scalar(&mut self, handle: Handle<Expression>, text: &str, named: Option<String>) {
        let name = self.name(&named.unwrap_or_else(|| format!("e{}", handle.index())));
        self.line(format!("let {name} = {text};"));
        self.lanes.scalar.texts.insert(handle, name);
    }

    fn statement(&mut self, statement: &'a Statement, block: &'a Block) -> Result<(), Reason> {
        match statement {
            Statement::Emit(range) => range.clone().try_for_each(|handle| self.emit(handle)),
            Statement::Block(inner) => {
                self.line("{");
                self.nested(inner)?;
                self.line("}");
                Ok(())
            }
            Statement::If { condition, accept, reject } => self.choose(*condition, accept, reject),
            Statement::Switch { selector, cases } => self.switch(*selector, cases),
            Statement::Loop { body, continuing, break_if } => self.turns(body, continuing, *break_if),
            Statement::Break => self.leave(),
            Statement::Continue => self.skip(),
            Statement::Return { value } => self.give(*value, block),
            Statement::Store { pointer, value } => {
                if self.lanes.stores_scalar(*pointer) {
                    let value = self.lanes.scalar.value(*value)?;
                    let target = self.lanes.scalar.target(*pointer)?;
                    self.line(format!("{target} = {value};"));
                    return Ok(());
                }
                let value = self.value(*value)?;
                let whole = root_of(self.lanes.scalar.function, *pointer)
                    .is_some_and(|local| self.lanes.uniform.stores_whole(block, local));
                let mask = self.mask.clone();
                let lines = self.lanes.store(*pointer, &value, (!whole).then_some(mask.as_str()))?;
                self.flush();
                lines.iter().for_each(|line| self.line(line));
                Ok(())
            }
            Statement::Call { function, arguments, result } => {
                let (name, native) = match self.lanes.scalar.items.functions.get(function) {
                    Some(Callee::Method(name)) => (name.as_str(), false),
                    Some(Callee::Native(path)) => (path.rsplit("::").next().unwrap_or(path), true),
                    None => return Err("a call of an unknown function".to_owned()),
                };
                let mut list = vec![self.mask.clone()];
                if native {
                    list.insert(0, "self".to_owned());
                }
                if let Some(result) = *result
                    && !self.lanes.varies(result)
                {
                    list.clear();
                    for &argument in arguments {
                        list.push(self.lanes.scalar.value(argument)?);
                    }
                    self.bind_scalar(result, &format!("self.0.{name}({})", list.join(", ")), None);
                    return Ok(());
                }
                for &argument in arguments {
                    let inner = self.lanes.inner(argument);
                    list.push(match inner {
                        TypeInner::Pointer { space: AddressSpace::Function, .. } => self.lanes.lent(argument)?,
                        TypeInner::Pointer { .. } | TypeInner::ValuePointer { .. } => {
                            return Err("a pointer of this kind as an argument".to_owned());
                        }
                        _ => self.value(argument)?,
                    });
                }
                let callee = if native { format!("native::{name}") } else { format!("self.{name}") };
                let call = format!("{callee}({})", list.join(", "));
                let named =
                    result.and_then(|result| self.lanes.scalar.function.named_expressions.get(&result).cloned());
                match result {
                    Some(result) => self.bind(*result, &call, named),
                    None => self.line(format!("{call};")),
                }
                Ok(())
            }
            _ => Err("this statement".to_owned()),
        }
    }

    /// Goes on where the block's lanes meet the others, if none of them is left.
    fn check_exit(&mut self) -> Result<(), Reason> {
        let mask = self.mask.clone();
        match self.exit {
            Exit::Function => {
                // Lanes leave a function by a return alone.
                let Some(returned) = &self.returned else { return Ok(()) };
                let value = match self.lanes.scalar.function.result {
                    Some(_) => returned.value.clone(),
                    None => String::new(),
                };
                self.line(format!("if {mask}.none() {{ return {value}; }}"));
            }
            Exit::Label(label) => self.line(format!("if {mask}.none() {{ break 'b{label}; }}")),
            Exit::Turn => {
                let innermost = self
                    .targets
                    .iter()
                    .rev()
                    .find(|target| matches!(target, Target::Loop { lanes: Some(_), .. }))
                    .cloned();
                if let Some(Target::Loop { label, lanes: Some(lanes), continuing, break_if }) = innermost {
                    self.line(format!("if {mask}.none() {{"));
                    self.depth += 1;
                    self.end_of_turn(&lanes, continuing, break_if)?;
                    self.line(format!("continue 'l{label};"));
                    self.depth -= 1;
                    self.line("}");
                }
            }
        }
        Ok(())
    }

    fn choose(&mut self, condition: Handle<Expression>, accept: &'a Block, reject: &'a Block) -> Result<(), Reason> {
        if !self.lanes.uniform.parts(accept) {
            let condition = self.lanes.scalar.value(condition)?;
            self.line(format!("if {condition} {{"));
            self.nested(accept)?;
            if !reject.is_empty() {
                self.line("} else {");
                self.nested(reject)?;
            }
            self.line("}");
            return Ok(());
        }
        let condition = self.value(condition)?;
        let outer = self.mask.clone();
        let (yes, no) = (self.name("yes"), self.name("no"));
        self.line(format!("let mut {yes} = {outer}.and({condition});"));
        self.line(format!("let mut {no} = {outer}.and_not({condition});"));
        self.side(accept, &yes)?;
        self.side(reject, &no)?;
        if leaves(accept) || leaves(reject) {
            self.line(format!("{outer} = {yes}.or({no});"));
            self.check_exit()?;
        }
        Ok(())
    }

    /// A block that only the lanes of `mask` run.
    fn side(&mut self, block: &'a Block, mask: &str) -> Result<(), Reason> {
        if block.is_empty() {
            return Ok(());
        }
        if self.cheap(block) {
            self.line("{");
            self.masked(block, mask, self.exit)?;
            self.line("}");
            return Ok(());
        }
        let label = self.label();
        self.line(format!("if {mask}.any() {{ 'b{label}: {{"));
        self.masked(block, mask, Exit::Label(label))?;
        self.line("} }");
        Ok(())
    }

    fn cheap(&self, block: &Block) -> bool {
        let mut expressions = 0;
        block.iter().all(|statement| match statement {
            Statement::Emit(range) => range.clone().all(|handle| {
                expressions += 1;
                expressions <= CHEAP && self.lanes.is_cheap(handle)
            }),
            Statement::Store { .. } => true,
            _ => false,
        })
    }

    fn turns(
        &mut self,
        body: &'a Block,
        continuing: &'a Block,
        break_if: Option<Handle<Expression>>,
    ) -> Result<(), Reason> {
        let label = self.label();
        if !self.lanes.uniform.parts(body) {
            self.line(format!("'l{label}: loop {{"));
            self.targets.push(Target::Loop { label, lanes: None, continuing, break_if });
            self.nested(body)?;
            self.depth += 1;
            self.end_of_uniform_turn(label, continuing, break_if)?;
            self.depth -= 1;
            self.targets.pop();
            self.line("}");
            return Ok(());
        }
        let (lanes, turn) = (self.name("looping"), self.name("turn"));
        self.line(format!("let mut {lanes} = {};", self.mask));
        self.line(format!("'l{label}: while {lanes}.any() {{"));
        self.line(format!("    let mut {turn} = {lanes};"));
        self.targets.push(Target::Loop { label, lanes: Some(lanes.clone()), continuing, break_if });
        // The end of a turn may use what the body binds.
        let rows = self.lanes.rows.len();
        self.masked(body, &turn, Exit::Turn)?;
        self.depth += 1;
        self.end_of_turn(&lanes, continuing, break_if)?;
        self.depth -= 1;
        self.lanes.rows.truncate(rows);
        self.targets.pop();
        self.line("}");
        if let Some(returned) = &self.returned
            && returns(body)
        {
            let live = returned.live.clone();
            let mask = self.mask.clone();
            self.line(format!("{mask} = {mask}.and({live});"));
            self.check_exit()?;
        }
        Ok(())
    }

    fn end_of_turn(
        &mut self,
        lanes: &str,
        continuing: &'a Block,
        break_if: Option<Handle<Expression>>,
    ) -> Result<(), Reason> {
        let outer = std::mem::replace(&mut self.mask, lanes.to_owned());
        self.block(continuing)?;
        if let Some(condition) = break_if {
            let condition = self.value(condition)?;
            self.line(format!("{lanes} = {lanes}.and_not({condition});"));
        }
        self.mask = outer;
        Ok(())
    }

    fn end_of_uniform_turn(
        &mut self,
        label: usize,
        continuing: &'a Block,
        break_if: Option<Handle<Expression>>,
    ) -> Result<(), Reason> {
        self.block(continuing)?;
        if let Some(condition) = break_if {
            let condition = self.lanes.scalar.value(condition)?;
            self.line(format!("if {condition} {{ break 'l{label}; }}"));
        }
        Ok(())
    }

    fn leave(&mut self) -> Result<(), Reason> {
        let mask = self.mask.clone();
        match self.targets.last().cloned() {
            Some(Target::Loop { label, lanes: None, .. } | Target::Switch { label, out: None }) => {
                self.line(format!("break 'l{label};"));
            }
            Some(Target::Loop { lanes: Some(lanes), .. }) => {
                self.line(format!("{lanes} = {lanes}.and_not({mask});"));
                self.line(format!("{mask} = w::M::splat(false);"));
            }
            Some(Target::Switch { out: Some(out), .. }) => {
                self.line(format!("{out} = {out}.or({mask});"));
                self.line(format!("{mask} = w::M::splat(false);"));
            }
            None => return Err("a break outside of a loop".to_owned()),
        }
        Ok(())
    }

    fn skip(&mut self) -> Result<(), Reason> {
        let innermost = self.targets.iter().rev().find(|target| matches!(target, Target::Loop { .. })).cloned();
        match innermost {
            Some(Target::Loop { lanes: Some(_), .. }) => {
                let mask = self.mask.clone();
                self.line(format!("{mask} = w::M::splat(false);"));
            }
            Some(Target::Loop { label, lanes: None, continuing, break_if }) => {
                self.end_of_uniform_turn(label, continuing, break_if)?;
                self.line(format!("continue 'l{label};"));
            }
            _ => return Err("a continue outside of a loop".to_owned()),
        }
        Ok(())
    }

    fn give(&mut self, value: Option<Handle<Expression>>, block: &'a Block) -> Result<(), Reason> {
        let module = self.lanes.scalar.module;
        let value = match value {
            Some(value) => Some(self.value(value)?),
            None => None,
        };
        let ty: Option<Handle<Type>> = self.lanes.scalar.function.result.as_ref().map(|result| result.ty);
        let mask = self.mask.clone();
        let before = self.returned.as_ref().map(|returned| (returned.value.clone(), returned.live.clone()));
        if self.lanes.uniform.together(block) {
            let text = match (value, ty, before) {
                (Some(value), Some(ty), Some((returned, _))) => {
                    let value = self.held(&value);
                    select(module, ty, &mask, &value, &returned)?
                }
                (Some(value), ..) => value,
                _ => String::new(),
            };
            self.line(format!("return {text};"));
            return Ok(());
        }
        let Some((returned, live)) = before else { return Err("a return that was not foreseen".to_owned()) };
        if let (Some(value), Some(ty)) = (value, ty) {
            let value = self.held(&value);
            let text = select(module, ty, &mask, &value, &returned)?;
            self.line(format!("{returned} = {text};"));
        }
        self.line(format!("{live} = {live}.and_not({mask});"));
        let loops: Vec<_> = self
            .targets
            .iter()
            .filter_map(|target| match target {
                Target::Loop { lanes: Some(lanes), .. } => Some(lanes.clone()),
                _ => None,
            })
            .collect();
        for lanes in loops {
            self.line(format!("{lanes} = {lanes}.and_not({mask});"));
        }
        self.line(format!("{mask} = w::M::splat(false);"));
        Ok(())
    }

    /// A name for a text that is used more than once.
    fn held(&mut self, text: &str) -> String {
        let name = self.name("value");
        self.line(format!("let {name} = {text};"));
        name
    }

    fn switch(&mut self, selector: Handle<Expression>, cases: &'a [SwitchCase]) -> Result<(), Reason> {
        let mut arms: Vec<(Vec<String>, &'a Block)> = Vec::new();
        let mut default: Option<&'a Block> = None;
        let mut patterns = Vec::new();
        let mut is_default = false;
        for case in cases {
            match case.value {
                SwitchValue::I32(value) => patterns.push(format!("{value}i32")),
                SwitchValue::U32(value) => patterns.push(format!("{value}u32")),
                SwitchValue::Default => is_default = true,
            }
            if case.fall_through {
                if !case.body.is_empty() {
                    return Err("a switch case that falls through".to_owned());
                }
                continue;
            }
            if std::mem::take(&mut is_default) {
                default = Some(&case.body);
                patterns.clear();
            } else {
                arms.push((std::mem::take(&mut patterns), &case.body));
            }
        }
        let Some(first) = cases.first() else { return Ok(()) };
        let label = self.label();
        if !self.lanes.uniform.parts(&first.body) {
            let selector = self.lanes.scalar.value(selector)?;
            self.line(format!("'l{label}: {{ match {selector} {{"));
            self.targets.push(Target::Switch { label, out: None });
            let arms = arms.into_iter().map(|(patterns, body)| (patterns.join(" | "), body));
            for (pattern, body) in arms.chain(default.map(|body| ("_".to_owned(), body))) {
                self.line(format!("{pattern} => {{"));
                self.nested(body)?;
                self.line("}");
            }
            if default.is_none() {
                self.line("_ => {}");
            }
            self.targets.pop();
            self.line("} }");
            return Ok(());
        }
        let uint = self.lanes.inner(selector).scalar_kind() == Some(naga::ScalarKind::Uint);
        let ty = if uint { "w::U" } else { "w::I" };
        let selector = self.value(selector)?;
        let selector = self.held(&selector);
        let outer = self.mask.clone();
        let (out, rest) = (self.name("out"), self.name("rest"));
        self.line(format!("let mut {out} = w::M::splat(false);"));
        self.line(format!("let mut {rest} = {outer};"));
        let mut masks = Vec::new();
        let mut sides = Vec::new();
        for (patterns, body) in arms {
            let mask = self.name("case");
            let tests: Vec<_> =
                patterns.iter().map(|pattern| format!("{selector}.eq({ty}::splat({pattern}))")).collect();
            let Some(test) = tests.into_iter().reduce(|a, b| format!("{a}.or({b})")) else { continue };
            self.line(format!("let mut {mask} = {rest}.and({test});"));
            self.line(format!("{rest} = {rest}.and_not({mask});"));
            masks.push(mask.clone());
            sides.push((mask, body));
        }
        masks.push(rest.clone());
        sides.extend(default.map(|body| (rest, body)));
        self.targets.push(Target::Switch { label, out: Some(out.clone()) });
        for (mask, body) in &sides {
            self.side(body, mask)?;
        }
        self.targets.pop();
        if sides.iter().any(|(_, body)| leaves(body)) {
            let all = masks.into_iter().fold(out, |all, mask| format!("{all}.or({mask})"));
            self.line(format!("{outer} = {all};"));
            self.check_exit()?;
        }
        Ok(())
    }
}

/// Whether a lane may leave the block before its end.
fn leaves(block: &Block) -> bool {
    block.iter().any(|statement| match statement {
        Statement::Break | Statement::Continue | Statement::Return { .. } => true,
        Statement::Block(block) => leaves(block),
        Statement::If { accept, reject, .. } => leaves(accept) || leaves(reject),
        Statement::Switch { cases, .. } => cases.iter().any(|case| leaves(&case.body)),
        Statement::Loop { body, .. } => returns(body),
        _ => false,
    })
}

fn returns(block: &Block) -> bool {
    block.iter().any(|statement| match statement {
        Statement::Return { .. } => true,
        Statement::Block(block) => returns(block),
        Statement::If { accept, reject, .. } => returns(accept) || returns(reject),
        Statement::Switch { cases, .. } => cases.iter().any(|case| returns(&case.body)),
        Statement::Loop { body, .. } => returns(body),
        _ => false,
    })
}

/// Whether some lanes may return while others go on.
fn returns_apart(uniform: &Uniform, block: &Block) -> bool {
    block.iter().any(|statement| match statement {
        Statement::Return { .. } => !uniform.together(block),
        Statement::Block(block) => returns_apart(uniform, block),
        Statement::If { accept, reject, .. } => returns_apart(uniform, accept) || returns_apart(uniform, reject),
        Statement::Switch { cases, .. } => cases.iter().any(|case| returns_apart(uniform, &case.body)),
        Statement::Loop { body, continuing, .. } => returns_apart(uniform, body) || returns_apart(uniform, continuing),
        _ => false,
    })
}

/// Whether the block ends in a return of all lanes.
fn always_returns(block: &Block) -> bool {
    match block.last() {
        Some(Statement::Return { .. }) => true,
        Some(Statement::Block(inner)) => always_returns(inner),
        _ => false,
    }
}
