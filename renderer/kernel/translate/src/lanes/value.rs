//! Expressions on lanes. What is uniform is written by [`crate::expression`] and spread where lanes are wanted.
//!
//! Every text returned is atomic, and cheap to repeat: a name, a field of one, or a constant spread.

use std::collections::HashMap;

use naga::{
    ArraySize, BinaryOperator, Expression, Handle, Literal, LocalVariable, MathFunction, RelationalFunction, Scalar,
    ScalarKind, Type, TypeInner, UnaryOperator, proc::TypeResolution,
};

use super::uniform::{Uniform, root_of};
use super::{count, gather, inner_type, lane_type, scalar_type, select, splat};
use crate::expression::Values;
use crate::names::plain;
use crate::types::Reason;

const PARTS: [&str; 4] = ["x", "y", "z", "w"];
/// The longest array that is searched for a lane's index.
const LONGEST_SEARCH: u32 = 64;
/// Numbers of a longer array than this are looked at one by one only where lanes ask for different ones.
const SHORT: u32 = 16;

/// What the expressions of one function are written with.
pub struct Lanes<'a> {
    /// Writes what is uniform.
    pub scalar: Values<'a>,
    pub uniform: Uniform,
    pub locals: HashMap<Handle<LocalVariable>, String>,
    /// The name of each varying expression that was emitted.
    pub texts: HashMap<Handle<Expression>, String>,
    /// Lines that must stand before the expression at hand.
    pub before: Vec<String>,
    /// The variable with the lanes that run what is written.
    pub mask: String,
    /// The rows that were chosen of a slice in the blocks that are open: slice, index, name.
    pub rows: Vec<(String, String, String)>,
}

/// One step from a variable into it.
enum Step {
    Fixed(String),
    /// The index, whether it is uniform, and the number of elements.
    Array(String, bool, u32),
    /// The same of a vector's parts or a matrix's columns.
    Vector(String, bool, u32),
}

impl<'a> Lanes<'a> {
    pub fn inner(&self, handle: Handle<Expression>) -> TypeInner {
        self.scalar.inner(handle).clone()
    }

    fn ty(&self, handle: Handle<Expression>) -> Option<Handle<Type>> {
        match self.scalar.info[handle].ty {
            TypeResolution::Handle(ty) => Some(ty),
            TypeResolution::Value(_) => None,
        }
    }

    pub fn varies(&self, handle: Handle<Expression>) -> bool {
        match self.scalar.function.expressions[handle] {
            Expression::FunctionArgument(_) => true,
            Expression::LocalVariable(local) => self.uniform.local_varies(local),
            _ => self.uniform.varies(handle),
        }
    }

    /// A name for `text` that stands before the expression at hand.
    fn bind(&mut self, text: &str) -> String {
        let name = self.scalar.names.unique("v");
        self.before.push(format!("let {name} = {text};"));
        name
    }

    /// The value in every lane.
    pub fn value(&mut self, handle: Handle<Expression>) -> Result<String, Reason> {
        if !self.varies(handle) {
            let text = self.scalar.value(handle)?;
            return match self.ty(handle) {
                Some(ty) => splat(self.scalar.module, ty, &text),
                None => Ok(format!("{}::splat({text})", inner_type(&self.inner(handle))?)),
            };
        }
        if let Some(text) = self.texts.get(&handle) {
            return Ok(text.clone());
        }
        if let Expression::FunctionArgument(index) = self.scalar.function.expressions[handle] {
            return self.scalar.arguments.get(index as usize).cloned().ok_or_else(|| "an argument".to_owned());
        }
        let text = self.compute(handle)?;
        Ok(self.bind(&text))
    }

    /// The parts of a vector, or a scalar for each of `n` parts.
    fn parts(&mut self, handle: Handle<Expression>, n: usize) -> Result<Vec<String>, Reason> {
        let inner = self.inner(handle);
        let varies = self.varies(handle);
        let text = if varies { self.value(handle)? } else { self.scalar.value(handle)? };
        let scalar = inner.scalar().ok_or("this type")?;
        let one = |text: String| match (varies, scalar_type(scalar)) {
            (true, _) => Ok(text),
            (false, Ok(ty)) => Ok(format!("{ty}::splat({text})")),
            (false, Err(reason)) => Err(reason),
        };
        match inner {
            TypeInner::Scalar(_) => Ok(vec![one(text)?; n]),
            TypeInner::Vector { size, .. } => {
                PARTS[..count(size)].iter().map(|part| one(format!("{text}.{part}"))).collect()
            }
            _ => Err("the parts of this type".to_owned()),
        }
    }

