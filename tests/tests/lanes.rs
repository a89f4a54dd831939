//! Every construct that the translator knows, on lanes: each lane gets the bits that the scalar code gives, whatever the
//! lanes beside it do. `constructs/lanes.wgsl` adds the control flow in which lanes part.
#![cfg(target_arch = "x86_64")]
// Registers are what unsafe code is for here: the generated code's, and the call of what the CPU was seen to have.
#![allow(unsafe_code)]

use glam::{Mat4, UVec4, Vec2, Vec3};
use scalar::{CONSTRUCTS, Item, Kernel, Params};

mod scalar {
    #![allow(missing_docs, nonstandard_style, unused, clippy::all)]
    include!(concat!(env!("OUT_DIR"), "/lanes.rs"));
}

mod eight {
    #![allow(missing_docs, nonstandard_style, unused, clippy::all)]
    include!(concat!(env!("OUT_DIR"), "/lanes_8.rs"));
}

mod sixteen {
    #![allow(missing_docs, nonstandard_style, unused, clippy::all)]
    include!(concat!(env!("OUT_DIR"), "/lanes_16.rs"));
}

/// The generator of Steele, Lea and Flood's SplittableRandom.
fn random(state: &mut u64) -> u32 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z >> 32) as u32
}

/// A part of an input: whole numbers where something turns over, small ones, floats of all kinds, any bits.
fn input(kind: &str, state: &mut u64) -> u32 {
    const EDGES: &[u32] =
        &[0, 1, 2, 31, 32, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, 0x7f80_0000, 0xff80_0000, 0x7fc0_0000];
    const FLOATS: &[f32] = &[0.0, -0.0, 0.5, -0.5, 1.5, -2.5, 2147483648.0, -2147483648.0, 4294967296.0, 1e30, -1e30];
    let bits = random(state);
    match (kind, random(state) % 4) {
        ("bits", 0) => EDGES[bits as usize % EDGES.len()],
        ("bits", 1) => bits % 64,
        ("bits", 2) => FLOATS[bits as usize % FLOATS.len()].to_bits(),
        ("bits", _) => bits,
        (_, 0) => FLOATS[bits as usize % FLOATS.len()].to_bits(),
        (_, 1) => bits,
        _ => (bits as f32 / u32::MAX as f32 * 4.0 - 2.0).to_bits(),
    }
}

/// Whether the parts are the same bits, or both no number: which of two of those an operation keeps is left open.
fn same(a: UVec4, b: UVec4) -> bool {
    let nan = |x: u32| f32::from_bits(x).is_nan();
    (0..4).all(|i| a[i] == b[i] || (nan(a[i]) && nan(b[i])))
}

/// A construct, by its place, in the lanes whose bits are set.
type Run = dyn Fn(&Kernel<'_>, usize, u32, &[UVec4]) -> Vec<UVec4>;

fn check(count: usize, run: &Run) {
    assert!(CONSTRUCTS.len() > 90, "only {} constructs were found", CONSTRUCTS.len());
    let mut state = 1;
    let mut float = || f32::from_bits(input("floats", &mut state)).clamp(-1e3, 1e3);
    let mut matrix = || Mat4::from_cols_array(&std::array::from_fn(|_| float()));
    let params =
        Params { m: matrix(), v: UVec4::new(3, 1, 4, 1), k: Vec2::new(2.5, -7.0), count: 5, ..Params::default() };
    let item = |i: u32| Item {
        a: Vec3::new(i as f32, -1.0, 0.5),
        id: 100 + i,
        m: Mat4::from_cols_array(&std::array::from_fn(|j| i as f32 - j as f32)),
        list: [i, 2 * i, 3 * i, 4 * i],
        v: UVec4::new(i, 7, 8, 9),
    };
    let items: Vec<_> = (0..5).map(item).collect();
    let words: Vec<u32> = (0..37).map(|i| i * i + 3).collect();
    let kernel = Kernel { params: &params, items: &items, words: &words };
    for (index, &(name, kind)) in CONSTRUCTS.iter().enumerate() {
        let mut state = index as u64;
        for turn in 0..200 {
            let x: Vec<_> =
                (0..count).map(|_| UVec4::from_array(std::array::from_fn(|_| input(kind, &mut state)))).collect();
            // All lanes, then any of them.
            let active = if turn % 2 == 0 { u32::MAX } else { random(&mut state) } & ((1 << count) - 1);
            let lanes = run(&kernel, index, active, &x);
            for k in (0..count).filter(|k| active >> k & 1 == 1) {
                let one = scalar::run(&kernel, index, x[k]);
                assert!(
                    same(one, lanes[k]),
                    "{name}({:x?}), lane {k} of {active:b}: {:x?}, not {one:x?}",
                    x[k],
                    lanes[k]
                );
            }
        }
    }
}

#[test]
fn eight_lanes_are_eight_scalars() {
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("bmi2") && is_x86_feature_detected!("lzcnt") {
        // SAFETY: the CPU has AVX2 and what came with it.
        check(8, &|kernel, index, active, x| unsafe { eight::run(kernel, index, active, x) });
    }
}

#[test]
fn sixteen_lanes_are_sixteen_scalars() {
    if is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
    {
        // SAFETY: the CPU has AVX-512.
        check(16, &|kernel, index, active, x| unsafe { sixteen::run(kernel, index, active, x) });
    }
}
