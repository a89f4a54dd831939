//! What is refused, and with which words; how structs, constants and bindings are written. That the translated functions
//! compute the right thing is tested where there is a GPU to compare with, by the construct tests of the workspace.

use kinora_translate::{Options, translate, validate};

const OPTIONS: Options<'_> =
    Options { struct_name: "Kernel", native: &["native"], native_path: "crate::query", inline: &[] };
const NATIVE: &str = "fn native(x: f32) -> f32 { return x; }\n";

/// Each part has to be found in the message of the error, or in the Rust where there is none.
fn check(wgsl: &str, parts: &[&str]) {
    let text = match translate(&(NATIVE.to_owned() + wgsl), &OPTIONS) {
        Ok(output) => output.rust,
        Err(error) => format!("error: {error}"),
    };
    let shown = text.split("pub mod wgsl").next().unwrap_or_default();
    for part in parts {
        assert!(text.contains(part), "no {part:?} in the translation of\n{wgsl}\n{shown}");
    }
}

fn refused(wgsl: &str, parts: &[&str]) {
    check(wgsl, &[&["error: "], parts].concat());
}

#[test]
fn invalid_wgsl_is_refused_with_its_line() {
    refused("fn f() { let a = b; }", &["no definition in scope for identifier: `b`", "wgsl:2:18"]);
    refused("fn f(x: f32) -> u32 { return x; }", &["'f' is invalid", "wgsl:2"]);
    assert!(validate("fn f() -> f32 { return 1.0; }").is_ok());
    assert!(validate("fn f(").is_err());
}

#[test]
fn what_differs_between_machines_is_refused() {
    for name in [
        "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "exp", "exp2",
        "log", "log2",
    ] {
        let message = format!("`f`: no translation to Rust for `{name}`: write it with math.wgsl");
        refused(&format!("fn f(x: f32) -> f32 {{ return {name}(x); }}"), &[&message]);
    }
    refused(
        "fn f(x: f32) -> f32 { return pow(x, x); }",
        &["`f`: no translation to Rust for `pow`: write it with math.wgsl"],
    );
    refused(
        "fn f(x: f32) -> f32 { return atan2(x, x); }",
        &["`f`: no translation to Rust for `atan2`: write it with math.wgsl"],
    );
}

