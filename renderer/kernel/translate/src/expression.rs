//! Expressions as Rust source, one lane at a time. [`crate::lanes`] writes those that differ between lanes, and leaves the
//! others to this module.
//!
//! Every text returned is atomic: it can stand before `.x`, `[i]` or ` as usize` without more parentheses.

use std::collections::HashMap;

use naga::{
    AddressSpace, Arena, ArraySize, BinaryOperator, Expression, Handle, Literal, LocalVariable, MathFunction, Module,
    RelationalFunction, ScalarKind, SwizzleComponent, Type, TypeInner, UnaryOperator, valid::FunctionInfo,
};

use crate::items::Items;
use crate::names::{Names, plain};
use crate::types::{Reason, glam_type, lane_module, rust_type, space_name, struct_name};

const LANES: [&str; 4] = ["x", "y", "z", "w"];
const COLUMNS: [&str; 4] = ["x_axis", "y_axis", "z_axis", "w_axis"];

/// What the expressions of one function are written with.
pub struct Values<'a> {
    pub module: &'a Module,
    pub items: &'a Items,
    pub info: &'a FunctionInfo,
    pub function: &'a naga::Function,
    pub names: Names,
    pub arguments: Vec<String>,
    pub locals: HashMap<Handle<LocalVariable>, String>,
    /// The text of each expression that was emitted: the name of its `let`, or the expression itself.
    pub texts: HashMap<Handle<Expression>, String>,
    /// The constant arrays of the function, each a `static` that is indexed in place, and their names.
    pub tables: HashMap<Handle<Expression>, String>,
    pub statics: Vec<String>,
}

/// Something that can be read or written.
struct Place {
    text: String,
    /// `text` is a reference, to be read or written through `*`.
    reference: bool,
}

impl Place {
    fn whole(self) -> String {
        if self.reference { format!("(*{})", self.text) } else { self.text }
    }
}

enum Index {
    Fixed(u32),
    Dynamic(String),
}

