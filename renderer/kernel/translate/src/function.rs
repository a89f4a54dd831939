//! Functions and statements.

use std::fmt::Write as _;

use naga::valid::FunctionInfo;
use naga::{AddressSpace, Block, Expression, Handle, Module, Statement, SwitchCase, SwitchValue, TypeInner};

use crate::expression::{self, Values};
use crate::items::{Callee, Items};
use crate::types::{Reason, rust_type};

/// A longer expression gets a `let` of its own, which also bounds the nesting.
const LONGEST_INLINE: usize = 160;

/// One function as a method.
pub fn function(
    module: &Module,
    items: &Items,
    info: &FunctionInfo,
    function: &naga::Function,
    name: &str,
) -> Result<String, Reason> {
    let mut names = items.names.clone();
    let mut arguments = Vec::new();
    let always = if items.inline.iter().any(|inner| inner == name) { "(always)" } else { "" };
    let mut signature = format!("    #[inline{always}]\n    pub fn {name}(&self");
    for argument in &function.arguments {
        let name = names.unique(argument.name.as_deref().unwrap_or("argument"));
        write!(signature, ", {name}: {}", rust_type(module, argument.ty)?).map_err(|_| "an argument")?;
        arguments.push(name);
    }
    signature.push(')');
    if let Some(result) = &function.result {
        signature += &format!(" -> {}", rust_type(module, result.ty)?);
    }
    let mut body = Body {
        values: Values {
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
        },
        lines: Vec::new(),
        depth: 2,
        labels: 0,
        targets: Vec::new(),
    };
    body.locals()?;
    body.block(&function.body)?;
    let mut text = signature + " {\n";
    for line in &body.values.statics {
        text += &format!("        {line}\n");
    }
    for line in &body.lines {
        text += line;
        text.push('\n');
    }
    Ok(text + "    }\n")
}

/// Where `break` and `continue` lead.
#[derive(Clone)]
enum Target<'a> {
    Loop { label: usize, continuing: &'a Block, break_if: Option<Handle<Expression>> },
    Switch { label: usize },
}

struct Body<'a> {
    values: Values<'a>,
    lines: Vec<String>,
    depth: usize,
    labels: usize,
    targets: Vec<Target<'a>>,
}

impl<'a> Body<'a> {
    fn line(&mut self, text: impl AsRef<str>) {
        self.lines.push(format!("{}{}", "    ".repeat(self.depth), text.as_ref()));
    }

    fn label(&mut self) -> usize {
        self.labels += 1;
        self.labels
    }

    fn locals(&mut self) -> Result<(), Reason> {
        let (module, function) = (self.values.module, self.values.function);
        for (handle, local) in function.local_variables.iter() {
            let name = self.values.names.unique(local.name.as_deref().unwrap_or("local"));
            let value = match local.init {
                Some(init) => expression::constant(module, self.values.items, &function.expressions, init)?,
                None => expression::zero(module, local.ty)?,
            };
            self.line(format!("let mut {name}: {} = {value};", rust_type(module, local.ty)?));
            self.values.locals.insert(handle, name);
        }
        Ok(())
    }

    fn nested(&mut self, block: &'a Block) -> Result<(), Reason> {
        self.depth += 1;
        self.block(block)?;
        self.depth -= 1;
        Ok(())
    }

    fn block(&mut self, block: &'a Block) -> Result<(), Reason> {
        block.iter().try_for_each(|statement| self.statement(statement))
    }

    fn bind(&mut self, handle: Handle<Expression>, text: &str) {
        let name = match self.values.function.named_expressions.get(&handle) {
            Some(name) => self.values.names.unique(name),
            None => self.values.names.unique(&format!("e{}", handle.index())),
        };
        self.line(format!("let {name} = {text};"));
        self.values.texts.insert(handle, name);
    }