    /// A vector or scalar of these parts.
    fn whole(inner: &TypeInner, parts: &[String]) -> Result<String, Reason> {
        match *inner {
            TypeInner::Scalar(_) => parts.first().cloned().ok_or_else(|| "a vector with no parts".to_owned()),
            _ => {
                let fields: Vec<_> = PARTS.iter().zip(parts).map(|(part, text)| format!("{part}: {text}")).collect();
                Ok(format!("w::V{} {{ {} }}", parts.len(), fields.join(", ")))
            }
        }
    }

    fn width(inner: &TypeInner) -> usize {
        match inner {
            TypeInner::Vector { size, .. } => count(*size),
            _ => 1,
        }
    }

    fn kind(inner: &TypeInner) -> ScalarKind {
        inner.scalar_kind().unwrap_or(ScalarKind::Float)
    }

    /// The text of a varying expression.
    pub fn compute(&mut self, handle: Handle<Expression>) -> Result<String, Reason> {
        let function = self.scalar.function;
        let inner = self.inner(handle);
        let n = Self::width(&inner);
        match function.expressions[handle] {
            Expression::Compose { ty, ref components } => self.compose(ty, components),
            Expression::Splat { value, .. } => {
                let text = self.value(value)?;
                Self::whole(&inner, &vec![text; n])
            }
            Expression::Swizzle { size, vector, pattern } => {
                let width = Self::width(&self.inner(vector));
                let parts = self.parts(vector, width)?;
                let chosen: Vec<_> =
                    pattern[..count(size)].iter().filter_map(|&part| parts.get(part as usize).cloned()).collect();
                Self::whole(&inner, &chosen)
            }
            Expression::Access { base, index } => self.access(base, index),
            Expression::AccessIndex { base, index } => {
                let text = self.value(base)?;
                let base = self.inner(base);
                Ok(format!("{text}{}", fixed(&base, index)?))
            }
            Expression::Load { pointer } => self.load(pointer, handle),
            Expression::Unary { op, expr } => {
                let operator = match op {
                    UnaryOperator::Negate => "neg",
                    UnaryOperator::LogicalNot | UnaryOperator::BitwiseNot => "not",
                };
                let parts = self.parts(expr, n)?;
                let parts: Vec<_> = parts.iter().map(|part| format!("{part}.{operator}()")).collect();
                Self::whole(&inner, &parts)
            }
            Expression::Binary { op, left, right } => self.binary(op, left, right, &inner),
            Expression::Select { condition, accept, reject } => self.select(condition, accept, reject, handle),
            Expression::Relational { fun, argument } => {
                let width = Self::width(&self.inner(argument));
                let parts = self.parts(argument, width)?;
                let operator = match fun {
                    RelationalFunction::All => "and",
                    RelationalFunction::Any => "or",
                    RelationalFunction::IsNan | RelationalFunction::IsInf => return Err("`isnan`, `isinf`".to_owned()),
                };
                Ok(parts.into_iter().reduce(|a, b| format!("{a}.{operator}({b})")).unwrap_or_default())
            }
            Expression::Math { fun, arg, arg1, arg2, arg3 } => {
                let list: Vec<_> = [Some(arg), arg1, arg2, arg3].into_iter().flatten().collect();
                self.math(fun, &list, &inner)
            }
            Expression::As { expr, kind, convert } => {
                let from = Self::kind(&self.inner(expr));
                let operator = match (kind, convert.is_some() || from == ScalarKind::Bool) {
                    (ScalarKind::Float, true) => "to_float",
                    (ScalarKind::Sint, true) => "to_int",
                    (ScalarKind::Uint, true) => "to_uint",
                    (ScalarKind::Bool, _) => "to_bool",
                    (ScalarKind::Float, false) => "bits_float",
                    (ScalarKind::Sint, false) if from == ScalarKind::Float => "bits_int",
                    (ScalarKind::Sint, false) => "to_int",
                    (ScalarKind::Uint, false) if from == ScalarKind::Float => "bits_uint",
                    (ScalarKind::Uint, false) => "to_uint",
                    _ => return Err("this conversion".to_owned()),
                };
                if from == kind {
                    return self.value(expr);
                }
                let parts: Vec<_> =
                    self.parts(expr, n)?.into_iter().map(|part| format!("{part}.{operator}()")).collect();
                Self::whole(&inner, &parts)
            }
            Expression::CallResult(_) => Err("the result of a call that was not made".to_owned()),
            _ => Err("this expression".to_owned()),
        }
    }

