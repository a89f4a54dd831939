//! What a WGSL type is called in Rust, and whether Rust lays it out as WGSL does.

use std::collections::HashSet;

use naga::{AddressSpace, ArraySize, Handle, Module, Scalar, ScalarKind, Type, TypeInner, VectorSize};

/// Why a type, expression or statement has no translation.
pub type Reason = String;

/// The name of the prelude's module for a scalar, vector or matrix: `float`, `uvec3`, `mat4` …
pub fn lane_module(inner: &TypeInner) -> Result<&'static str, Reason> {
    use ScalarKind::{Bool, Float, Sint, Uint};
    use VectorSize::{Bi, Quad, Tri};
    Ok(match *inner {
        TypeInner::Scalar(scalar) => match supported(scalar)? {
            Float => "float",
            Sint => "int",
            Uint => "uint",
            _ => "bool",
        },
        TypeInner::Vector { size, scalar } => match (supported(scalar)?, size) {
            (Float, Bi) => "vec2",
            (Float, Tri) => "vec3",
            (Float, Quad) => "vec4",
            (Sint, Bi) => "ivec2",
            (Sint, Tri) => "ivec3",
            (Sint, Quad) => "ivec4",
            (Uint, Bi) => "uvec2",
            (Uint, Tri) => "uvec3",
            (Uint, Quad) => "uvec4",
            (Bool, Bi) => "bvec2",
            (Bool, Tri) => "bvec3",
            _ => "bvec4",
        },
        TypeInner::Matrix { columns, rows, scalar } if columns == rows && supported(scalar)? == Float => {
            match columns {
                Bi => "mat2",
                Tri => "mat3",
                Quad => "mat4",
            }
        }
        TypeInner::Matrix { columns, rows, .. } => {
            return Err(format!("a matrix that is not square (mat{}x{})", columns as u8, rows as u8));
        }
        ref other => return Err(describe(other).to_owned()),
    })
}

/// The glam type of a vector or matrix, by its module in the prelude.
pub fn glam_type(module: &str) -> &'static str {
    match module {
        "vec2" => "glam::Vec2",
        "vec3" => "glam::Vec3",
        "vec4" => "glam::Vec4",
        "ivec2" => "glam::IVec2",
        "ivec3" => "glam::IVec3",
        "ivec4" => "glam::IVec4",
        "uvec2" => "glam::UVec2",
        "uvec3" => "glam::UVec3",
        "uvec4" => "glam::UVec4",
        "bvec2" => "glam::BVec2",
        "bvec3" => "glam::BVec3",
        "bvec4" => "glam::BVec4",
        "mat2" => "glam::Mat2",
        "mat3" => "glam::Mat3",
        "mat4" => "glam::Mat4",
        "float" => "f32",
        "int" => "i32",
        "uint" => "u32",
        _ => "bool",
    }
}

/// The kind of a scalar of 32 bits or of a bool; an error for `f16`, `i64`, `u64` and `f64`.
pub fn supported(scalar: Scalar) -> Result<ScalarKind, Reason> {
    match (scalar.kind, scalar.width) {
        (kind @ (ScalarKind::Float | ScalarKind::Sint | ScalarKind::Uint), 4) => Ok(kind),
        (ScalarKind::Bool, _) => Ok(ScalarKind::Bool),
        (ScalarKind::Float, width) => Err(format!("the type `f{}`", u32::from(width) * 8)),
        (ScalarKind::Sint, width) => Err(format!("the type `i{}`", u32::from(width) * 8)),
        (ScalarKind::Uint, width) => Err(format!("the type `u{}`", u32::from(width) * 8)),
        (ScalarKind::AbstractInt | ScalarKind::AbstractFloat, _) => Err("a number of no concrete type".to_owned()),
    }
}