impl Values<'_> {
    pub fn inner(&self, handle: Handle<Expression>) -> &TypeInner {
        self.info[handle].ty.inner_with(&self.module.types)
    }

    /// The type behind a pointer, or the type of a value.
    fn pointee(&self, handle: Handle<Expression>) -> TypeInner {
        match *self.inner(handle) {
            TypeInner::Pointer { base, .. } => self.module.types[base].inner.clone(),
            TypeInner::ValuePointer { size: Some(size), scalar, .. } => TypeInner::Vector { size, scalar },
            TypeInner::ValuePointer { size: None, scalar, .. } => TypeInner::Scalar(scalar),
            ref value => value.clone(),
        }
    }

    /// The expression as an argument of a call: a pointer is lent.
    pub fn argument(&mut self, handle: Handle<Expression>) -> Result<String, Reason> {
        let part =
            matches!(self.function.expressions[handle], Expression::Access { .. } | Expression::AccessIndex { .. });
        match *self.inner(handle) {
            // WGSL leaves it to an extension, and naga's own SPIR-V writer panics on it.
            TypeInner::Pointer { .. } | TypeInner::ValuePointer { .. } if part => {
                Err("a pointer to a part of a variable, as an argument".to_owned())
            }
            TypeInner::Pointer { space: AddressSpace::Function, .. } => {
                let place = self.place(handle, true)?;
                Ok(if place.reference { place.text } else { format!("&mut {}", place.text) })
            }
            TypeInner::Pointer { space, .. } => Err(format!("a pointer to {} as an argument", space_name(space))),
            _ => self.value(handle),
        }
    }

    /// What stands to the left of `=`.
    pub fn target(&mut self, pointer: Handle<Expression>) -> Result<String, Reason> {
        let place = self.place(pointer, true)?;
        Ok(if place.reference { format!("*{}", place.text) } else { place.text })
    }

    fn place(&mut self, handle: Handle<Expression>, write: bool) -> Result<Place, Reason> {
        match self.function.expressions[handle] {
            Expression::LocalVariable(local) => {
                let text = self.locals.get(&local).cloned().ok_or("a variable that is not declared")?;
                Ok(Place { text, reference: false })
            }
            Expression::FunctionArgument(index) => {
                let text = self.arguments.get(index as usize).cloned().ok_or("an argument that is not declared")?;
                Ok(Place { text, reference: true })
            }
            Expression::GlobalVariable(global) => {
                let space = self.module.global_variables[global].space;
                if write {
                    return Err(format!("a write to {}", space_name(space)));
                }
                let name = self.items.globals.get(&global).ok_or_else(|| space_name(space).to_owned())?;
                Ok(Place { text: format!("self.{name}"), reference: true })
            }
            Expression::Access { base, index } => {
                let index = Index::Dynamic(self.value(index)?);
                let inner = self.pointee(base);
                let base = self.place(base, write)?;
                self.part(base, &inner, index, write)
            }
            Expression::AccessIndex { base, index } => {
                let inner = self.pointee(base);
                let place = self.place(base, write)?;
                let place = self.part(place, &inner, Index::Fixed(index), write)?;
                self.member(place, base, index)
            }
            _ => Err("a pointer of this kind".to_owned()),
        }
    }

    /// An element, lane or column. A struct is left to [`Self::member`].
    fn part(&self, base: Place, inner: &TypeInner, index: Index, write: bool) -> Result<Place, Reason> {
        let text = match (inner, index) {
            (TypeInner::Struct { .. }, _) => return Ok(base),
            (TypeInner::Array { size: ArraySize::Constant(_), .. }, Index::Fixed(i)) => format!("{}[{i}]", base.text),
            (TypeInner::Array { size: ArraySize::Constant(count), .. }, Index::Dynamic(i)) => {
                format!("{}[wgsl::index({i} as usize, {count})]", base.text)
            }
            (TypeInner::Array { size: ArraySize::Dynamic, .. }, index) => {
                let i = match index {
                    Index::Fixed(i) => i.to_string(),
                    Index::Dynamic(i) => format!("{i} as usize"),
                };
                format!("{0}[wgsl::index({i}, {0}.len())]", base.text)
            }
            (TypeInner::Vector { .. }, Index::Fixed(i)) => {
                format!("{}.{}", base.text, LANES.get(i as usize).ok_or("a lane past the fourth")?)
            }
            (TypeInner::Matrix { .. }, Index::Fixed(i)) => {
                format!("{}.{}", base.text, COLUMNS.get(i as usize).ok_or("a column past the fourth")?)
            }
            (TypeInner::Vector { .. } | TypeInner::Matrix { .. }, Index::Dynamic(i)) => {
                let module = lane_module(inner)?;
                if write {
                    let text = format!("wgsl::{module}::at_mut(&mut {}, {i} as usize)", base.whole());
                    return Ok(Place { text, reference: true });
                }
                format!("wgsl::{module}::at({}, {i} as usize)", base.whole())
            }
            _ => return Err("an index into this type".to_owned()),
        };
        Ok(Place { text, reference: false })
    }

    fn member(&self, place: Place, base: Handle<Expression>, index: u32) -> Result<Place, Reason> {
        let TypeInner::Struct { ref members, .. } = self.pointee(base) else { return Ok(place) };
        let member = members.get(index as usize).ok_or("a member that is not declared")?;
        let name = plain(member.name.as_deref().unwrap_or_default());
        Ok(Place { text: format!("{}.{name}", place.text), reference: false })
    }

    /// The expression as a value.
    pub fn value(&mut self, handle: Handle<Expression>) -> Result<String, Reason> {
        if let Some(text) = self.texts.get(&handle) {
            return Ok(text.clone());
        }
        let function = self.function;
        match function.expressions[handle] {
            Expression::Literal(literal) => self::literal(literal),
            Expression::Constant(constant) => self.items.constant(self.module, constant),
            Expression::ZeroValue(ty) => zero(self.module, ty),
            Expression::Compose { ty, ref components } => {
                if matches!(self.module.types[ty].inner, TypeInner::Array { .. })
                    && is_constant(&function.expressions, handle)
                {
                    return self.hoist(ty, handle);
                }
                let mut parts = Vec::with_capacity(components.len());
                for &component in components {
                    parts.push((self.value(component)?, self.inner(component).clone()));
                }
                compose(self.module, ty, &parts)
            }
            Expression::Splat { value, .. } => {
                let value = self.value(value)?;
                Ok(format!("{}::splat({value})", glam_type(lane_module(self.inner(handle))?)))
            }
            Expression::Swizzle { size, vector, pattern } => {
                let lanes = &pattern[..size as usize];
                let text = self.value(vector)?;
                let bools = self.inner(vector).scalar_kind() == Some(ScalarKind::Bool);
                if !bools {
                    return Ok(format!("{text}.{}()", lanes.iter().map(|&lane| lane_name(lane)).collect::<String>()));
                }
                let lanes: Vec<_> = lanes.iter().map(|&lane| format!("v.{}", lane_name(lane))).collect();
                let ty = glam_type(lane_module(self.inner(handle))?);
                Ok(format!("({{ let v = {text}; {ty}::new({}) }})", lanes.join(", ")))
            }
            Expression::FunctionArgument(index) => {
                self.arguments.get(index as usize).cloned().ok_or_else(|| "an argument that is not declared".to_owned())
            }
            Expression::GlobalVariable(global) => {
                Err(space_name(self.module.global_variables[global].space).to_owned())
            }
            Expression::LocalVariable(_) => Err("a pointer stored as a value".to_owned()),
            Expression::Access { base, index } => {
                let index = Index::Dynamic(self.value(index)?);
                let inner = self.inner(base).clone();
                let base = Place { text: self.value(base)?, reference: false };
                Ok(self.part(base, &inner, index, false)?.whole())
            }
            Expression::AccessIndex { base, index } => {
                let inner = self.inner(base).clone();
                let place = Place { text: self.value(base)?, reference: false };
                let place = self.part(place, &inner, Index::Fixed(index), false)?;
                Ok(self.member(place, base, index)?.whole())
            }
            Expression::Load { pointer } => Ok(self.place(pointer, false)?.whole()),
            Expression::Unary { op, expr } => {
                let text = self.value(expr)?;
                let module = lane_module(self.inner(expr))?;
                Ok(match op {
                    UnaryOperator::LogicalNot | UnaryOperator::BitwiseNot => format!("(!{text})"),
                    UnaryOperator::Negate if matches!(module, "float" | "vec2" | "vec3" | "vec4") => {
                        format!("(-{text})")
                    }
                    UnaryOperator::Negate => format!("wgsl::{module}::neg({text})"),
                })
            }
            Expression::Binary { op, left, right } => {
                let (l, r) = (self.value(left)?, self.value(right)?);
                binary(op, l, lane_module(self.inner(left))?, r, lane_module(self.inner(right))?)
            }
            Expression::Select { condition, accept, reject } => {
                let (c, a, r) = (self.value(condition)?, self.value(accept)?, self.value(reject)?);
                if matches!(self.inner(condition), TypeInner::Scalar(_)) {
                    return Ok(format!("(if {c} {{ {a} }} else {{ {r} }})"));
                }
                Ok(format!("wgsl::{}::select({r}, {a}, {c})", lane_module(self.inner(accept))?))
            }
            Expression::Relational { fun, argument } => {
                let text = self.value(argument)?;
                let scalar = matches!(self.inner(argument), TypeInner::Scalar(_));
                match fun {
                    RelationalFunction::All | RelationalFunction::Any if scalar => Ok(text),
                    RelationalFunction::All => Ok(format!("{text}.all()")),
                    RelationalFunction::Any => Ok(format!("{text}.any()")),
                    RelationalFunction::IsNan => Err("`isnan`".to_owned()),
                    RelationalFunction::IsInf => Err("`isinf`".to_owned()),
                }
            }
            Expression::Math { fun, arg, arg1, arg2, arg3 } => {
                let mut arguments = Vec::with_capacity(4);
                for handle in [Some(arg), arg1, arg2, arg3].into_iter().flatten() {
                    arguments.push((self.value(handle)?, lane_module(self.inner(handle))?));
                }
                math(fun, arguments)
            }
            Expression::As { expr, kind, convert } => {
                let text = self.value(expr)?;
                let module = lane_module(self.inner(expr))?;
                if let Some(width) = convert {
                    crate::types::supported(naga::Scalar { kind, width })?;
                }
                Ok(cast(text, module, self.inner(expr).scalar_kind(), kind, convert.is_some()))
            }
            Expression::CallResult(_) => Err("the result of a call that was not made".to_owned()),
            Expression::ArrayLength(array) => Ok(format!("({}.len() as u32)", self.place(array, false)?.text)),
            Expression::Override(_) => Err("an override".to_owned()),
            Expression::ImageSample { .. } | Expression::ImageLoad { .. } | Expression::ImageQuery { .. } => {
                Err("a texture".to_owned())
            }
            Expression::Derivative { .. } => Err("a derivative (`dpdx`, `dpdy`, `fwidth`)".to_owned()),
            Expression::AtomicResult { .. } => Err("an atomic".to_owned()),
            Expression::WorkGroupUniformLoadResult { .. } => Err("`workgroupUniformLoad`".to_owned()),
            Expression::SubgroupBallotResult | Expression::SubgroupOperationResult { .. } => {
                Err("a subgroup operation".to_owned())
            }
            Expression::RayQueryVertexPositions { .. }
            | Expression::RayQueryProceedResult
            | Expression::RayQueryGetIntersection { .. } => Err("a ray query".to_owned()),
            Expression::CooperativeLoad { .. } | Expression::CooperativeMultiplyAdd { .. } => {
                Err("a cooperative matrix".to_owned())
            }
        }
    }

    /// A constant array of a function as a `static`, so that it is indexed where it lies.
    fn hoist(&mut self, ty: Handle<Type>, handle: Handle<Expression>) -> Result<String, Reason> {
        if let Some(name) = self.tables.get(&handle) {
            return Ok(name.clone());
        }
        let named = self.function.named_expressions.get(&handle).map_or("TABLE", String::as_str);
        let name = self.names.unique(named);
        let text = constant(self.module, self.items, &self.function.expressions, handle)?;
        self.statics.push(format!("static {name}: {} = {text};", rust_type(self.module, ty)?));
        self.tables.insert(handle, name.clone());
        Ok(name)
    }
}