    fn compose(&mut self, ty: Handle<Type>, components: &[Handle<Expression>]) -> Result<String, Reason> {
        let module = self.scalar.module;
        match module.types[ty].inner {
            TypeInner::Struct { ref members, .. } => {
                let mut fields = Vec::new();
                for (member, &component) in members.iter().zip(components) {
                    let field = plain(member.name.as_deref().unwrap_or_default());
                    fields.push(format!("{field}: {}", self.value(component)?));
                }
                Ok(format!("{} {{ {} }}", lane_type(module, ty)?, fields.join(", ")))
            }
            TypeInner::Array { .. } => {
                let parts: Result<Vec<_>, _> = components.iter().map(|&part| self.value(part)).collect();
                Ok(format!("[{}]", parts?.join(", ")))
            }
            ref inner @ TypeInner::Matrix { .. } => {
                let parts: Result<Vec<_>, _> = components.iter().map(|&part| self.value(part)).collect();
                Self::whole(inner, &parts?)
            }
            ref inner => {
                if let Some((slice, index)) = self.neighbours(components)? {
                    return Ok(format!("w::fours({}, {slice}, {index}.bits_uint())", self.mask));
                }
                let mut parts = Vec::new();
                for &component in components {
                    let width = Self::width(&self.inner(component));
                    parts.extend(self.parts(component, width)?);
                }
                Self::whole(inner, &parts)
            }
        }
    }

    /// The slice and the first index, where four components are neighbours in a slice of whole numbers: `v[i]`, `v[i + 1]` and
    /// so on. Lanes read each such row at once.
    fn neighbours(&mut self, components: &[Handle<Expression>]) -> Result<Option<(String, String)>, Reason> {
        let (function, module) = (self.scalar.function, self.scalar.module);
        let place = |component: Handle<Expression>| {
            let Expression::Load { pointer } = function.expressions[component] else { return None };
            let Expression::Access { base, index } = function.expressions[pointer] else { return None };
            let Expression::GlobalVariable(global) = function.expressions[base] else { return None };
            let TypeInner::Array { base, size: ArraySize::Dynamic, .. } =
                module.types[module.global_variables[global].ty].inner
            else {
                return None;
            };
            (module.types[base].inner == TypeInner::Scalar(Scalar::U32)).then_some((global, index))
        };
        let &[first, ref rest @ ..] = components else { return Ok(None) };
        let Some((slice, first)) = place(first) else { return Ok(None) };
        let follows = |(i, &component): (u32, &Handle<Expression>)| {
            place(component).is_some_and(|(global, index)| match function.expressions[index] {
                Expression::Binary { op: BinaryOperator::Add, left, right } => {
                    let step = Expression::Literal(Literal::U32(i));
                    global == slice && left == first && function.expressions[right] == step
                }
                _ => false,
            })
        };
        if rest.len() != 3 || !self.varies(first) || !(1..).zip(rest).all(follows) {
            return Ok(None);
        }
        let name = self.scalar.items.globals.get(&slice).ok_or("a binding that is not there")?;
        let index = self.value(first)?;
        Ok(Some((format!("self.0.{name}"), index)))
    }

    /// `accept` where the index is `i` for each element but the last, which is also read past the end.
    fn search(
        &mut self,
        elements: &[String],
        index: &str,
        inner: &TypeInner,
        ty: Option<Handle<Type>>,
    ) -> Result<String, Reason> {
        let index = self.bind(&format!("{index}.bits_uint()"));
        let Some((last, rest)) = elements.split_last() else { return Err("an array with no elements".to_owned()) };
        let mut text = last.clone();
        for (i, element) in rest.iter().enumerate() {
            let mask = format!("{index}.eq(w::U::splat({i}u32))");
            let chosen = match ty {
                Some(ty) if matches!(inner, TypeInner::Array { .. }) => {
                    select(self.scalar.module, ty, &mask, element, &text)?
                }
                Some(ty) => format!("{}::select({mask}, {element}, {text})", lane_type(self.scalar.module, ty)?),
                None => format!("{}::select({mask}, {element}, {text})", inner_type(inner)?),
            };
            text = self.bind(&chosen);
        }
        Ok(text)
    }