    fn emit(&mut self, handle: Handle<Expression>) -> Result<(), Reason> {
        let values = &mut self.values;
        values.texts.remove(&handle);
        if matches!(values.inner(handle), TypeInner::Pointer { .. } | TypeInner::ValuePointer { .. }) {
            return Ok(());
        }
        let text = values.value(handle)?;
        let function = values.function;
        let named = function.named_expressions.contains_key(&handle) && !values.tables.contains_key(&handle);
        let count = values.info[handle].ref_count;
        // What a variable holds is read now: a store may follow before the value is used.
        let variable = match function.expressions[handle] {
            Expression::Load { pointer } => match *values.inner(pointer) {
                TypeInner::Pointer { space, .. } | TypeInner::ValuePointer { space, .. } => {
                    space == AddressSpace::Function
                }
                _ => true,
            },
            _ => false,
        };
        let cheap = text.bytes().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'.'));
        if named || (variable && count > 0) || (count > 1 && !cheap) || text.len() > LONGEST_INLINE {
            self.bind(handle, &text);
        } else {
            values.texts.insert(handle, text);
        }
        Ok(())
    }

    fn statement(&mut self, statement: &'a Statement) -> Result<(), Reason> {
        match statement {
            Statement::Emit(range) => range.clone().try_for_each(|handle| self.emit(handle)),
            Statement::Block(block) => {
                self.line("{");
                self.nested(block)?;
                self.line("}");
                Ok(())
            }
            Statement::If { condition, accept, reject } => {
                let condition = self.values.value(*condition)?;
                if accept.is_empty() {
                    self.line(format!("if !{condition} {{"));
                    self.nested(reject)?;
                } else {
                    self.line(format!("if {condition} {{"));
                    self.nested(accept)?;
                    if !reject.is_empty() {
                        self.line("} else {");
                        self.nested(reject)?;
                    }
                }
                self.line("}");
                Ok(())
            }
            Statement::Switch { selector, cases } => self.switch(*selector, cases),
            Statement::Loop { body, continuing, break_if } => {
                let label = self.label();
                self.line(format!("'l{label}: loop {{"));
                self.targets.push(Target::Loop { label, continuing, break_if: *break_if });
                self.depth += 1;
                self.block(body)?;
                if !ends(body) {
                    self.end_of_turn(label, continuing, *break_if)?;
                }
                self.depth -= 1;
                self.targets.pop();
                self.line("}");
                Ok(())
            }
            Statement::Break => {
                let label = match self.targets.last() {
                    Some(&(Target::Loop { label, .. } | Target::Switch { label })) => label,
                    None => return Err("a break outside of a loop".to_owned()),
                };
                self.line(format!("break 'l{label};"));
                Ok(())
            }
            Statement::Continue => {
                let innermost = self.targets.iter().rev().find(|target| matches!(target, Target::Loop { .. })).cloned();
                let Some(Target::Loop { label, continuing, break_if }) = innermost else {
                    return Err("a continue outside of a loop".to_owned());
                };
                // The end of a turn is repeated at each `continue`: it is an `i += 1` nearly always, and may use the
                // `let`s of the body.
                self.end_of_turn(label, continuing, break_if)?;
                self.line(format!("continue 'l{label};"));
                Ok(())
            }
            Statement::Return { value } => {
                match value {
                    Some(value) => {
                        let value = self.values.value(*value)?;
                        self.line(format!("return {value};"));
                    }
                    None => self.line("return;"),
                }
                Ok(())
            }
            Statement::Store { pointer, value } => {
                let value = self.values.value(*value)?;
                let target = self.values.target(*pointer)?;
                self.line(format!("{target} = {value};"));
                Ok(())
            }
            Statement::Call { function, arguments, result } => {
                let mut list = Vec::with_capacity(arguments.len());
                for &argument in arguments {
                    list.push(self.values.argument(argument)?);
                }
                let call = match self.values.items.functions.get(function) {
                    Some(Callee::Method(name)) => format!("self.{name}({})", list.join(", ")),
                    Some(Callee::Native(path)) => {
                        list.insert(0, "self".to_owned());
                        format!("{path}({})", list.join(", "))
                    }
                    None => return Err("a call of an unknown function".to_owned()),
                };
                match result {
                    Some(result) => self.bind(*result, &call),
                    None => self.line(format!("{call};")),
                }
                Ok(())
            }
            Statement::Kill => Err("`discard`".to_owned()),
            Statement::ControlBarrier(_) | Statement::MemoryBarrier(_) => Err("a barrier".to_owned()),
            Statement::WorkGroupUniformLoad { .. } => Err("`workgroupUniformLoad`".to_owned()),
            Statement::Atomic { .. } => Err("an atomic".to_owned()),
            Statement::ImageStore { .. } | Statement::ImageAtomic { .. } => Err("a texture".to_owned()),
            Statement::RayQuery { .. } | Statement::RayPipelineFunction(_) => Err("a ray query".to_owned()),
            Statement::SubgroupBallot { .. }
            | Statement::SubgroupGather { .. }
            | Statement::SubgroupCollectiveOperation { .. } => Err("a subgroup operation".to_owned()),
            Statement::CooperativeStore { .. } => Err("a cooperative matrix".to_owned()),
        }
    }

    fn end_of_turn(
        &mut self,
        label: usize,
        continuing: &'a Block,
        break_if: Option<Handle<Expression>>,
    ) -> Result<(), Reason> {
        self.block(continuing)?;
        if let Some(condition) = break_if {
            let condition = self.values.value(condition)?;
            self.line(format!("if {condition} {{ break 'l{label}; }}"));
        }
        Ok(())
    }

    fn switch(&mut self, selector: Handle<Expression>, cases: &'a [SwitchCase]) -> Result<(), Reason> {
        let selector = self.values.value(selector)?;
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
        let label = self.label();
        let labelled = cases.iter().any(|case| breaks(without_break(&case.body)));
        self.line(if labelled { format!("'l{label}: {{ match {selector} {{") } else { format!("match {selector} {{") });
        self.targets.push(Target::Switch { label });
        self.depth += 1;
        let arms = arms.into_iter().map(|(patterns, body)| (patterns.join(" | "), body));
        for (pattern, body) in arms.chain(default.map(|body| ("_".to_owned(), body))) {
            self.line(format!("{pattern} => {{"));
            self.depth += 1;
            without_break(body).iter().try_for_each(|statement| self.statement(statement))?;
            self.depth -= 1;
            self.line("}");
        }
        if default.is_none() {
            self.line("_ => {}");
        }
        self.depth -= 1;
        self.targets.pop();
        self.line(if labelled { "} }" } else { "}" });
        Ok(())
    }
}

/// The body of a case without the `break` at its end, which `match` does without.
fn without_break(body: &Block) -> &[Statement] {
    match body.split_last() {
        Some((Statement::Break, rest)) => rest,
        _ => body,
    }
}

/// Whether a `break` in these statements leaves the switch around them.
fn breaks(statements: &[Statement]) -> bool {
    statements.iter().any(|statement| match statement {
        Statement::Break => true,
        Statement::Block(block) => breaks(block),
        Statement::If { accept, reject, .. } => breaks(accept) || breaks(reject),
        _ => false,
    })
}

/// Whether control never reaches the end of the block.
fn ends(block: &Block) -> bool {
    match block.last() {
        Some(Statement::Break | Statement::Continue | Statement::Return { .. } | Statement::Kill) => true,
        Some(Statement::Block(inner)) => ends(inner),
        Some(Statement::If { accept, reject, .. }) => ends(accept) && ends(reject),
        _ => false,
    }
}
