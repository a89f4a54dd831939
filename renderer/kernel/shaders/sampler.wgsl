// Random numbers without state: a number is a function of (pixel, sample, dimension, seed). Owen-scrambled Sobol points
// in padded pairs (Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020): each pair of dimensions is the
// first two of Sobol's, in an order shuffled and with values scrambled by hashes of their own.

/// Sobol points, or independent ones (`Params::sampler`).
const SAMPLER_SOBOL: u32 = 0u;
const SAMPLER_RANDOM: u32 = 1u;

// The dimensions of a path: the camera's, then DIM_STRIDE a bounce. `random_2d` and `random_1d` number theirs apart.
const DIM_FILTER: u32 = 0u;
const DIM_LENS: u32 = 1u;
const DIM_BOUNCE: u32 = 2u;
const DIM_STRIDE: u32 = 3u;
const DIM_BSDF: u32 = 0u;
const DIM_LIGHT: u32 = 1u;
const DIM_CHOICE: u32 = 2u;
/// Of `random_1d`.
const DIM_ROULETTE: u32 = 0u;
const DIM_TECHNIQUE: u32 = 1u;
const DIM_CUTOUT: u32 = 0x40000000u;

/// What the numbers of one sample of one pixel are made from.
struct SampleKey {
    /// A hash of pixel and seed.
    pixel: u32,
    /// The sample's index, bits reversed.
    index_reversed: u32,
}

/// PCG output hash (Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020).
fn pcg(v: u32) -> u32 {
    let state = v * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

/// A number in 0 <= u < 1 from the high 24 bits: rounding all 32 could give 1.
fn unit_float(x: u32) -> f32 {
    return f32(x >> 8u) * 5.9604644775390625e-8;
}

// Nested uniform scrambling of bits that are already reversed (Laine and Karras 2011, constants by Vegdahl 2021).
fn owen_hash(x: u32, seed: u32) -> u32 {
    var n = x;
    n ^= n * 0x3d20adeau;
    n += seed;
    n *= (seed >> 16u) | 1u;
    n ^= n * 0x05526c56u;
    n ^= n * 0x53a22864u;
    return n;
}

// Bits of the second Sobol dimension, reversed: its matrix is Pascal's triangle mod 2, a sum over supersets.
fn sobol_second_reversed(index: u32) -> u32 {
    var v = index;
    v ^= v >> 16u;
    v ^= (v >> 8u) & 0x00ff00ffu;
    v ^= (v >> 4u) & 0x0f0f0f0fu;
    v ^= (v >> 2u) & 0x33333333u;
    v ^= (v >> 1u) & 0x55555555u;
    return v;
}

/// Point `index` of the 2-D Sobol sequence with Owen scrambling by `seeds`, as integers: divide by 2³².
fn owen_sobol(index: u32, seeds: vec2<u32>) -> vec2<u32> {
    return vec2<u32>(
        reverseBits(owen_hash(index, seeds.x)),
        reverseBits(owen_hash(sobol_second_reversed(index), seeds.y)),
    );
}

fn sample_key(pixel: vec2<u32>, sample: u32) -> SampleKey {
    return SampleKey(pcg(pixel.x + pcg(pixel.y + pcg(params.seed))), reverseBits(sample));
}

/// Two numbers, each in 0 <= u < 1.
fn random_2d(key: SampleKey, dimension: u32) -> vec2<f32> {
    let h = pcg(key.pixel ^ (dimension * 0x9e3779b9u));
    // One good hash, spread over three seeds by odd factors (those of Wellons' lowbias32 and triple32).
    let seeds = vec2<u32>((h ^ (h >> 15u)) * 0x2c1b3c6du, (h ^ (h >> 17u)) * 0xed5ad4bbu);
    if params.sampler == SAMPLER_RANDOM {
        return vec2<f32>(
            unit_float(pcg(key.index_reversed + seeds.x)),
            unit_float(pcg(key.index_reversed + seeds.y)),
        );
    }
    let x = owen_sobol(reverseBits(owen_hash(key.index_reversed, h)), seeds);
    return vec2<f32>(unit_float(x.x), unit_float(x.y));
}

/// One number in 0 <= u < 1, independent of all others.
fn random_1d(key: SampleKey, dimension: u32) -> f32 {
    return unit_float(pcg(key.pixel ^ pcg(key.index_reversed + dimension)));
}

/// Concentric map of the unit square to the unit disc (Shirley and Chiu 1997).
fn square_to_disc(u: vec2<f32>) -> vec2<f32> {
    let p = 2.0 * u - vec2<f32>(1.0);
    // Without a branch: it would go either way half of the time.
    let wide = abs(p.x) > abs(p.y);
    let radius = select(p.y, p.x, wide);
    let slope = select(p.x, p.y, wide) / select(radius, 1.0, radius == 0.0);
    // An eighth of a turn a unit of the slope.
    return radius * cos_sin_turn(select(0.25 - 0.125 * slope, 0.125 * slope, wide));
}

/// Cosine-weighted direction about +z; its pdf is z / π.
fn square_to_cosine(u: vec2<f32>) -> vec3<f32> {
    let d = square_to_disc(u);
    return vec3<f32>(d, sqrt(max(1e-12, 1.0 - d.x * d.x - d.y * d.y)));
}