    /// An index of a value that lies in no variable.
    fn access(&mut self, base: Handle<Expression>, index: Handle<Expression>) -> Result<String, Reason> {
        let inner = self.inner(base);
        let index_varies = self.varies(index);
        match inner {
            TypeInner::Array { base: element, size: ArraySize::Constant(n), .. } => {
                if !self.varies(base) {
                    let (text, index) = (self.scalar.value(base)?, self.value(index)?);
                    let index = self.bind(&format!("{index}.bits_uint().to_array()"));
                    let place = format!("{text}[wgsl::index({index}[k] as usize, {n})]");
                    return gather(self.scalar.module, element, &place);
                }
                let text = self.value(base)?;
                if !index_varies {
                    let index = self.scalar.value(index)?;
                    return Ok(format!("{text}[wgsl::index({index} as usize, {n})]"));
                }
                let index = self.value(index)?;
                let element_inner = self.scalar.module.types[element].inner.clone();
                self.search(&elements(&text, n.get())?, &index, &element_inner, Some(element))
            }
            TypeInner::Vector { scalar, .. } => {
                let parts = self.parts(base, Self::width(&inner))?;
                let index = self.value(index)?;
                self.search(&parts, &index, &TypeInner::Scalar(scalar), None)
            }
            TypeInner::Matrix { columns, rows, scalar } => {
                let (text, index) = (self.value(base)?, self.value(index)?);
                let parts: Vec<_> = PARTS[..count(columns)].iter().map(|part| format!("{text}.{part}")).collect();
                self.search(&parts, &index, &TypeInner::Vector { size: rows, scalar }, None)
            }
            _ => Err("an index into this type".to_owned()),
        }
    }

    fn load(&mut self, pointer: Handle<Expression>, handle: Handle<Expression>) -> Result<String, Reason> {
        let function = self.scalar.function;
        let mut root = pointer;
        while let Expression::Access { base, .. } | Expression::AccessIndex { base, .. } = function.expressions[root] {
            root = base;
        }
        let uniform_local = matches!(function.expressions[root], Expression::LocalVariable(local)
            if !self.uniform.local_varies(local));
        if uniform_local || matches!(function.expressions[root], Expression::GlobalVariable(_)) {
            let place = self.scalar_place(pointer)?;
            return match self.ty(handle) {
                Some(ty) => gather(self.scalar.module, ty, &place),
                None => Ok(format!("{}::gather(|k| {place})", inner_type(&self.inner(handle))?)),
            };
        }
        let (text, steps) = self.steps(pointer)?;
        self.read(text, &steps, &self.inner(handle), self.ty(handle))
    }

    /// A place in memory that all lanes share, for lane `k`.
    fn scalar_place(&mut self, pointer: Handle<Expression>) -> Result<String, Reason> {
        match self.scalar.function.expressions[pointer] {
            Expression::GlobalVariable(global) => {
                let name = self.scalar.items.globals.get(&global).ok_or("a binding that is not there")?;
                Ok(format!("self.0.{name}"))
            }
            Expression::LocalVariable(local) => {
                self.locals.get(&local).cloned().ok_or_else(|| "a variable that is not declared".to_owned())
            }
            Expression::AccessIndex { base, index } => {
                let inner = self.pointee(base);
                let text = self.scalar_place(base)?;
                match inner {
                    TypeInner::Array { size: ArraySize::Dynamic, .. } => {
                        Ok(format!("{text}[wgsl::index({index}, {text}.len())]"))
                    }
                    TypeInner::Matrix { .. } => {
                        let column = ["x_axis", "y_axis", "z_axis", "w_axis"].get(index as usize).ok_or("a column")?;
                        Ok(format!("{text}.{column}"))
                    }
                    _ => Ok(format!("{text}{}", fixed(&inner, index)?)),
                }
            }
            Expression::Access { base, index } => {
                let inner = self.pointee(base);
                let text = self.scalar_place(base)?;
                if !self.varies(index) {
                    let index = self.scalar.value(index)?;
                    return match inner {
                        TypeInner::Array { size: ArraySize::Dynamic, .. } => {
                            Ok(format!("{text}[wgsl::index({index} as usize, {text}.len())]"))
                        }
                        TypeInner::Array { size: ArraySize::Constant(n), .. } => {
                            Ok(format!("{text}[wgsl::index({index} as usize, {n})]"))
                        }
                        _ => Ok(format!("wgsl::{}::at({text}, {index} as usize)", crate::types::lane_module(&inner)?)),
                    };
                }
                let index = format!("{}.bits_uint()", self.value(index)?);
                match inner {
                    TypeInner::Array { size: ArraySize::Dynamic, .. } if !text.contains('[') && !text.contains('(') => {
                        let known = self.rows.iter().find(|(slice, by, _)| *slice == text && *by == index);
                        if let Some((_, _, name)) = known {
                            return Ok(format!("(*{name}.at(k))"));
                        }
                        let name = self.bind(&format!("w::Rows::new({text}, {index})"));
                        self.rows.push((text, index, name.clone()));
                        Ok(format!("(*{name}.at(k))"))
                    }
                    TypeInner::Array { size, .. } => {
                        let n = match size {
                            ArraySize::Constant(n) => n.to_string(),
                            _ => format!("{text}.len()"),
                        };
                        let index = self.bind(&format!("{index}.to_array()"));
                        Ok(format!("{text}[wgsl::index({index}[k] as usize, {n})]"))
                    }
                    _ => {
                        let index = self.bind(&format!("{index}.to_array()"));
                        let module = crate::types::lane_module(&inner)?;
                        Ok(format!("wgsl::{module}::at({text}, {index}[k] as usize)"))
                    }
                }
            }
            _ => Err("a pointer of this kind".to_owned()),
        }
    }

