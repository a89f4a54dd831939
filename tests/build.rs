//! Translates the construct tests, and gives each an entry point for the GPU and a row of a table for the CPU; then once
//! more, with tests of their own, to lanes. Then compiles the grammar for editors.

use std::fmt::Write as _;
use std::path::Path;

const BINDINGS: &str = "
@group(0) @binding(3) var<storage, read> inputs: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> outputs: array<vec4<u32>>;
";

fn main() {
    constructs();
    tree_sitter();
}

/// The committed parser of `docs/editors/tree-sitter-kinora`, as an editor compiles it.
fn tree_sitter() {
    let folder = Path::new("../docs/editors/tree-sitter-kinora/src");
    let files = [folder.join("parser.c"), folder.join("scanner.c")];
    for file in &files {
        println!("cargo::rerun-if-changed={}", file.display());
    }
    cc::Build::new().include(folder).files(files).std("c11").opt_level(1).warnings(false).compile("tree_sitter_kinora");
}

fn constructs() {
    let path = "constructs/constructs.wgsl";
    println!("cargo::rerun-if-changed={path}");
    let wgsl = std::fs::read_to_string(path).expect("the constructs are there");
    let options = kinora_translate::Options { struct_name: "Kernel", native: &[], native_path: "", inline: &[] };
    let mut rust = match kinora_translate::translate(&wgsl, &options) {
        Ok(output) => output.rust,
        Err(error) => panic!("{path}: {error}"),
    };

    let mut entry = wgsl.clone() + BINDINGS;
    rust += "pub const CONSTRUCTS: &[crate::Construct] = &[\n";
    let lines: Vec<_> = wgsl.lines().collect();
    let pairs = lines.windows(2).filter_map(|pair| Some((pair[0], pair[1].strip_prefix("fn t_")?.split_once('(')?.0)));
    for (index, (comment, name)) in pairs.enumerate() {
        let comment = comment.strip_prefix("// ").unwrap_or_else(|| panic!("t_{name} has no line before it"));
        let (inputs, agreement) = comment.split_once(' ').unwrap_or_else(|| panic!("t_{name}: {comment}"));
        write!(
            entry,
            "
@compute @workgroup_size(64)
fn run_{name}(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {{
    let at = {index}u * groups.x * 64u + id.x;
    outputs[at] = t_{name}(inputs[at]);
}}
"
        )
        .expect("memory");
        let run = format!("|kernel, x| kernel.t_{name}(x)");
        writeln!(
            rust,
            "crate::Construct {{ name: {name:?}, inputs: {inputs:?}, agreement: {agreement:?}, run: {run} }},"
        )
        .expect("memory");
    }
    rust += "];\n";

    let out = std::env::var_os("OUT_DIR").expect("cargo names a folder");
    std::fs::write(Path::new(&out).join("constructs.rs"), rust).expect("the folder is writable");
    std::fs::write(Path::new(&out).join("constructs.wgsl"), entry).expect("the folder is writable");

    lanes(&wgsl, &options, Path::new(&out));
}

/// The constructs and `constructs/lanes.wgsl` as scalar code and on lanes; each text gains a function `run` that picks a
/// construct by its place in `CONSTRUCTS`, the names and kinds of inputs.
fn lanes(wgsl: &str, options: &kinora_translate::Options<'_>, out: &Path) {
    use kinora_translate::{LaneOptions, Registers, translate, translate_lanes};
    let path = "constructs/lanes.wgsl";
    println!("cargo::rerun-if-changed={path}");
    let wgsl = wgsl.to_owned() + &std::fs::read_to_string(path).expect("the lanes' constructs are there");
    let lines: Vec<_> = wgsl.lines().collect();
    let names: Vec<_> = lines
        .windows(2)
        .filter_map(|pair| Some((pair[0], pair[1].strip_prefix("fn ")?.split_once('(')?.0)))
        .filter_map(|(comment, name)| Some((comment.strip_prefix("// ")?.split_once(' ')?.0, name)))
        .filter(|(_, name)| name.starts_with("t_"))
        .collect();
    let roots: Vec<_> = names.iter().map(|&(_, name)| name).collect();
    let arms = |call: &dyn Fn(&str) -> String| -> String {
        let arm = |(i, name): (usize, &&str)| format!("{i} => {},\n", call(name));
        roots.iter().enumerate().map(arm).collect::<String>() + "_ => panic!(\"no construct\"),\n"
    };

    let mut rust = translate(&wgsl, options).unwrap_or_else(|error| panic!("{path}: {error}")).rust;
    let table: String = names.iter().map(|(inputs, name)| format!("({name:?}, {inputs:?}),\n")).collect();
    rust += &format!(
        "pub const CONSTRUCTS: &[(&str, &str)] = &[\n{table}];
pub fn run(kernel: &Kernel<'_>, index: usize, x: glam::UVec4) -> glam::UVec4 {{
match index {{
{}}}
}}
",
        arms(&|name| format!("kernel.{name}(x)"))
    );
    std::fs::write(out.join("lanes.rs"), rust).expect("the folder is writable");

    for (file, registers) in [("lanes_8.rs", Registers::Avx2), ("lanes_16.rs", Registers::Avx512)] {
        let lanes = LaneOptions { scalar: "crate::scalar", roots: &roots, registers };
        let output = translate_lanes(&wgsl, options, &lanes).unwrap_or_else(|error| panic!("{path}: {error}"));
        let run = format!(
            "pub const FEATURES: &str = {features:?};
#[target_feature(enable = {features:?})]
pub fn run(kernel: &Scalar<'_>, index: usize, active: u32, x: &[glam::UVec4]) -> Vec<glam::UVec4> {{
let (lanes, mask) = (Lanes(kernel), w::M::from_bits(active));
let x = w::V4::<w::U>::gather(|k| x[k]);
let y = match index {{
{}}};
(0..w::LANES).map(|k| y.get(k)).collect()
}}
",
            arms(&|name| format!("lanes.{name}(mask, x)")),
            features = registers.features(),
        );
        std::fs::write(out.join(file), output.rust + &run).expect("the folder is writable");
    }
}