fn lane_name(lane: SwizzleComponent) -> &'static str {
    LANES[lane as usize]
}

/// Whether the expression is made of literals alone.
pub fn is_constant(expressions: &Arena<Expression>, handle: Handle<Expression>) -> bool {
    match expressions[handle] {
        Expression::Literal(_) | Expression::Constant(_) | Expression::ZeroValue(_) => true,
        Expression::Compose { ref components, .. } => components.iter().all(|&part| is_constant(expressions, part)),
        Expression::Splat { value, .. } => is_constant(expressions, value),
        _ => false,
    }
}

/// A constant expression, as the initial value of a `const`, `static` or `let mut`.
pub fn constant(
    module: &Module,
    items: &Items,
    expressions: &Arena<Expression>,
    handle: Handle<Expression>,
) -> Result<String, Reason> {
    match expressions[handle] {
        Expression::Literal(literal) => self::literal(literal),
        Expression::Constant(constant) => items.constant(module, constant),
        Expression::ZeroValue(ty) => zero(module, ty),
        Expression::Compose { ty, ref components } => {
            let flat: Vec<_> = naga::proc::flatten_compose(ty, components, expressions, &module.types).collect();
            let mut parts = Vec::with_capacity(flat.len());
            for part in flat {
                // Only a vector asks for the types of its parts, and after flattening each is a scalar.
                parts.push((constant(module, items, expressions, part)?, TypeInner::Scalar(naga::Scalar::F32)));
            }
            compose(module, ty, &parts)
        }
        Expression::Splat { size, value } => {
            let text = constant(module, items, expressions, value)?;
            let kind = match expressions[value] {
                Expression::Literal(literal) => literal.scalar(),
                Expression::ZeroValue(ty) => module.types[ty].inner.scalar().ok_or("a vector of this type")?,
                _ => return Err("a constant of this kind".to_owned()),
            };
            let module = lane_module(&TypeInner::Vector { size, scalar: kind })?;
            Ok(format!("{}::splat({text})", glam_type(module)))
        }
        _ => Err("a constant of this kind".to_owned()),
    }
}

