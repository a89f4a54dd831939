//! The same functions over many lanes at once: what `if` and loops do becomes masks, values become vectors with one lane
//! a caller, and each lane gets the bits that the scalar function would give it.
//!
//! Every function runs under a mask of the lanes that asked for it. A side of an `if` that no lane takes is skipped, a
//! loop turns while any lane is left in it. What is the same in all lanes, because it depends on constants and uniforms
//! alone, stays scalar code ([`uniform`]).

mod body;
mod uniform;
mod value;

use std::collections::HashSet;
use std::fmt::Write as _;

use naga::{ArraySize, Block, Function, Handle, Module, Scalar, ScalarKind, Statement, Type, TypeInner, VectorSize};

use crate::items::{Callee, Items};
use crate::names::plain;
use crate::types::{Reason, rust_type, struct_name};
use crate::{Error, Options, Output};

/// The registers that lanes live in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Registers {
    /// Eight lanes.
    Avx2,
    /// Sixteen lanes.
    Avx512,
}

impl Registers {
    /// The features of the CPU that the code asks for, as `#[target_feature]` takes them.
    pub fn features(self) -> &'static str {
        match self {
            Self::Avx2 => "avx2,bmi1,bmi2,lzcnt,popcnt",
            Self::Avx512 => "avx512f,avx512bw,avx512dq,avx512vl,avx2,bmi1,bmi2,lzcnt,popcnt",
        }
    }

    fn prelude(self) -> &'static str {
        match self {
            Self::Avx2 => include_str!("avx2.rs"),
            Self::Avx512 => include_str!("avx512.rs"),
        }
    }
}

/// What to translate to lanes.
#[derive(Clone, Copy, Debug)]
pub struct LaneOptions<'a> {
    /// The path of the module that includes the scalar translation, such as `crate::generated`.
    pub scalar: &'a str,
    /// The functions to translate; those that they call follow.
    pub roots: &'a [&'a str],
    /// The registers, and with them the number of lanes.
    pub registers: Registers,
}

/// Translates functions of a WGSL module to Rust over lanes, as methods of a struct `Lanes` about the scalar kernel. The
/// text is a module of its own beside that of [`translate`](crate::translate), for x86-64 only, and holds the few lines of
/// unsafe code that vector registers ask for. Its functions are safe to call where the features are enabled. Native
/// functions are called as `native::NAME(self, mask, …)`: whoever includes the text puts a module `native` beside it.
///
/// # Errors
/// As of [`translate`](crate::translate); a root that is not declared; a function called from a root that has no
/// translation to lanes.
pub fn translate_lanes(wgsl: &str, options: &Options<'_>, lanes: &LaneOptions<'_>) -> Result<Output, Error> {
    let (module, info) = crate::validate(wgsl)?;
    let items = Items::new(&module, options)?;
    let mut wanted: HashSet<Handle<Function>> = HashSet::new();
    let mut open = Vec::new();
    for &root in lanes.roots {
        let found = module.functions.iter().find(|(_, function)| function.name.as_deref() == Some(root));
        let (handle, _) = found.ok_or_else(|| Error::construct(root, "a function that the WGSL does not declare"))?;
        open.push(handle);
    }
    while let Some(handle) = open.pop() {
        if matches!(items.functions.get(&handle), Some(Callee::Method(_))) && wanted.insert(handle) {
            calls(&module.functions[handle].body, &mut open);
        }
    }
    let attributes = format!("#[target_feature(enable = \"{}\")]", lanes.registers.features());
    let mut rust = String::from("use glam::{Vec2Swizzles as _, Vec3Swizzles as _, Vec4Swizzles as _};\n");
    writeln!(rust, "use {}::*;", lanes.scalar)?;
    writeln!(rust, "use {}::{} as Scalar;\n", lanes.scalar, options.struct_name)?;
    structs(&module, &mut rust)?;
    rust += "/// The scalar kernel's functions on lanes.\n#[derive(Clone, Copy)]\npub struct Lanes<'a>(pub &'a Scalar<'a>);\n";
    rust += "impl<'a> core::ops::Deref for Lanes<'a> {\n    type Target = Scalar<'a>;\n    #[inline(always)]\n";
    rust += "    fn deref(&self) -> &Scalar<'a> {\n        self.0\n    }\n}\nimpl Lanes<'_> {\n";
    for (handle, function) in module.functions.iter().filter(|(handle, _)| wanted.contains(handle)) {
        let name = function.name.as_deref().unwrap_or("unnamed");
        let Some(Callee::Method(method)) = items.functions.get(&handle) else { continue };
        let text = body::function(&module, &items, &info[handle], function, method)
            .map_err(|reason| Error::construct(name, format!("{reason} on lanes")))?;
        rust.push_str(&text);
    }
    rust += "}\n";
    rust += lanes.registers.prelude();
    rust += include_str!("common.rs");
    let inline = format!("{attributes} #[inline]");
    Ok(Output { rust: rust.replace("#[lanes]", &inline).replace("#[function]", &attributes) })
}

