//! WGSL to Rust, over naga's IR: what makes one shader source the CPU renderer and the GPU renderer.
//!
//! [`translate`] turns the functions of a WGSL module into the methods of one struct whose fields are the module's
//! bindings:
//!
//! ```
//! let options = kinora_translate::Options { struct_name: "Kernel", native: &[], native_path: "", inline: &[] };
//! let output = kinora_translate::translate("fn twice(x: f32) -> f32 { return 2.0 * x; }", &options)?;
//! assert!(output.rust.contains("pub fn twice(&self, x: f32) -> f32"));
//! # Ok::<(), kinora_translate::Error>(())
//! ```
//!
//! A build script writes the result to a file, and the crate includes it in a module of its own:
//!
//! ```text
//! mod generated {
//!     #![allow(missing_docs, nonstandard_style, unused, clippy::all)]
//!     include!(concat!(env!("OUT_DIR"), "/kernel.rs"));
//! }
//! ```
//!
//! Those four allowances are all that the generated code asks for. It needs the crates `glam` and `bytemuck`, the latter
//! for structs that the host shares with the shader; a struct that holds an array of odd length asks for bytemuck's
//! feature `min_const_generics`.
//!
//! What stands for what:
//!
//! | WGSL | Rust |
//! |---|---|
//! | `struct S` | `#[repr(C)] pub struct S`, `Pod` and checked against WGSL's offsets where a binding holds it |
//! | `vec3<f32>` `vec3<u32>` `vec3<i32>` `vec3<bool>` `mat3x3<f32>` | `glam::Vec3` `UVec3` `IVec3` `BVec3` `Mat3` |
//! | `const X: f32` · `const X: array<…>` | `pub const` · `pub static`; one with no concrete type (`const N = 3;`) is folded away |
//! | `var<storage, read> s: array<S>` · `var<uniform> p: P` | a field `pub s: &'a [S]` · `pub p: &'a P`, if a translated function uses it |
//! | `fn f(a: f32, p: ptr<function, S>)` | `pub fn f(&self, a: f32, p: &mut S)` |
//! | a function named in [`Options::native`] | a call `NATIVE_PATH::f(self, …)`; the struct gains `pub native: &'a NATIVE_PATH::Native<'a>` |
//! | entry points | nothing |
//!
//! The generated code never panics but for a read of an empty slice, and gives the same bits on every CPU: integers
//! wrap, `x / 0` is `x`, an index past the end reads the last element, sums keep the order in which they are written,
//! and the transcendental functions, which differ from one standard library to the next, are refused.
//!
//! [`translate_lanes`] writes the same functions over eight or sixteen lanes of vector registers, with the same bits in
//! every lane.

mod expression;
mod function;
mod items;
mod lanes;
mod names;
mod types;

use std::fmt::Write as _;

pub use lanes::{LaneOptions, Registers, translate_lanes};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

/// How to translate.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    /// The name of the struct that holds the bindings, such as `Kernel`.
    pub struct_name: &'a str,
    /// The names of the functions that are not translated but called at [`Self::native_path`]. naga still checks their
    /// WGSL.
    pub native: &'a [&'a str],
    /// The path of the module that holds the native functions and a struct `Native<'a>`, such as `crate::query`.
    pub native_path: &'a str,
    /// The names of the functions that are inlined wherever they are called: those of the innermost loops.
    pub inline: &'a [&'a str],
}

/// What [`translate`] makes.
#[derive(Clone, Debug)]
pub struct Output {
    /// Items of Rust, to be included in a module.
    pub rust: String,
}

/// Why WGSL was refused.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The text is not WGSL; naga's diagnostic, with the line.
    #[error("{0}")]
    Parse(String),
    /// The module is not valid; naga's diagnostic, with the line.
    #[error("{0}")]
    Validate(String),
    /// Something valid that has no translation.
    #[error("`{item}`: no translation to Rust for {construct}")]
    Construct {
        /// The function, struct, constant or binding.
        item: String,
        /// What in it cannot be translated.
        construct: String,
    },
    /// A type that Rust lays out otherwise than WGSL.
    #[error("`{item}`: {reason}")]
    Layout {
        /// The struct or binding.
        item: String,
        /// The member, and what to pad.
        reason: String,
    },
    /// The text could not be written.
    #[error("the translation could not be written")]
    Write(#[from] std::fmt::Error),
}

impl Error {
    fn construct(item: &str, construct: impl Into<String>) -> Self {
        Self::Construct { item: item.to_owned(), construct: construct.into() }
    }

    fn layout(item: &str, reason: impl Into<String>) -> Self {
        Self::Layout { item: item.to_owned(), reason: reason.into() }
    }
}

/// Parses and checks a WGSL module.
///
/// # Errors
/// What naga says, with the lines it is about.
pub fn validate(wgsl: &str) -> Result<(naga::Module, ModuleInfo), Error> {
    let module = naga::front::wgsl::parse_str(wgsl).map_err(|error| Error::Parse(error.emit_to_string(wgsl)))?;
    // `pack2x16float` and its kin, which every WebGPU device has.
    let capabilities = Capabilities::default() | Capabilities::SHADER_FLOAT16_IN_FLOAT32;
    let info = Validator::new(ValidationFlags::all(), capabilities)
        .validate(&module)
        .map_err(|error| Error::Validate(error.emit_to_string(wgsl)))?;
    Ok((module, info))
}

/// Translates a WGSL module to Rust.
///
/// # Errors
/// What naga says of the module; the function and the construct that has no translation; the struct and member whose
/// layout Rust does not share.
pub fn translate(wgsl: &str, options: &Options<'_>) -> Result<Output, Error> {
    let (module, info) = validate(wgsl)?;
    if let Some((_, variable)) = module.overrides.iter().next() {
        return Err(Error::construct(variable.name.as_deref().unwrap_or("override"), "an override"));
    }
    let items = items::Items::new(&module, options)?;
    let mut rust = String::from("use glam::{Vec2Swizzles as _, Vec3Swizzles as _, Vec4Swizzles as _};\n");
    items::structs(&module, options, &mut rust)?;
    items::constants(&module, &items, &mut rust)?;
    items::kernel(&module, &items, options, &mut rust)?;
    writeln!(rust, "impl {}<'_> {{", options.struct_name)?;
    for (handle, function) in module.functions.iter() {
        let Some(items::Callee::Method(name)) = items.functions.get(&handle) else { continue };
        let text = function::function(&module, &items, &info[handle], function, name)
            .map_err(|reason| Error::construct(function.name.as_deref().unwrap_or("unnamed"), reason))?;
        rust.push_str(&text);
    }
    rust.push_str("}\n");
    rust.push_str(include_str!("prelude.rs"));
    Ok(Output { rust })
}