fn literal(literal: Literal) -> Result<String, Reason> {
    let text = match literal {
        Literal::F32(value) if value.is_finite() => format!("{value:?}_f32"),
        Literal::F32(_) => return Err("a literal that is not finite".to_owned()),
        Literal::U32(value) => format!("{value}u32"),
        Literal::I32(value) => format!("{value}i32"),
        Literal::Bool(value) => value.to_string(),
        Literal::F64(_) => return Err("the type `f64`".to_owned()),
        Literal::F16(_) => return Err("the type `f16`".to_owned()),
        Literal::U64(_) => return Err("the type `u64`".to_owned()),
        Literal::I64(_) => return Err("the type `i64`".to_owned()),
        Literal::U16(_) => return Err("the type `u16`".to_owned()),
        Literal::I16(_) => return Err("the type `i16`".to_owned()),
        Literal::AbstractInt(_) | Literal::AbstractFloat(_) => return Err("a number of no concrete type".to_owned()),
    };
    Ok(if text.starts_with('-') { format!("({text})") } else { text })
}

/// The value with all bits zero.
pub fn zero(module: &Module, ty: Handle<Type>) -> Result<String, Reason> {
    match module.types[ty].inner {
        TypeInner::Array { base, size: ArraySize::Constant(count), .. } => {
            Ok(format!("[{}; {count}]", zero(module, base)?))
        }
        TypeInner::Struct { ref members, .. } => {
            let mut parts = Vec::with_capacity(members.len());
            for member in members {
                parts.push((zero(module, member.ty)?, module.types[member.ty].inner.clone()));
            }
            compose(module, ty, &parts)
        }
        ref inner => Ok(match lane_module(inner)? {
            "float" => "0.0_f32".to_owned(),
            "int" => "0i32".to_owned(),
            "uint" => "0u32".to_owned(),
            "bool" => "false".to_owned(),
            bools @ ("bvec2" | "bvec3" | "bvec4") => format!("{}::FALSE", glam_type(bools)),
            other => format!("{}::ZERO", glam_type(other)),
        }),
    }
}

