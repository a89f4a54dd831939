//! Every construct that the translator knows, on the CPU and on the GPU: `constructs/constructs.wgsl` says what each
//! takes and how well the two have to agree.

use generated::{Item, Kernel, Params};
use glam::{Mat4, UVec4, Vec2, Vec3, Vec4};
use wgpu::util::{BufferInitDescriptor, DeviceExt as _};

mod generated {
    #![allow(missing_docs, nonstandard_style, unused, clippy::all)]
    include!(concat!(env!("OUT_DIR"), "/constructs.rs"));
}

/// One function of the WGSL.
struct Construct {
    name: &'static str,
    inputs: &'static str,
    agreement: &'static str,
    run: fn(&Kernel<'_>, UVec4) -> UVec4,
}

/// A multiple of the 64 invocations of a workgroup.
const INPUTS_PER_CONSTRUCT: usize = 512;

const BITS: &[u32] = &[
    0,
    1,
    2,
    3,
    4,
    5,
    6,
    7,
    31,
    32,
    33,
    255,
    256,
    65535,
    65536,
    0x7fff_fffe,
    0x7fff_ffff,
    0x8000_0000,
    0x8000_0001,
    0xffff_fffe,
    0xffff_ffff,
];

const FLOATS: &[f32] = &[
    0.0,
    -0.0,
    0.5,
    -0.5,
    1.0,
    -1.0,
    1.5,
    -1.5,
    2.5,
    -2.5,
    0.499_999_97,
    -0.499_999_97,
    8_388_607.5,
    -8_388_607.5,
    8_388_609.0,
    16_777_216.0,
    -16_777_216.0,
    1_073_741_824.0,
    -1_073_741_824.0,
];

/// The generator of Steele, Lea and Flood's SplittableRandom.
fn random(state: &mut u64) -> u32 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z >> 32) as u32
}

/// One lane of an input: a third of the time one of the values where something turns over.
fn input(kind: &str, state: &mut u64) -> u32 {
    let edge = random(state).is_multiple_of(3);
    let bits = random(state);
    let mantissa = bits & 0x807f_ffff;
    let exponent = |low: i32, count: u32| ((127 + low) as u32 + (bits >> 8) % count) << 23;
    match kind {
        "bits" if edge => BITS[bits as usize % BITS.len()],
        "bits" => bits,
        "floats" if edge => FLOATS[bits as usize % FLOATS.len()].to_bits(),
        "floats" => mantissa & 0x8000_7fff | exponent(-30, 60) | (random(state) & 0x7f_8000),
        "near" => (mantissa & 0x7fff) | exponent(-4, 8) | (random(state) & 0x7f_8000),
        "unit" if edge => [0.0_f32, -0.0, 1.0, -1.0, 0.5, -0.25][bits as usize % 6].to_bits(),
        "unit" => (bits as f32 / u32::MAX as f32 * 2.5 - 1.25).to_bits(),
        other => panic!("no inputs are called {other}"),
    }
}

/// Distance in representable floats; zeros are one.
fn steps(a: f32, b: f32) -> u64 {
    let order = |x: f32| {
        let magnitude = i64::from(x.to_bits() & 0x7fff_ffff);
        if x.is_sign_negative() { -magnitude } else { magnitude }
    };
    order(a).abs_diff(order(b))
}

fn agree(agreement: &str, cpu: u32, gpu: u32) -> bool {
    let (a, b) = (f32::from_bits(cpu), f32::from_bits(gpu));
    match agreement.split_once(' ') {
        _ if cpu == gpu => true,
        None if agreement == "exact" => false,
        None if agreement == "value" => a == b,
        Some(("ulps", limit)) => steps(a, b) <= limit.parse::<u64>().expect("a number of steps"),
        Some(("within", limit)) => (a - b).abs() <= limit.parse::<f32>().expect("a difference"),
        _ => panic!("no agreement is called {agreement}"),
    }
}

/// What the bindings hold. Every float is small and exact.
struct Scene {
    params: Params,
    items: Vec<Item>,
    words: Vec<u32>,
}

impl Scene {
    fn new() -> Self {
        let mut next = 0.0;
        let mut float = || {
            next += 0.25;
            next
        };
        let mut matrix = || Mat4::from_cols_array(&std::array::from_fn(|_| float()));
        let params =
            Params { m: matrix(), v: UVec4::new(3, 1, 4, 1), k: Vec2::new(2.5, -7.0), count: 5, ..Params::default() };
        let items = (0..5)
            .map(|i| Item {
                a: Vec3::new(i as f32, -1.0, 0.5),
                id: 100 + i,
                m: matrix(),
                list: [i, 2 * i, 3 * i, 4 * i],
                v: UVec4::new(i, 7, 8, 9),
            })
            .collect();
        Self { params, items, words: (0..37).map(|i| i * i + 3).collect() }
    }
}