#[test]
fn what_has_no_translation_is_named() {
    let texture = "@group(0) @binding(0) var t: texture_2d<f32>;\n";
    let sampler = "@group(0) @binding(1) var s: sampler;\n";
    let counter = "@group(0) @binding(0) var<storage, read_write> n: atomic<u32>;\n";
    for (wgsl, parts) in [
        (
            format!("{texture}fn f() -> vec4<f32> {{ return textureLoad(t, vec2(0), 0); }}"),
            ["`f`: no translation to Rust for `t`,", "texture"],
        ),
        (
            format!("{texture}{sampler}fn f() -> vec4<f32> {{ return textureSampleLevel(t, s, vec2(0.0), 0.0); }}"),
            ["`f`:", "texture"],
        ),
        (
            format!("{counter}fn f() -> u32 {{ return atomicAdd(&n, 1u); }}"),
            ["`f`: no translation to Rust for `n`,", "read_write"],
        ),
        (
            "var<private> p: u32;\nfn f() -> u32 { return p; }".into(),
            ["`f`: no translation to Rust for `p`,", "var<private>"],
        ),
        (
            "var<workgroup> w: u32;\nfn f() -> u32 { return w; }".into(),
            ["`f`: no translation to Rust for `w`,", "var<workgroup>"],
        ),
        (
            "@group(0) @binding(0) var<storage, read_write> o: array<u32>;\nfn f() { o[0] = 1u; }".into(),
            ["`f`: no translation to Rust for `o`,", "var<storage, read_write>"],
        ),
        (
            "fn g(p: ptr<function, u32>) {}\nfn f() { var a: array<u32, 2>; g(&a[1]); }".into(),
            ["`f`:", "a pointer to a part of a variable"],
        ),
        ("fn f() { workgroupBarrier(); }".into(), ["`f`:", "a barrier"]),
        ("fn f() { storageBarrier(); }".into(), ["`f`:", "a barrier"]),
        ("fn f() { discard; }".into(), ["`f`:", "`discard`"]),
        ("fn f(x: f32) -> f32 { return dpdx(x); }".into(), ["`f`:", "a derivative"]),
        ("override n: u32 = 1u;\nfn f() -> u32 { return n; }".into(), ["`n`:", "an override"]),
        ("fn f(x: f32) -> f32 { return modf(x).fract; }".into(), ["`f`:", "`modf`"]),
        ("fn f(x: f32) -> f32 { return ldexp(x, 2); }".into(), ["`f`:", "`ldexp`"]),
        ("fn f(x: u32) -> u32 { return dot4U8Packed(x, x); }".into(), ["`f`:", "`dot4U8Packed`"]),
        ("fn f(m: mat2x3<f32>) -> vec3<f32> { return m[0]; }".into(), ["`f`:", "not square (mat2x3)"]),
        ("enable f16;\nfn f(x: f16) -> f16 { return x; }".into(), ["f16", "wgsl:"]),
        ("fn f(x: i64) -> i64 { return x; }".into(), ["i64", ""]),
        ("fn f(x: f64) -> f64 { return x; }".into(), ["f64", ""]),
        ("struct Kernel { x: u32 }\nfn f(k: Kernel) {}".into(), ["`Kernel`:", "name is taken"]),
        (
            "struct S { n: u32, x: array<u32> }\n@group(0) @binding(0) var<storage, read> s: S;\n\
             fn f() -> u32 { return s.x[0]; }"
                .into(),
            ["`s`:", "run-time size"],
        ),
    ] {
        refused(&wgsl, &parts.map(|part| if part.is_empty() { "error" } else { part }));
    }
}

#[test]
fn a_native_function_that_is_not_declared_is_refused() {
    let options = Options { native: &["missing"], ..OPTIONS };
    let error = translate("fn f() {}", &options).err().map(|error| error.to_string());
    assert!(error.is_some_and(|error| {
        error.contains("`missing`: no translation to Rust for a native function that the WGSL does not declare")
    }));
}

#[test]
fn a_layout_that_rust_does_not_share_is_refused() {
    let bind = |body: &str| format!("struct S {{ {body} }}\n@group(0) @binding(0) var<storage, read> s: array<S>;");
    for (members, parts) in [
        ("a: vec2<f32>, b: f32", ["`S`: the struct has 16 bytes and its members 12", "put 4 bytes", "after `b`"]),
        ("a: u32, b: vec3<f32>", ["member `b` is at byte 16 in WGSL and 4 in Rust", "put 12 bytes", "after `a`"]),
        ("a: vec4<f32>, b: f32", ["the struct has 32 bytes and its members 20", "put 12 bytes", "after `b`"]),
        ("a: vec3<f32>", ["the struct has 16 bytes and its members 12", "put 4 bytes", "after `a`"]),
        ("a: mat3x3<f32>", ["member `a` has 48 bytes in WGSL and 36 in Rust", "vec4", "columns"]),
        ("a: array<vec3<f32>, 2>", ["member `a`: ", "16 bytes apart in WGSL and 12 in Rust", "pad the element"]),
        ("a: vec2<f32>, b: mat2x2<f32>", ["member `b` is at byte 8", "multiple of 16", "move it or pad"]),
    ] {
        refused(&bind(members), &parts);
    }
    refused(
        "@group(0) @binding(0) var<storage, read> s: array<vec3<f32>>;\nfn f() -> f32 { return s[0].x; }",
        &["`s`: an array whose elements are 16 bytes apart in WGSL and 12 in Rust"],
    );
}