fn compose(module: &Module, ty: Handle<Type>, parts: &[(String, TypeInner)]) -> Result<String, Reason> {
    let list = || parts.iter().map(|(text, _)| text.as_str()).collect::<Vec<_>>().join(", ");
    match module.types[ty].inner {
        TypeInner::Array { .. } => Ok(format!("[{}]", list())),
        TypeInner::Struct { ref members, .. } => {
            let fields: Vec<_> = members
                .iter()
                .zip(parts)
                .map(|(member, (text, _))| format!("{}: {text}", plain(member.name.as_deref().unwrap_or_default())))
                .collect();
            Ok(format!("({} {{ {} }})", struct_name(module, ty), fields.join(", ")))
        }
        ref inner @ TypeInner::Matrix { .. } => {
            Ok(format!("{}::from_cols({})", glam_type(lane_module(inner)?), list()))
        }
        ref inner => {
            let name = glam_type(lane_module(inner)?);
            if parts.iter().all(|(_, part)| matches!(part, TypeInner::Scalar(_))) {
                return Ok(format!("{name}::new({})", list()));
            }
            if let [(vector, TypeInner::Vector { scalar, .. }), (last, TypeInner::Scalar(_))] = parts
                && scalar.kind != ScalarKind::Bool
            {
                return Ok(format!("{vector}.extend({last})"));
            }
            let mut bound = Vec::new();
            let mut lanes = Vec::new();
            for (i, (_, part)) in parts.iter().enumerate() {
                bound.push(format!("v{i}"));
                match part {
                    TypeInner::Vector { size, .. } => {
                        lanes.extend(LANES[..*size as usize].iter().map(|lane| format!("v{i}.{lane}")));
                    }
                    _ => lanes.push(format!("v{i}")),
                }
            }
            // One pattern binds all, so that no part sees the name of another.
            Ok(format!("({{ let ({},) = ({},); {name}::new({}) }})", bound.join(", "), list(), lanes.join(", ")))
        }
    }
}

