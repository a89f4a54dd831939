//! What stands at the top level: structs, constants and the struct that holds the bindings.

use std::collections::{HashMap, HashSet};
use std::fmt::Write as _;

use naga::{
    AddressSpace, Constant, Expression, Function, GlobalVariable, Handle, Module, StorageAccess, Type, TypeInner,
};

use crate::names::{Names, plain};
use crate::types::{self, Reason, rust_type, space_name, struct_name};
use crate::{Error, Options, expression};

/// The Rust name of everything that a function may mention.
pub struct Items {
    pub constants: HashMap<Handle<Constant>, String>,
    pub functions: HashMap<Handle<Function>, Callee>,
    /// The bindings that are fields of the kernel struct.
    pub globals: HashMap<Handle<GlobalVariable>, String>,
    /// The names that a local must not take: Rust reads `let NAME` as a pattern where `NAME` is a constant.
    pub names: Names,
    /// The functions that are always inlined.
    pub inline: Vec<String>,
}

/// How a function is called.
pub enum Callee {
    Method(String),
    Native(String),
}

impl Items {
    pub fn new(module: &Module, options: &Options<'_>) -> Result<Self, Error> {
        let mut names = Names::default();
        names.unique(options.struct_name);
        let mut constants = HashMap::new();
        for (handle, constant) in module.constants.iter() {
            if let Some(name) = &constant.name {
                constants.insert(handle, names.unique(name));
            }
        }
        let mut functions = HashMap::new();
        let mut globals = HashMap::new();
        for (handle, function) in module.functions.iter() {
            let name = function.name.as_deref().unwrap_or_default();
            if options.native.contains(&name) {
                functions.insert(handle, Callee::Native(format!("{}::{}", options.native_path, plain(name))));
                continue;
            }
            functions.insert(handle, Callee::Method(plain(name)));
            for (_, expression) in function.expressions.iter() {
                if let Expression::GlobalVariable(global) = *expression {
                    let variable = &module.global_variables[global];
                    let variable_name = variable.name.as_deref().unwrap_or("unnamed");
                    if !is_binding(variable.space) {
                        let construct = format!("`{variable_name}`, {}", space_name(variable.space));
                        return Err(Error::construct(name, construct));
                    }
                    globals.insert(global, plain(variable_name));
                }
            }
        }
        if let Some(missing) = options
            .native
            .iter()
            .find(|&&native| !module.functions.iter().any(|(_, function)| function.name.as_deref() == Some(native)))
        {
            return Err(Error::construct(missing, "a native function that the WGSL does not declare"));
        }
        let inline = options.inline.iter().map(|name| plain(name)).collect();
        Ok(Self { constants, functions, globals, names, inline })
    }

    /// A constant by name, or its value where it has none.
    pub fn constant(&self, module: &Module, handle: Handle<Constant>) -> Result<String, Reason> {
        match self.constants.get(&handle) {
            Some(name) => Ok(name.clone()),
            None => expression::constant(module, self, &module.global_expressions, module.constants[handle].init),
        }
    }
}

fn is_binding(space: AddressSpace) -> bool {
    match space {
        AddressSpace::Uniform => true,
        AddressSpace::Storage { access } => !access.contains(StorageAccess::STORE),
        _ => false,
    }
}

/// The structs that have a Rust form. One that holds a run-time sized array or an atomic has none; it is an error only
/// where a function uses it.
pub fn structs(module: &Module, options: &Options<'_>, out: &mut String) -> Result<(), Error> {
    let shared = types::host_shareable(module);
    let mut seen = HashSet::from([options.struct_name.to_owned()]);
    for (handle, ty) in module.types.iter() {
        let TypeInner::Struct { members, span } = &ty.inner else { continue };
        let Some(wgsl_name) = ty.name.as_deref().filter(|name| !name.starts_with("__")) else { continue };
        if rust_type(module, handle).is_err() {
            continue;
        }
        let name = struct_name(module, handle);
        if !seen.insert(name.clone()) {
            return Err(Error::construct(wgsl_name, "a struct whose name is taken"));
        }
        let shared = shared.contains(&handle);
        if shared {
            types::check_layout(module, handle).map_err(|reason| Error::layout(wgsl_name, reason))?;
        }
        one_struct(module, handle, &name, shared.then_some(*span), out)
            .map_err(|reason| Error::construct(wgsl_name, reason))?;
        if shared {
            writeln!(out, "const _: () = {{\n    assert!(core::mem::size_of::<{name}>() == {span});")?;
            for member in members {
                let field = plain(member.name.as_deref().unwrap_or_default());
                writeln!(out, "    assert!(core::mem::offset_of!({name}, {field}) == {});", member.offset)?;
            }
            writeln!(out, "}};")?;
        }
    }
    Ok(())
}