    fn pointee(&self, handle: Handle<Expression>) -> TypeInner {
        match *self.scalar.inner(handle) {
            TypeInner::Pointer { base, .. } => self.scalar.module.types[base].inner.clone(),
            TypeInner::ValuePointer { size: Some(size), scalar, .. } => TypeInner::Vector { size, scalar },
            TypeInner::ValuePointer { size: None, scalar, .. } => TypeInner::Scalar(scalar),
            ref value => value.clone(),
        }
    }

    /// The variable that a pointer leads into, and the way.
    fn steps(&mut self, pointer: Handle<Expression>) -> Result<(String, Vec<Step>), Reason> {
        match self.scalar.function.expressions[pointer] {
            Expression::LocalVariable(local) => {
                let name = self.locals.get(&local).cloned().ok_or("a variable that is not declared")?;
                Ok((name, Vec::new()))
            }
            Expression::FunctionArgument(index) => {
                let name = self.scalar.arguments.get(index as usize).ok_or("an argument that is not declared")?;
                Ok((format!("(*{name})"), Vec::new()))
            }
            Expression::AccessIndex { base, index } => {
                let (text, mut steps) = self.steps(base)?;
                steps.push(Step::Fixed(fixed(&self.pointee(base), index)?));
                Ok((text, steps))
            }
            Expression::Access { base, index } => {
                let (text, mut steps) = self.steps(base)?;
                let uniform = !self.varies(index);
                let index = if uniform { self.scalar.value(index)? } else { self.value(index)? };
                steps.push(match self.pointee(base) {
                    TypeInner::Array { size: ArraySize::Constant(n), .. } => Step::Array(index, uniform, n.get()),
                    TypeInner::Vector { size, .. } => Step::Vector(index, uniform, size as u32),
                    TypeInner::Matrix { columns, .. } => Step::Vector(index, uniform, columns as u32),
                    _ => return Err("an index into this type".to_owned()),
                });
                Ok((text, steps))
            }
            _ => Err("a pointer of this kind".to_owned()),
        }
    }

    fn read(
        &mut self,
        text: String,
        steps: &[Step],
        inner: &TypeInner,
        ty: Option<Handle<Type>>,
    ) -> Result<String, Reason> {
        let Some((step, rest)) = steps.split_first() else { return Ok(text) };
        let ways: Vec<(String, String)> = match step {
            Step::Fixed(part) => return self.read(format!("{text}{part}"), rest, inner, ty),
            Step::Array(index, true, n) => {
                let text = format!("{text}[wgsl::index({index} as usize, {n})]");
                return self.read(text, rest, inner, ty);
            }
            Step::Array(index, false, n) if is_long(*n, rest, inner) => {
                return Ok(self.bind(&format!("w::pick(&{text}, {index}.bits_uint(), {})", self.mask)));
            }
            Step::Array(index, false, n) => {
                elements(&text, *n)?.into_iter().map(|element| (element, index.clone())).collect()
            }
            Step::Vector(index, uniform, n) => {
                let index = if *uniform { format!("w::U::splat({index} as u32)") } else { index.clone() };
                PARTS[..*n as usize].iter().map(|part| (format!("{text}.{part}"), index.clone())).collect()
            }
        };
        let mut values = Vec::new();
        let mut by = String::new();
        for (way, index) in ways {
            values.push(self.read(way, rest, inner, ty)?);
            by = index;
        }
        self.search(&values, &by, inner, ty)
    }

    /// The lines that store `value` where `pointer` leads, in the lanes of `mask` or in all.
    pub fn store(
        &mut self,
        pointer: Handle<Expression>,
        value: &str,
        mask: Option<&str>,
    ) -> Result<Vec<String>, Reason> {
        let inner = self.pointee(pointer);
        let ty = match *self.scalar.inner(pointer) {
            TypeInner::Pointer { base, .. } => Some(base),
            _ => None,
        };
        let (text, steps) = self.steps(pointer)?;
        let mut lines = Vec::new();
        self.write(&text, &steps, value, mask.map(str::to_owned), &inner, ty, &mut lines)?;
        Ok(lines)
    }