/// What a type that has no translation is, in words.
fn describe(inner: &TypeInner) -> &'static str {
    match inner {
        TypeInner::Atomic(_) => "an atomic",
        TypeInner::Image { .. } => "a texture",
        TypeInner::Sampler { .. } => "a sampler",
        TypeInner::AccelerationStructure { .. } | TypeInner::RayQuery { .. } => "a ray query",
        TypeInner::BindingArray { .. } => "a binding array",
        TypeInner::CooperativeMatrix { .. } => "a cooperative matrix",
        TypeInner::Pointer { .. } | TypeInner::ValuePointer { .. } => "a pointer stored as a value",
        TypeInner::Array { .. } => "an array here",
        TypeInner::Struct { .. } => "a struct here",
        TypeInner::Scalar(_) | TypeInner::Vector { .. } | TypeInner::Matrix { .. } => "this type",
    }
}

/// The Rust type of a value of the WGSL type.
pub fn rust_type(module: &Module, ty: Handle<Type>) -> Result<String, Reason> {
    rust_type_inner(module, &module.types[ty].inner, Some(ty))
}

fn rust_type_inner(module: &Module, inner: &TypeInner, ty: Option<Handle<Type>>) -> Result<String, Reason> {
    match *inner {
        TypeInner::Scalar(_) | TypeInner::Vector { .. } | TypeInner::Matrix { .. } => {
            Ok(glam_type(lane_module(inner)?).to_owned())
        }
        TypeInner::Array { base, size: ArraySize::Constant(count), .. } => {
            Ok(format!("[{}; {count}]", rust_type(module, base)?))
        }
        TypeInner::Array { size: ArraySize::Dynamic, .. } => Err("an array of run-time size as a value".to_owned()),
        TypeInner::Array { .. } => Err("an array sized by an override".to_owned()),
        TypeInner::Struct { ref members, .. } => {
            for member in members {
                rust_type(module, member.ty).map_err(|reason| match (&member.name, ty) {
                    (Some(member), Some(ty)) => format!("{reason}, in member `{}.{member}`", struct_name(module, ty)),
                    _ => reason,
                })?;
            }
            ty.map(|ty| struct_name(module, ty)).ok_or_else(|| "a struct with no name".to_owned())
        }
        TypeInner::Pointer { base, space: AddressSpace::Function } => Ok(format!("&mut {}", rust_type(module, base)?)),
        TypeInner::Pointer { space, .. } => Err(format!("a pointer to {}", space_name(space))),
        ref other => Err(describe(other).to_owned()),
    }
}

/// An address space as WGSL writes it.
pub fn space_name(space: AddressSpace) -> &'static str {
    match space {
        AddressSpace::Function => "var<function>",
        AddressSpace::Private => "var<private>",
        AddressSpace::WorkGroup => "var<workgroup>",
        AddressSpace::Uniform => "var<uniform>",
        AddressSpace::Storage { access } if access.contains(naga::StorageAccess::STORE) => "var<storage, read_write>",
        AddressSpace::Storage { .. } => "var<storage, read>",
        AddressSpace::Handle => "a texture or sampler",
        AddressSpace::Immediate => "var<immediate>",
        _ => "a variable of another stage",
    }
}

/// The name of a struct in Rust.
pub fn struct_name(module: &Module, ty: Handle<Type>) -> String {
    crate::names::plain(module.types[ty].name.as_deref().unwrap_or("unnamed"))
}

/// Every struct that the host writes or reads: those in a uniform or storage variable, and what they hold.
pub fn host_shareable(module: &Module) -> HashSet<Handle<Type>> {
    let mut found = HashSet::new();
    let mut open: Vec<_> = module
        .global_variables
        .iter()
        .filter(|(_, global)| matches!(global.space, AddressSpace::Uniform | AddressSpace::Storage { .. }))
        .map(|(_, global)| global.ty)
        .collect();
    while let Some(ty) = open.pop() {
        match module.types[ty].inner {
            TypeInner::Array { base, .. } => open.push(base),
            TypeInner::Struct { ref members, .. } if found.insert(ty) => open.extend(members.iter().map(|m| m.ty)),
            _ => {}
        }
    }
    found
}