fn is_float(module: &str) -> bool {
    module == "float" || module.starts_with("vec") || module.starts_with("mat")
}

fn is_scalar(module: &str) -> bool {
    matches!(module, "float" | "int" | "uint" | "bool")
}

fn binary(op: BinaryOperator, l: String, left: &str, r: String, right: &str) -> Result<String, Reason> {
    use BinaryOperator as Op;
    let (matrix_left, matrix_right) = (left.starts_with("mat"), right.starts_with("mat"));
    if matrix_left || matrix_right {
        return Ok(match op {
            Op::Add => format!("wgsl::{left}::add({l}, {r})"),
            Op::Subtract => format!("wgsl::{left}::sub({l}, {r})"),
            Op::Multiply if matrix_left && matrix_right => format!("wgsl::{left}::mul({l}, {r})"),
            Op::Multiply if right == "float" => format!("wgsl::{left}::scale({l}, {r})"),
            Op::Multiply if left == "float" => format!("wgsl::{right}::scale({r}, {l})"),
            Op::Multiply if matrix_left => format!("wgsl::{left}::mul_vector({l}, {r})"),
            Op::Multiply => format!("wgsl::{right}::vector_mul({l}, {r})"),
            _ => return Err("this operator on a matrix".to_owned()),
        });
    }
    let symbol = match op {
        Op::Add => "+",
        Op::Subtract => "-",
        Op::Multiply => "*",
        Op::Divide => "/",
        Op::Modulo => "%",
        Op::Equal => "==",
        Op::NotEqual => "!=",
        Op::Less => "<",
        Op::LessEqual => "<=",
        Op::Greater => ">",
        Op::GreaterEqual => ">=",
        Op::And => "&",
        Op::ExclusiveOr => "^",
        Op::InclusiveOr => "|",
        Op::LogicalAnd => "&&",
        Op::LogicalOr => "||",
        Op::ShiftLeft => "<<",
        Op::ShiftRight => ">>",
    };
    // A scalar beside a vector is spread over its lanes, but where glam does so itself.
    let lanes = if is_scalar(left) { right } else { left };
    let arithmetic = matches!(op, Op::Add | Op::Subtract | Op::Multiply | Op::Divide);
    if is_float(lanes) && arithmetic {
        return Ok(format!("({l} {symbol} {r})"));
    }
    let shift = matches!(op, Op::ShiftLeft | Op::ShiftRight);
    let l = spread(l, left, lanes);
    let r = if shift && !is_scalar(lanes) && is_scalar(right) {
        format!("{}::splat({r})", glam_type(&lanes.replace("ivec", "uvec")))
    } else if shift {
        r
    } else {
        spread(r, right, lanes)
    };
    let scalar = is_scalar(lanes);
    Ok(match op {
        Op::And | Op::ExclusiveOr | Op::InclusiveOr | Op::LogicalAnd | Op::LogicalOr => format!("({l} {symbol} {r})"),
        Op::Equal | Op::NotEqual | Op::Less | Op::LessEqual | Op::Greater | Op::GreaterEqual if scalar => {
            format!("({l} {symbol} {r})")
        }
        Op::Equal => format!("wgsl::{lanes}::eq({l}, {r})"),
        Op::NotEqual => format!("wgsl::{lanes}::ne({l}, {r})"),
        Op::Less => format!("wgsl::{lanes}::lt({l}, {r})"),
        Op::LessEqual => format!("wgsl::{lanes}::le({l}, {r})"),
        Op::Greater => format!("wgsl::{lanes}::gt({l}, {r})"),
        Op::GreaterEqual => format!("wgsl::{lanes}::ge({l}, {r})"),
        Op::Add if scalar => format!("{l}.wrapping_add({r})"),
        Op::Subtract if scalar => format!("{l}.wrapping_sub({r})"),
        Op::Multiply if scalar => format!("{l}.wrapping_mul({r})"),
        Op::ShiftLeft if scalar => format!("{l}.wrapping_shl({r})"),
        Op::ShiftRight if scalar => format!("{l}.wrapping_shr({r})"),
        Op::Add => format!("wgsl::{lanes}::add({l}, {r})"),
        Op::Subtract => format!("wgsl::{lanes}::sub({l}, {r})"),
        Op::Multiply => format!("wgsl::{lanes}::mul({l}, {r})"),
        Op::ShiftLeft => format!("wgsl::{lanes}::shl({l}, {r})"),
        Op::ShiftRight => format!("wgsl::{lanes}::shr({l}, {r})"),
        Op::Divide => format!("wgsl::{lanes}::div({l}, {r})"),
        Op::Modulo => format!("wgsl::{lanes}::rem({l}, {r})"),
    })
}