#[test]
fn structs_are_shared_or_private() {
    let shared = "struct S { a: vec3<f32>, b: u32, m: mat4x4<f32> }\n@group(0) @binding(0) var<uniform> s: S;\n";
    check(
        shared,
        &[
            "#[derive(Clone, Copy, Debug, PartialEq, Default, bytemuck::Pod, bytemuck::Zeroable)]\npub struct S {",
            "pub a: glam::Vec3,",
            "pub m: glam::Mat4,",
            "assert!(core::mem::size_of::<S>() == 80);",
            "assert!(core::mem::offset_of!(S, m) == 16);",
        ],
    );
    // No binding holds it: Rust may lay it out as it likes, and the long array has no `Default` of its own.
    check(
        "struct P { a: vec2<f32>, b: bool, c: array<u32, 33> }\nfn f(p: P) {}",
        &["#[derive(Clone, Copy, Debug, PartialEq)]\npub struct P {", "impl Default for P {", "c: [0u32; 33]"],
    );
}

#[test]
fn bindings_are_fields_where_a_translated_function_uses_them() {
    let wgsl = "@group(0) @binding(0) var<storage, read> a: array<u32>;
        @group(0) @binding(1) var<uniform> b: vec4<u32>;
        @group(0) @binding(2) var<storage, read> unused: array<u32>;
        @group(0) @binding(3) var<storage, read_write> film: array<vec4<f32>>;
        fn f(i: u32) -> u32 { return a[i] + b.x; }
        @compute @workgroup_size(1) fn main() { film[0] = vec4(f32(f(unused[0]))); }";
    check(
        wgsl,
        &[
            "pub struct Kernel<'a> {\n    pub a: &'a [u32],\n    pub b: &'a glam::UVec4,\n    pub native: &'a crate::query::Native<'a>,\n}",
        ],
    );
    let without = Options { native: &[], ..OPTIONS };
    let rust = translate("fn f() {}", &without).map(|output| output.rust).unwrap_or_default();
    assert!(rust.contains("pub unbound: core::marker::PhantomData<&'a ()>,\n}"), "{rust}");
}

#[test]
fn constants_keep_their_type() {
    check(
        "const A: f32 = 1.0 / 3.0;\nconst B = vec3<u32>(1u, 2u, 3u);\nconst C = array<f32, 2>(1.0, -2.5);\nconst D: i32 = -5;",
        &[
            "pub const A: f32 = 0.33333334_f32;",
            "pub const B: glam::UVec3 = glam::UVec3::new(1u32, 2u32, 3u32);",
            "pub static C: [f32; 2] = [1.0_f32, (-2.5_f32)];",
            "pub const D: i32 = (-5i32);",
        ],
    );
}

#[test]
fn functions_are_methods() {
    check(
        "fn f(a: f32, b: ptr<function, u32>) -> f32 { *b = 1u; return a; }",
        &["pub fn f(&self, a: f32, b: &mut u32) -> f32 {", "*b = 1u32;"],
    );
    check("fn f(dyn: f32) -> f32 { return dyn; }", &["pub fn f(&self, dyn_: f32) -> f32 {"]);
    check(
        "fn f() -> f32 { return native(1.0) + g(); }\nfn g() -> f32 { return 2.0; }",
        &["crate::query::native(self, 1.0_f32)", "self.g()"],
    );
    // A storage load takes the member alone, and a table of a function is indexed where it lies.
    check(
        "struct S { a: vec4<f32>, b: vec4<f32> }\n@group(0) @binding(0) var<storage, read> s: array<S>;
        fn f(i: u32) -> f32 { let t = array<f32, 2>(0.5, 1.5); return s[i].b.y * t[i]; }",
        &["self.s[wgsl::index(i as usize, self.s.len())].b.y", "static t: [f32; 2] = [0.5_f32, 1.5_f32];"],
    );
}