    #[allow(clippy::too_many_arguments)]
    fn write(
        &mut self,
        text: &str,
        steps: &[Step],
        value: &str,
        mask: Option<String>,
        inner: &TypeInner,
        ty: Option<Handle<Type>>,
        lines: &mut Vec<String>,
    ) -> Result<(), Reason> {
        let Some((step, rest)) = steps.split_first() else {
            let value = match (mask, ty) {
                (None, _) => value.to_owned(),
                (Some(mask), Some(ty)) => select(self.scalar.module, ty, &mask, value, text)?,
                (Some(mask), None) => format!("{}::select({mask}, {value}, {text})", inner_type(inner)?),
            };
            lines.push(format!("{text} = {value};"));
            return Ok(());
        };
        let (ways, index): (Vec<String>, String) = match step {
            Step::Fixed(part) => return self.write(&format!("{text}{part}"), rest, value, mask, inner, ty, lines),
            Step::Array(index, true, n) => {
                let text = format!("{text}[wgsl::index({index} as usize, {n})]");
                return self.write(&text, rest, value, mask, inner, ty, lines);
            }
            Step::Array(index, false, n) if is_long(*n, rest, inner) => {
                let mask = mask.unwrap_or_else(|| self.mask.clone());
                lines.push(format!("w::put(&mut {text}, {index}.bits_uint(), {mask}, {value});"));
                return Ok(());
            }
            Step::Array(index, false, n) => (elements(text, *n)?, format!("{index}.bits_uint()")),
            Step::Vector(index, uniform, n) => {
                let index =
                    if *uniform { format!("w::U::splat({index} as u32)") } else { format!("{index}.bits_uint()") };
                (PARTS[..*n as usize].iter().map(|part| format!("{text}.{part}")).collect(), index)
            }
        };
        let last = ways.len().saturating_sub(1);
        let index = self.bind(&format!("{index}.min(w::U::splat({last}u32))"));
        for (i, way) in ways.iter().enumerate() {
            let here = format!("{index}.eq(w::U::splat({i}u32))");
            let here = match &mask {
                Some(mask) => format!("{mask}.and({here})"),
                None => here,
            };
            self.write(way, rest, value, Some(here), inner, ty, lines)?;
        }
        Ok(())
    }

    /// A pointer as an argument of a call.
    pub fn lent(&mut self, pointer: Handle<Expression>) -> Result<String, Reason> {
        match self.scalar.function.expressions[pointer] {
            Expression::LocalVariable(local) if self.uniform.local_varies(local) => {
                let name = self.locals.get(&local).ok_or("a variable that is not declared")?;
                Ok(format!("&mut {name}"))
            }
            Expression::FunctionArgument(index) => {
                let name = self.scalar.arguments.get(index as usize).ok_or("an argument that is not declared")?;
                Ok(format!("&mut *{name}"))
            }
            _ => Err("a pointer of this kind as an argument".to_owned()),
        }
    }

    fn binary(
        &mut self,
        op: BinaryOperator,
        left: Handle<Expression>,
        right: Handle<Expression>,
        result: &TypeInner,
    ) -> Result<String, Reason> {
        use BinaryOperator as Op;
        let (l, r) = (self.inner(left), self.inner(right));
        let matrix = |inner: &TypeInner| matches!(inner, TypeInner::Matrix { .. });
        if matrix(&l) || matrix(&r) {
            let (a, b) = (self.value(left)?, self.value(right)?);
            return Ok(match (op, matrix(&l), matrix(&r)) {
                (Op::Add, ..) => format!("{a}.add({b})"),
                (Op::Subtract, ..) => format!("{a}.sub({b})"),
                (Op::Multiply, true, true) => format!("{a}.mul({b})"),
                (Op::Multiply, true, _) if matches!(r, TypeInner::Scalar(_)) => format!("{a}.scale({b})"),
                (Op::Multiply, ..) if matches!(l, TypeInner::Scalar(_)) => format!("{b}.scale({a})"),
                (Op::Multiply, true, _) => format!("{a}.mul_vector({b})"),
                (Op::Multiply, ..) => format!("{b}.vector_mul({a})"),
                _ => return Err("this operator on a matrix".to_owned()),
            });
        }
        let n = Self::width(&l).max(Self::width(&r));
        let kind = Self::kind(&l);
        let power = self.power_of_two(right).filter(|_| kind == ScalarKind::Uint);
        let (a, b) = (self.parts(left, n)?, self.parts(right, n)?);
        let operator = match (op, power) {
            (Op::Divide, Some(power)) => {
                let parts: Vec<_> = a.iter().map(|a| format!("{a}.shr(w::U::splat({power}u32))")).collect();
                return Self::whole(result, &parts);
            }
            (Op::Modulo, Some(power)) => {
                let mask = (1u32 << power).wrapping_sub(1);
                let parts: Vec<_> = a.iter().map(|a| format!("{a}.and(w::U::splat({mask}u32))")).collect();
                return Self::whole(result, &parts);
            }
            (Op::Add, _) => "add",
            (Op::Subtract, _) => "sub",
            (Op::Multiply, _) => "mul",
            (Op::Divide, _) => "div",
            (Op::Modulo, _) => "rem",
            (Op::Equal, _) => "eq",
            (Op::NotEqual, _) => "ne",
            (Op::Less, _) => "lt",
            (Op::LessEqual, _) => "le",
            (Op::Greater, _) => "gt",
            (Op::GreaterEqual, _) => "ge",
            (Op::And | Op::LogicalAnd, _) => "and",
            (Op::InclusiveOr | Op::LogicalOr, _) => "or",
            (Op::ExclusiveOr, _) => "xor",
            (Op::ShiftLeft, _) => "shl",
            (Op::ShiftRight, _) => "shr",
        };
        let parts: Vec<_> = a.iter().zip(&b).map(|(a, b)| format!("{a}.{operator}({b})")).collect();
        Self::whole(result, &parts)
    }