/// A scalar as a vector of the same value in every lane, where a vector is wanted.
fn spread(text: String, from: &str, to: &str) -> String {
    if is_scalar(from) && !is_scalar(to) { format!("{}::splat({text})", glam_type(to)) } else { text }
}

fn cast(text: String, module: &str, from: Option<ScalarKind>, to: ScalarKind, convert: bool) -> String {
    use ScalarKind::{Bool, Float, Sint, Uint};
    let Some(from) = from else { return text };
    if from == to {
        return text;
    }
    if is_scalar(module) {
        return match (from, to) {
            (Float, Sint) if !convert => format!("({text}.to_bits() as i32)"),
            (Float, Uint) if !convert => format!("{text}.to_bits()"),
            (Sint, Float) if !convert => format!("f32::from_bits({text} as u32)"),
            (Uint, Float) if !convert => format!("f32::from_bits({text})"),
            (Bool, Float) => format!("(if {text} {{ 1.0_f32 }} else {{ 0.0_f32 }})"),
            (Float, Bool) => format!("({text} != 0.0_f32)"),
            (_, Bool) => format!("({text} != 0)"),
            (_, Float) => format!("({text} as f32)"),
            (_, Sint) => format!("({text} as i32)"),
            _ => format!("({text} as u32)"),
        };
    }
    let bits = !convert && (from == Float || to == Float);
    let target = match to {
        Float => "float",
        Sint => "int",
        Uint => "uint",
        _ => "bool",
    };
    format!("wgsl::{module}::{}_{target}({text})", if bits { "bits" } else { "to" })
}

