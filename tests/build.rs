//! Translates the construct tests, and gives each an entry point for the GPU and a row of a table for the CPU.

use std::fmt::Write as _;
use std::path::Path;

const BINDINGS: &str = "
@group(0) @binding(3) var<storage, read> inputs: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> outputs: array<vec4<u32>>;
";

fn main() {
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
}