    /// The exponent of a literal power of two.
    fn power_of_two(&self, handle: Handle<Expression>) -> Option<u32> {
        match self.scalar.function.expressions[handle] {
            Expression::Literal(naga::Literal::U32(value)) if value.is_power_of_two() => Some(value.trailing_zeros()),
            _ => None,
        }
    }

    fn select(
        &mut self,
        condition: Handle<Expression>,
        accept: Handle<Expression>,
        reject: Handle<Expression>,
        handle: Handle<Expression>,
    ) -> Result<String, Reason> {
        let inner = self.inner(handle);
        let n = Self::width(&inner);
        let scalar = inner.scalar().ok_or("a selection of this type")?;
        let (a, r) = (self.parts(accept, n)?, self.parts(reject, n)?);
        let ty = scalar_type(scalar)?;
        let parts: Vec<_> = if self.varies(condition) {
            let c = self.parts(condition, n)?;
            (0..n).map(|i| format!("{ty}::select({}, {}, {})", c[i], a[i], r[i])).collect()
        } else {
            let c = self.scalar.value(condition)?;
            let width = Self::width(&self.inner(condition));
            (0..n)
                .map(|i| {
                    let c = if width == 1 { c.clone() } else { format!("{c}.{}", PARTS[i]) };
                    format!("(if {c} {{ {} }} else {{ {} }})", a[i], r[i])
                })
                .collect()
        };
        Self::whole(&inner, &parts)
    }

    fn math(&mut self, fun: MathFunction, list: &[Handle<Expression>], inner: &TypeInner) -> Result<String, Reason> {
        use MathFunction as F;
        let (name, parted) = match fun {
            F::Abs => ("abs", true),
            F::Min => ("min", true),
            F::Max => ("max", true),
            F::Clamp => ("clamp", true),
            F::Saturate => ("saturate", true),
            F::Radians => ("radians", true),
            F::Degrees => ("degrees", true),
            F::Ceil => ("ceil", true),
            F::Floor => ("floor", true),
            F::Round => ("round", true),
            F::Fract => ("fract", true),
            F::Trunc => ("trunc", true),
            F::Sign => ("sign", true),
            F::Fma => ("fma", true),
            F::Mix => ("mix", true),
            F::Step => ("step", true),
            F::SmoothStep => ("smoothstep", true),
            F::Sqrt => ("sqrt", true),
            F::InverseSqrt => ("inverse_sqrt", true),
            F::QuantizeToF16 => ("quantize_to_f16", true),
            F::CountTrailingZeros => ("count_trailing_zeros", true),
            F::CountLeadingZeros => ("count_leading_zeros", true),
            F::CountOneBits => ("count_one_bits", true),
            F::ReverseBits => ("reverse_bits", true),
            F::ExtractBits => ("extract_bits", true),
            F::InsertBits => ("insert_bits", true),
            F::FirstTrailingBit => ("first_trailing_bit", true),
            F::FirstLeadingBit => ("first_leading_bit", true),
            F::Dot => ("dot", false),
            F::Distance => ("distance", false),
            F::Length => ("length", false),
            F::Normalize => ("normalize", false),
            F::FaceForward => ("face_forward", false),
            F::Reflect => ("reflect", false),
            F::Refract => ("refract", false),
            F::Cross => ("cross", false),
            F::Transpose => ("transpose", false),
            F::Determinant => ("determinant", false),
            F::Pack4x8snorm => ("w::pack_4x8_snorm", false),
            F::Pack4x8unorm => ("w::pack_4x8_unorm", false),
            F::Pack2x16snorm => ("w::pack_2x16_snorm", false),
            F::Pack2x16unorm => ("w::pack_2x16_unorm", false),
            F::Pack2x16float => ("w::pack_2x16_float", false),
            F::Unpack4x8snorm => ("w::unpack_4x8_snorm", false),
            F::Unpack4x8unorm => ("w::unpack_4x8_unorm", false),
            F::Unpack2x16snorm => ("w::unpack_2x16_snorm", false),
            F::Unpack2x16unorm => ("w::unpack_2x16_unorm", false),
            F::Unpack2x16float => ("w::unpack_2x16_float", false),
            // All else is refused by the scalar translation too.
            _ => return Err(format!("`{fun:?}`")),
        };
        if !parted {
            let values: Result<Vec<_>, _> = list.iter().map(|&part| self.value(part)).collect();
            let values = values?;
            let Some((first, rest)) = values.split_first() else { return Err(format!("`{fun:?}`")) };
            return Ok(match name.starts_with("w::") {
                true => format!("{name}({first})"),
                false => format!("{first}.{name}({})", rest.join(", ")),
            });
        }
        let n = Self::width(inner);
        let mut rows = Vec::new();
        for &part in list {
            rows.push(self.parts(part, n)?);
        }
        let Some((first, rest)) = rows.split_first() else { return Err(format!("`{fun:?}`")) };
        let parts: Vec<_> = (0..n)
            .map(|i| {
                let others: Vec<_> = rest.iter().map(|row| row[i].as_str()).collect();
                format!("{}.{name}({})", first[i], others.join(", "))
            })
            .collect();
        Self::whole(inner, &parts)
    }