fn math(fun: MathFunction, mut arguments: Vec<(String, &'static str)>) -> Result<String, Reason> {
    use MathFunction as F;
    let wgsl = wgsl_name(fun);
    let name = match fun {
        F::Abs => "abs",
        F::Min => "min",
        F::Max => "max",
        F::Clamp => "clamp",
        F::Saturate => "saturate",
        F::Radians => "radians",
        F::Degrees => "degrees",
        F::Ceil => "ceil",
        F::Floor => "floor",
        F::Round => "round",
        F::Fract => "fract",
        F::Trunc => "trunc",
        F::Dot => "dot",
        F::Distance => "distance",
        F::Length => "length",
        F::Normalize => "normalize",
        F::FaceForward => "face_forward",
        F::Reflect => "reflect",
        F::Refract => "refract",
        F::Sign => "sign",
        F::Fma => "fma",
        F::Mix => "mix",
        F::Step => "step",
        F::SmoothStep => "smoothstep",
        F::Sqrt => "sqrt",
        F::InverseSqrt => "inverse_sqrt",
        F::Transpose => "transpose",
        F::Determinant => "determinant",
        F::QuantizeToF16 => "quantize_to_f16",
        F::CountTrailingZeros => "count_trailing_zeros",
        F::CountLeadingZeros => "count_leading_zeros",
        F::CountOneBits => "count_one_bits",
        F::ReverseBits => "reverse_bits",
        F::ExtractBits => "extract_bits",
        F::InsertBits => "insert_bits",
        F::FirstTrailingBit => "first_trailing_bit",
        F::FirstLeadingBit => "first_leading_bit",
        F::Cross => "",
        F::Pack4x8snorm => "pack_4x8_snorm",
        F::Pack4x8unorm => "pack_4x8_unorm",
        F::Pack2x16snorm => "pack_2x16_snorm",
        F::Pack2x16unorm => "pack_2x16_unorm",
        F::Pack2x16float => "pack_2x16_float",
        F::Unpack4x8snorm => "unpack_4x8_snorm",
        F::Unpack4x8unorm => "unpack_4x8_unorm",
        F::Unpack2x16snorm => "unpack_2x16_snorm",
        F::Unpack2x16unorm => "unpack_2x16_unorm",
        F::Unpack2x16float => "unpack_2x16_float",
        F::Cos
        | F::Cosh
        | F::Sin
        | F::Sinh
        | F::Tan
        | F::Tanh
        | F::Acos
        | F::Asin
        | F::Atan
        | F::Atan2
        | F::Asinh
        | F::Acosh
        | F::Atanh
        | F::Exp
        | F::Exp2
        | F::Log
        | F::Log2
        | F::Pow => {
            return Err(format!("`{wgsl}`: write it with math.wgsl, so that every CPU gives the same bits"));
        }
        F::Modf
        | F::Frexp
        | F::Ldexp
        | F::Dot4I8Packed
        | F::Dot4U8Packed
        | F::Outer
        | F::Inverse
        | F::Pack4xI8
        | F::Pack4xU8
        | F::Pack4xI8Clamp
        | F::Pack4xU8Clamp
        | F::Unpack4xI8
        | F::Unpack4xU8 => {
            return Err(format!("`{wgsl}`"));
        }
    };
    let lanes = arguments.first().map_or("float", |(_, module)| module);
    // `mix(v, w, t)` takes one number for every lane.
    if fun == F::Mix {
        arguments = arguments.into_iter().map(|(text, module)| (spread(text, module, lanes), lanes)).collect();
    }
    let list = arguments.iter().map(|(text, _)| text.as_str()).collect::<Vec<_>>().join(", ");
    Ok(match name {
        "" => format!("wgsl::cross({list})"),
        _ if name.starts_with("pack_") || name.starts_with("unpack_") => format!("wgsl::pack::{name}({list})"),
        _ => format!("wgsl::{lanes}::{name}({list})"),
    })
}

/// The built-in function as WGSL writes it.
fn wgsl_name(fun: MathFunction) -> String {
    let debug = format!("{fun:?}");
    let mut letters = debug.chars();
    let first = letters.next().map(|letter| letter.to_ascii_lowercase());
    first.into_iter().chain(letters).collect()
}