fn one_struct(
    module: &Module,
    handle: Handle<Type>,
    name: &str,
    shared: Option<u32>,
    out: &mut String,
) -> Result<(), Reason> {
    let TypeInner::Struct { ref members, .. } = module.types[handle].inner else { return Ok(()) };
    let own_default = members.iter().any(|member| types::needs_own_default(module, member.ty));
    let mut text = String::from("#[repr(C)]\n#[derive(Clone, Copy, Debug, PartialEq");
    text += if own_default { "" } else { ", Default" };
    text += if shared.is_some() { ", bytemuck::Pod, bytemuck::Zeroable)]\n" } else { ")]\n" };
    text += &format!("pub struct {name} {{\n");
    for member in members {
        let field = plain(member.name.as_deref().unwrap_or_default());
        text += &format!("    pub {field}: {},\n", rust_type(module, member.ty)?);
    }
    text += "}\n";
    if own_default {
        let zero = expression::zero(module, handle)?;
        text += &format!("impl Default for {name} {{\n    fn default() -> Self {{\n        {zero}\n    }}\n}}\n");
    }
    out.push_str(&text);
    Ok(())
}

/// `pub const` for each constant; `pub static` for an array, which is then indexed where it lies.
pub fn constants(module: &Module, items: &Items, out: &mut String) -> Result<(), Error> {
    for (handle, constant) in module.constants.iter() {
        let Some(name) = items.constants.get(&handle) else { continue };
        let array = matches!(module.types[constant.ty].inner, TypeInner::Array { .. });
        let keyword = if array { "static" } else { "const" };
        let text = expression::constant(module, items, &module.global_expressions, constant.init)
            .and_then(|value| Ok(format!("pub {keyword} {name}: {} = {value};", rust_type(module, constant.ty)?)))
            .map_err(|reason| Error::construct(name, reason))?;
        writeln!(out, "{text}")?;
    }
    Ok(())
}

/// The struct whose fields are the bindings and whose methods are the functions.
pub fn kernel(module: &Module, items: &Items, options: &Options<'_>, out: &mut String) -> Result<(), Error> {
    let mut fields = String::new();
    for (handle, variable) in module.global_variables.iter() {
        let Some(name) = items.globals.get(&handle) else { continue };
        let ty = global_type(module, variable).map_err(|reason| Error::construct(name, reason))?;
        types::check_stride(module, variable.ty).map_err(|reason| Error::layout(name, reason))?;
        writeln!(fields, "    pub {name}: &'a {ty},")?;
    }
    if !options.native.is_empty() {
        writeln!(fields, "    pub native: &'a {}::Native<'a>,", options.native_path)?;
    }
    let mut derives = "Clone, Copy";
    if fields.is_empty() {
        derives = "Clone, Copy, Debug, Default";
        fields.push_str("    pub unbound: core::marker::PhantomData<&'a ()>,\n");
    }
    writeln!(out, "#[derive({derives})]\npub struct {}<'a> {{\n{fields}}}", options.struct_name)?;
    Ok(())
}

fn global_type(module: &Module, variable: &GlobalVariable) -> Result<String, Reason> {
    match module.types[variable.ty].inner {
        TypeInner::Array { base, size: naga::ArraySize::Dynamic, .. } => Ok(format!("[{}]", rust_type(module, base)?)),
        _ => rust_type(module, variable.ty),
    }
}