    /// Whether the variable at the root of the pointer is uniform.
    pub fn stores_scalar(&self, pointer: Handle<Expression>) -> bool {
        root_of(self.scalar.function, pointer).is_some_and(|local| !self.uniform.local_varies(local))
    }

    /// The value of all bits zero on lanes.
    pub fn zero(&self, ty: Handle<Type>) -> Result<String, Reason> {
        splat(self.scalar.module, ty, &crate::expression::zero(self.scalar.module, ty)?)
    }

    /// Whether the expression is a bool that costs nothing to compute where no lane asks for it.
    pub fn is_cheap(&self, handle: Handle<Expression>) -> bool {
        let cheap = |inner: &TypeInner| {
            matches!(inner, TypeInner::Scalar(Scalar { .. }) | TypeInner::Vector { .. } | TypeInner::Pointer { .. })
        };
        match self.scalar.function.expressions[handle] {
            Expression::Load { pointer } => {
                let mut root = pointer;
                while let Expression::Access { base, .. } | Expression::AccessIndex { base, .. } =
                    self.scalar.function.expressions[root]
                {
                    if matches!(self.scalar.function.expressions[root], Expression::Access { .. }) {
                        return false;
                    }
                    root = base;
                }
                cheap(self.scalar.inner(handle))
                    && !matches!(self.scalar.function.expressions[root], Expression::GlobalVariable(_))
            }
            Expression::Binary { op: BinaryOperator::Divide | BinaryOperator::Modulo, .. } => false,
            Expression::Access { .. } => false,
            Expression::Math { fun, .. } => matches!(
                fun,
                MathFunction::Abs
                    | MathFunction::Min
                    | MathFunction::Max
                    | MathFunction::Clamp
                    | MathFunction::Saturate
                    | MathFunction::Floor
                    | MathFunction::Dot
                    | MathFunction::Mix
            ),
            Expression::CallResult(_) => false,
            _ => true,
        }
    }
}

/// A member, element, part or column by a number known here.
fn fixed(inner: &TypeInner, index: u32) -> Result<String, Reason> {
    match inner {
        TypeInner::Struct { members, .. } => {
            let member = members.get(index as usize).ok_or("a member that is not declared")?;
            Ok(format!(".{}", plain(member.name.as_deref().unwrap_or_default())))
        }
        TypeInner::Array { .. } => Ok(format!("[{index}]")),
        TypeInner::Vector { .. } | TypeInner::Matrix { .. } => {
            Ok(format!(".{}", PARTS.get(index as usize).ok_or("a part past the fourth")?))
        }
        _ => Err("an index into this type".to_owned()),
    }
}

/// Whether the step leads to a number of a long array.
fn is_long(n: u32, rest: &[Step], inner: &TypeInner) -> bool {
    n > SHORT && n <= LONGEST_SEARCH && rest.is_empty() && matches!(inner, TypeInner::Scalar(Scalar::F32))
}

fn elements(text: &str, n: u32) -> Result<Vec<String>, Reason> {
    if n > LONGEST_SEARCH {
        return Err(format!("an array of {n} elements with an index that differs between lanes"));
    }
    Ok((0..n).map(|i| format!("{text}[{i}]")).collect())
}