fn calls(block: &Block, found: &mut Vec<Handle<Function>>) {
    for statement in block {
        match statement {
            Statement::Call { function, .. } => found.push(*function),
            Statement::Block(block) => calls(block, found),
            Statement::If { accept, reject, .. } => {
                calls(accept, found);
                calls(reject, found);
            }
            Statement::Switch { cases, .. } => cases.iter().for_each(|case| calls(&case.body, found)),
            Statement::Loop { body, continuing, .. } => {
                calls(body, found);
                calls(continuing, found);
            }
            _ => {}
        }
    }
}

/// `F`, `I`, `U` or `M`.
fn scalar_type(scalar: Scalar) -> Result<&'static str, Reason> {
    Ok(match crate::types::supported(scalar)? {
        ScalarKind::Float => "w::F",
        ScalarKind::Sint => "w::I",
        ScalarKind::Uint => "w::U",
        _ => "w::M",
    })
}

/// The type of a value on lanes, fit to stand before `::` but for an array.
fn lane_type(module: &Module, ty: Handle<Type>) -> Result<String, Reason> {
    match module.types[ty].inner {
        TypeInner::Array { base, size: ArraySize::Constant(count), .. } => {
            Ok(format!("[{}; {count}]", lane_type(module, base)?))
        }
        TypeInner::Struct { .. } => {
            rust_type(module, ty)?;
            Ok(format!("{}Lanes", struct_name(module, ty)))
        }
        TypeInner::Pointer { base, .. } => {
            rust_type(module, ty)?;
            Ok(format!("&mut {}", lane_type(module, base)?))
        }
        ref inner => inner_type(inner),
    }
}

fn inner_type(inner: &TypeInner) -> Result<String, Reason> {
    crate::types::lane_module(inner)?;
    match *inner {
        TypeInner::Scalar(scalar) => scalar_type(scalar).map(str::to_owned),
        TypeInner::Vector { size, scalar } => Ok(format!("w::V{}::<{}>", size as u8, scalar_type(scalar)?)),
        TypeInner::Matrix { columns, scalar, .. } => {
            let n = columns as u8;
            Ok(format!("w::V{n}::<w::V{n}::<{}>>", scalar_type(scalar)?))
        }
        _ => Err("a value of this type".to_owned()),
    }
}

fn count(size: VectorSize) -> usize {
    size as usize
}

/// A constructor such as `splat` or `gather` of a value on lanes, `text` being its scalar.
fn splat(module: &Module, ty: Handle<Type>, text: &str) -> Result<String, Reason> {
    Ok(match module.types[ty].inner {
        TypeInner::Array { base, size: ArraySize::Constant(n), .. } => {
            let parts: Result<Vec<_>, _> = (0..n.get()).map(|i| splat(module, base, &format!("{text}[{i}]"))).collect();
            format!("[{}]", parts?.join(", "))
        }
        _ => format!("{}::splat({text})", lane_type(module, ty)?),
    })
}

