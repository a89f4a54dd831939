//! Joins the shaders, checks them with naga and writes them twice: as one WGSL text and as Rust.

use std::{env, fs, path::Path};

use kinora_translate::{LaneOptions, Options, Registers, translate, translate_lanes, validate};

/// In the order of reading; WGSL itself does not mind.
const SHADERS: &[&str] = &[
    "math.wgsl",
    "scene.wgsl",
    "sampler.wgsl",
    "intersect.wgsl",
    "bvh.wgsl",
    "surface.wgsl",
    "texture.wgsl",
    "noise.wgsl",
    "tape.wgsl",
    "shapes.wgsl",
    "media.wgsl",
    "bsdf/bsdf.wgsl",
    "bsdf/ggx.wgsl",
    "bsdf/albedo.wgsl",
    "bsdf/diffuse.wgsl",
    "bsdf/metal.wgsl",
    "bsdf/coat.wgsl",
    "bsdf/sheen.wgsl",
    "bsdf/dielectric.wgsl",
    "sky.wgsl",
    "light.wgsl",
    "camera.wgsl",
    "path.wgsl",
    "parts.wgsl",
    "features.wgsl",
    "entry/render.wgsl",
];

/// What a path does, step by step.
const LANE_ROOTS: &[&str] = &[
    "path_start",
    "closest_hit",
    "path_shade",
    "shadow_share",
    "path_shadow",
    "path_light",
    "parts_shade",
    "parts_shadow",
    "parts_end",
];

fn main() {
    println!("cargo::rerun-if-changed=shaders");
    println!("cargo::rerun-if-changed=build.rs");
    let mut joined = String::new();
    for name in SHADERS {
        let text = fs::read_to_string(Path::new("shaders").join(name))
            .unwrap_or_else(|error| panic!("cannot read shaders/{name}: {error}"));
        joined += &format!("// --- {name}\n{text}\n");
    }
    let out = env::var_os("OUT_DIR").expect("cargo sets OUT_DIR");
    let out = Path::new(&out);
    fs::write(out.join("kernel.wgsl"), &joined).expect("cannot write kernel.wgsl");
    if let Err(error) = validate(&joined) {
        panic!("the shaders are not valid: see {}\n{error}", out.join("kernel.wgsl").display());
    }
    let options = Options {
        struct_name: "Kernel",
        native: &["bvh_walk", "bvh_closest", "bvh_any"],
        native_path: "crate::query",
        inline: &["hit_primitive", "hit_flat", "hit_sphere"],
    };
    let output = translate(&joined, &options).unwrap_or_else(|error| panic!("cannot translate the shaders: {error}"));
    fs::write(out.join("kernel.rs"), output.rust).expect("cannot write kernel.rs");
    for (name, registers) in [("avx2.rs", Registers::Avx2), ("avx512.rs", Registers::Avx512)] {
        let lanes = LaneOptions { scalar: "crate::generated", roots: LANE_ROOTS, registers };
        let output = translate_lanes(&joined, &options, &lanes)
            .unwrap_or_else(|error| panic!("cannot translate the shaders to lanes: {error}"));
        fs::write(out.join(name), output.rust).expect("cannot write the lanes");
    }
}