/// Size and alignment in bytes that Rust gives the type. Alignment is the largest of any CPU: glam's `Vec4`, `Mat2` and
/// `Mat4` are SIMD registers on most.
fn rust_layout(module: &Module, ty: Handle<Type>) -> Result<(u32, u32), Reason> {
    Ok(match module.types[ty].inner {
        TypeInner::Scalar(scalar) => (u32::from(scalar.width), u32::from(scalar.width)),
        TypeInner::Vector { size, scalar } => {
            let float = scalar.kind == ScalarKind::Float;
            (4 * size as u32, if float && size == VectorSize::Quad { 16 } else { 4 })
        }
        TypeInner::Matrix { columns, rows, .. } => {
            (4 * columns as u32 * rows as u32, if columns == VectorSize::Tri { 4 } else { 16 })
        }
        TypeInner::Array { base, size: ArraySize::Constant(count), .. } => {
            let (size, align) = rust_layout(module, base)?;
            (size.saturating_mul(count.get()), align)
        }
        TypeInner::Struct { ref members, span } => {
            let mut align = 1;
            for member in members {
                align = align.max(rust_layout(module, member.ty)?.1);
            }
            (span, align)
        }
        _ => return Err("a type that has no size".to_owned()),
    })
}

/// Whether Rust lays out the elements of an array as WGSL does; the error says what to do.
pub fn check_stride(module: &Module, ty: Handle<Type>) -> Result<(), Reason> {
    let TypeInner::Array { base, stride, .. } = module.types[ty].inner else { return Ok(()) };
    check_stride(module, base)?;
    let (size, _) = rust_layout(module, base)?;
    if size == stride {
        return Ok(());
    }
    Err(format!(
        "an array whose elements are {stride} bytes apart in WGSL and {size} in Rust: pad the element to {stride} bytes"
    ))
}

/// Whether Rust lays out a host-shareable struct as WGSL does, with no padding between or after the members; the error
/// names the member and says what to pad.
pub fn check_layout(module: &Module, ty: Handle<Type>) -> Result<(), Reason> {
    let TypeInner::Struct { ref members, span } = module.types[ty].inner else { return Ok(()) };
    let mut end: u32 = 0;
    let mut widest = 1;
    let mut previous = "the start";
    for member in members {
        let name = member.name.as_deref().unwrap_or("unnamed");
        check_stride(module, member.ty).map_err(|reason| format!("member `{name}`: {reason}"))?;
        let (size, align) = rust_layout(module, member.ty).map_err(|reason| format!("member `{name}`: {reason}"))?;
        if member.offset != end {
            let gap = member.offset.saturating_sub(end);
            return Err(format!(
                "member `{name}` is at byte {} in WGSL and {end} in Rust: put {gap} bytes of members (`pad: u32`) after \
                 `{previous}`",
                member.offset
            ));
        }
        if !end.is_multiple_of(align) {
            return Err(format!(
                "member `{name}` is at byte {end} in WGSL, where Rust wants a multiple of {align}: move it or pad before it"
            ));
        }
        let wgsl_size = module.types[member.ty].inner.size(module.to_ctx());
        if wgsl_size != size {
            return Err(format!(
                "member `{name}` has {wgsl_size} bytes in WGSL and {size} in Rust: write it as `vec4` columns or elements"
            ));
        }
        end = end.saturating_add(size);
        widest = widest.max(align);
        previous = name;
    }
    if end == span && span.is_multiple_of(widest) {
        return Ok(());
    }
    let span = span.next_multiple_of(widest);
    Err(format!(
        "the struct has {span} bytes and its members {end}: put {} bytes of members (`pad: u32`) after `{previous}`",
        span.saturating_sub(end)
    ))
}

/// Whether the type holds an array that is too long for Rust's `Default`.
pub fn needs_own_default(module: &Module, ty: Handle<Type>) -> bool {
    match module.types[ty].inner {
        TypeInner::Array { base, size: ArraySize::Constant(count), .. } => {
            count.get() > 32 || needs_own_default(module, base)
        }
        _ => false,
    }
}