/// Reads a scalar place in every lane: `text` mentions the lane as `k`.
fn gather(module: &Module, ty: Handle<Type>, text: &str) -> Result<String, Reason> {
    Ok(match module.types[ty].inner {
        TypeInner::Array { base, size: ArraySize::Constant(n), .. } => {
            let parts: Result<Vec<_>, _> =
                (0..n.get()).map(|i| gather(module, base, &format!("{text}[{i}]"))).collect();
            format!("[{}]", parts?.join(", "))
        }
        TypeInner::Struct { ref members, .. } => {
            let mut parts = Vec::new();
            for member in members {
                let field = plain(member.name.as_deref().unwrap_or_default());
                parts.push(format!("{field}: {}", gather(module, member.ty, &format!("{text}.{field}"))?));
            }
            format!("{} {{ {} }}", lane_type(module, ty)?, parts.join(", "))
        }
        _ => format!("{}::gather(|k| {text})", lane_type(module, ty)?),
    })
}

/// The scalar value of lane `k`.
fn get(module: &Module, ty: Handle<Type>, text: &str) -> String {
    match module.types[ty].inner {
        TypeInner::Array { base, size: ArraySize::Constant(n), .. } => {
            let parts: Vec<_> = (0..n.get()).map(|i| get(module, base, &format!("{text}[{i}]"))).collect();
            format!("[{}]", parts.join(", "))
        }
        _ => format!("{text}.get(k)"),
    }
}

/// `accept` in the lanes of the mask, `reject` in the others.
fn select(module: &Module, ty: Handle<Type>, mask: &str, accept: &str, reject: &str) -> Result<String, Reason> {
    Ok(match module.types[ty].inner {
        TypeInner::Array { base, size: ArraySize::Constant(n), .. } => {
            let part = |i| select(module, base, mask, &format!("{accept}[{i}]"), &format!("{reject}[{i}]"));
            let parts: Result<Vec<_>, _> = (0..n.get()).map(part).collect();
            format!("[{}]", parts?.join(", "))
        }
        _ => format!("{}::select({mask}, {accept}, {reject})", lane_type(module, ty)?),
    })
}

/// Each struct on lanes, with what its scalar twin needs.
fn structs(module: &Module, out: &mut String) -> Result<(), Error> {
    for (handle, ty) in module.types.iter() {
        let TypeInner::Struct { members, .. } = &ty.inner else { continue };
        let Some(name) = ty.name.as_deref().filter(|name| !name.starts_with("__")) else { continue };
        if rust_type(module, handle).is_err() {
            continue;
        }
        one_struct(module, handle, members, out).map_err(|reason| Error::construct(name, reason))?;
    }
    Ok(())
}

fn one_struct(
    module: &Module,
    handle: Handle<Type>,
    members: &[naga::StructMember],
    out: &mut String,
) -> Result<(), Reason> {
    let (name, scalar) = (lane_type(module, handle)?, struct_name(module, handle));
    let mut fields = String::new();
    let (mut splats, mut gathers, mut gets, mut selects) = (vec![], vec![], vec![], vec![]);
    for member in members {
        let field = plain(member.name.as_deref().unwrap_or_default());
        fields += &format!("    pub {field}: {},\n", lane_type(module, member.ty)?);
        splats.push(format!("{field}: {}", splat(module, member.ty, &format!("a.{field}"))?));
        gathers.push(format!("{field}: {}", gather(module, member.ty, &format!("f(k).{field}"))?));
        gets.push(format!("{field}: {}", get(module, member.ty, &format!("self.{field}"))));
        let chosen = select(module, member.ty, "m", &format!("accept.{field}"), &format!("reject.{field}"))?;
        selects.push(format!("{field}: {chosen}"));
    }
    *out += &format!(
        "/// `{scalar}` on lanes.\n#[derive(Clone, Copy)]\npub struct {name} {{\n{fields}}}\nimpl {name} {{\n"
    );
    for (signature, body) in [
        (format!("splat(a: {scalar}) -> Self"), format!("Self {{ {} }}", splats.join(", "))),
        (format!("gather(f: impl Fn(usize) -> {scalar}) -> Self"), format!("Self {{ {} }}", gathers.join(", "))),
        (format!("get(&self, k: usize) -> {scalar}"), format!("{scalar} {{ {} }}", gets.join(", "))),
        ("select(m: w::M, accept: Self, reject: Self) -> Self".into(), format!("Self {{ {} }}", selects.join(", "))),
    ] {
        *out += &format!("    #[lanes]\n    pub fn {signature} {{\n        {body}\n    }}\n");
    }
    *out += "}\n";
    Ok(())
}