/// The outputs of every construct's entry point, one construct after the other.
fn on_gpu(device: &wgpu::Device, queue: &wgpu::Queue, scene: &Scene, inputs: &[UVec4]) -> Vec<UVec4> {
    let contents: [&[u8]; 4] = [
        bytemuck::bytes_of(&scene.params),
        bytemuck::cast_slice(&scene.items),
        bytemuck::cast_slice(&scene.words),
        bytemuck::cast_slice(inputs),
    ];
    let mut buffers = Vec::new();
    for (i, contents) in contents.into_iter().enumerate() {
        let usage = if i == 0 { wgpu::BufferUsages::UNIFORM } else { wgpu::BufferUsages::STORAGE };
        buffers.push(device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage }));
    }
    let size = size_of_val(inputs) as u64;
    let buffer =
        |usage| device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false });
    buffers.push(buffer(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC));
    let read = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);

    let layout_entry = |binding| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: match binding {
                0 => wgpu::BufferBindingType::Uniform,
                _ => wgpu::BufferBindingType::Storage { read_only: binding != 4 },
            },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let bindings: Vec<_> = (0..5).map(layout_entry).collect();
    let group_layout =
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &bindings });
    let entries: Vec<_> = buffers
        .iter()
        .zip(0..)
        .map(|(buffer, binding)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
        .collect();
    let group =
        device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &group_layout, entries: &entries });

    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        bind_group_layouts: &[Some(&group_layout)],
        ..Default::default()
    });
    let source = include_str!(concat!(env!("OUT_DIR"), "/constructs.wgsl"));
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    for construct in generated::CONSTRUCTS {
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(construct.name),
            layout: Some(&layout),
            module: &module,
            entry_point: Some(&format!("run_{}", construct.name)),
            compilation_options: Default::default(),
            cache: None,
        });
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(INPUTS_PER_CONSTRUCT as u32 / 64, 1, 1);
    }
    encoder.copy_buffer_to_buffer(&buffers[4], 0, &read, 0, size);
    queue.submit([encoder.finish()]);
    read.slice(..).map_async(wgpu::MapMode::Read, |result| result.expect("the outputs can be read"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("the GPU answers");
    let view = read.slice(..).get_mapped_range().expect("the outputs are mapped");
    bytemuck::cast_slice(&view).to_vec()
}

#[test]
fn cpu_and_gpu_agree_on_every_construct() {
    let scene = Scene::new();
    let kernel = Kernel { params: &scene.params, items: &scene.items, words: &scene.words };
    let constructs = generated::CONSTRUCTS;
    assert!(constructs.len() > 80, "only {} constructs were found", constructs.len());

    let mut inputs = Vec::new();
    for (seed, construct) in constructs.iter().enumerate() {
        let mut state = seed as u64;
        let mut lane = || input(construct.inputs, &mut state);
        inputs.extend((0..INPUTS_PER_CONSTRUCT).map(|_| UVec4::new(lane(), lane(), lane(), lane())));
    }
    let each = || constructs.iter().zip(inputs.chunks_exact(INPUTS_PER_CONSTRUCT));
    let cpu: Vec<_> =
        each().flat_map(|(construct, inputs)| inputs.iter().map(|&x| (construct.run)(&kernel, x))).collect();
    let Some((device, queue)) = kinora_tests::gpu() else { return };
    let gpu = on_gpu(&device, &queue, &scene, &inputs);

    let mut report = String::new();
    for (i, (construct, inputs)) in each().enumerate() {
        let at = i * INPUTS_PER_CONSTRUCT;
        let both = || cpu[at..].iter().zip(&gpu[at..]).zip(inputs);
        let wrong = |(cpu, gpu): (&UVec4, &UVec4)| (0..4).any(|lane| !agree(construct.agreement, cpu[lane], gpu[lane]));
        let count = both().filter(|(outputs, _)| wrong(*outputs)).count();
        if let Some(((cpu, gpu), x)) = both().find(|(outputs, _)| wrong(*outputs)) {
            let floats = |v: &UVec4| Vec4::from_array(v.to_array().map(f32::from_bits));
            report += &format!(
                "{} ({}): {count} of {INPUTS_PER_CONSTRUCT}, first\n  x   {x:x?} {:?}\n  cpu {cpu:x?} {:?}\n  gpu {gpu:x?} {:?}\n",
                construct.name,
                construct.agreement,
                floats(x),
                floats(cpu),
                floats(gpu)
            );
        }
    }
    assert!(report.is_empty(), "{report}");
}

/// The comparison itself can fail.
#[test]
fn agreement_is_judged() {
    let one = 1.0_f32.to_bits();
    for (agreement, a, b, expected) in [
        ("exact", 5, 5, true),
        ("exact", 0, 0x8000_0000, false),
        ("value", 0, 0x8000_0000, true),
        ("value", one, one + 1, false),
        ("ulps 2", one, one + 2, true),
        ("ulps 2", one, one + 3, false),
        ("ulps 2", 1, 0x8000_0001, true),
        ("within 0.5", one, 1.5_f32.to_bits(), true),
        ("within 0.5", one, 1.6_f32.to_bits(), false),
    ] {
        assert_eq!(agree(agreement, a, b), expected, "{agreement} {a:x} {b:x}");
    }
}
