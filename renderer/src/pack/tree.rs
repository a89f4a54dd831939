//! The tree by which one of many lights is chosen: pairs of children as words, depth first.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DQuat, DVec3};
use kinora_kernel::generated::{TREE_CHILD, TREE_LEVELS, TREE_LIGHT, TREE_TWO_SIDED};
use rayon::join;

use super::geometry::encode_normal;
use super::lights::{Light, Reach};

/// From so many lights on a tree chooses; below it, power does, which takes no time.
pub const TREE_FROM: usize = 6;

/// Words of a pair.
pub const PAIR: usize = 2 * TREE_CHILD as usize;
/// Bins along an axis.
const BINS: usize = 12;
/// Below this the halves are not worth two threads.
const ALONE: usize = 4096;

#[derive(Clone, Copy)]
struct Item {
    light: u32,
    way: u32,
    reach: Reach,
}

/// Appends the tree of `lights` to `words` and writes into each light its way down; gives the first word. Two lights or
/// more, of which all that have no power are left out.
pub fn build(lights: &mut [Light], words: &mut Vec<u32>) -> Option<u32> {
    let shining = lights.iter().enumerate().filter(|(_, light)| light.reach.intensity > 0.0);
    let mut items: Vec<Item> = shining.map(|(i, light)| Item { light: i as u32, way: 0, reach: light.reach }).collect();
    if items.len() < 2 {
        return None;
    }
    let first = words.len();
    words.resize(first + PAIR * (items.len() - 1), 0);
    subtree(&mut items, &mut words[first..], first, 0, 0);
    // A light that is never chosen has a way that leads to another; its chance is 0 all the same.
    for item in &items {
        lights[item.light as usize].packed.kind.w = item.way;
    }
    Some(first as u32)
}

// Fills `words`, the first of which is word `at` of all, with the pairs of `items`; gives what the whole is as a child.
fn subtree(items: &mut [Item], words: &mut [u32], at: usize, level: u32, way: u32) -> (Reach, u32) {
    if let [item] = items {
        item.way = way;
        return (item.reach, TREE_LIGHT | item.light);
    }
    let middle = split(items, level);
    let (left, right) = items.split_at_mut(middle);
    let (pair, rest) = words.split_at_mut(PAIR);
    let left_words = PAIR * (left.len() - 1);
    let (first_words, second_words) = rest.split_at_mut(left_words);
    let first_at = at + PAIR;
    let large = left.len() + right.len() > ALONE;
    let second_way = way | 1 << level;
    let first = |items: &mut [Item], words: &mut [u32]| subtree(items, words, first_at, level + 1, way);
    let second =
        |items: &mut [Item], words: &mut [u32]| subtree(items, words, first_at + left_words, level + 1, second_way);
    let (a, b) = match large {
        true => join(|| first(left, first_words), || second(right, second_words)),
        false => (first(left, first_words), second(right, second_words)),
    };
    let (low, high) = pair.split_at_mut(PAIR / 2);
    write(a, low);
    write(b, high);
    (union(a.0, b.0), at as u32)
}

// A child as words. Rounding may only widen it.
fn write((reach, child): (Reach, u32), words: &mut [u32]) {
    let centre = (reach.low + reach.high) * 0.5;
    let far = centre.abs().max_element() * 1e-6;
    let radius = 0.5 * (reach.high - reach.low).length() * 1.0001 + far + 1e-18;
    let [x, y, z] = centre.as_vec3().to_array();
    let floats = [x, y, z, radius as f32, reach.intensity as f32];
    for (word, value) in words.iter_mut().zip(floats) {
        *word = value.to_bits();
    }
    // The axis is rounded by up to 1e-4 rad.
    let cosine = |angle: f64| {
        let code = ((angle + 5e-4).min(PI).cos() * 32767.0).floor().max(-32767.0);
        u32::from(code as i16 as u16)
    };
    words[5] = encode_normal(reach.axis.as_vec3());
    words[6] = cosine(reach.spread) | cosine(reach.sent) << 16;
    words[7] = child | if reach.two_sided { TREE_TWO_SIDED } else { 0 };
}

fn union(a: Reach, b: Reach) -> Reach {
    let (axis, spread) = cone_union(a, b);
    Reach {
        low: a.low.min(b.low),
        high: a.high.max(b.high),
        intensity: a.intensity + b.intensity,
        axis,
        spread,
        sent: a.sent.max(b.sent),
        two_sided: a.two_sided || b.two_sided,
    }
}

// The narrowest cone about two (Conty Estevez and Kulla 2018, algorithm 1).
fn cone_union(a: Reach, b: Reach) -> (DVec3, f64) {
    let (wide, narrow) = if a.spread >= b.spread { (a, b) } else { (b, a) };
    if wide.spread >= PI {
        return (wide.axis, PI);
    }
    let mut other = narrow.axis;
    if (a.two_sided || b.two_sided) && other.dot(wide.axis) < 0.0 {
        other = -other;
    }
    let between = wide.axis.angle_between(other);
    if between + narrow.spread <= wide.spread {
        return (wide.axis, wide.spread);
    }
    let spread = 0.5 * (wide.spread + between + narrow.spread);
    let across = wide.axis.cross(other);
    match across.try_normalize() {
        Some(across) if spread < PI => (DQuat::from_axis_angle(across, spread - wide.spread) * wide.axis, spread),
        _ => (wide.axis, PI),
    }
}

// Intensity, times how far its normals spread, times its size: what a split is to make small.
fn cost(reach: &Reach) -> f64 {
    let (spread, sent) = (reach.spread, reach.sent);
    let whole = (spread + sent).min(PI);
    let (sin, cos) = spread.sin_cos();
    let directions = 2.0 * PI * (1.0 - cos)
        + FRAC_PI_2 * (2.0 * whole * sin - (spread - 2.0 * whole).cos() - 2.0 * spread * sin + cos);
    reach.intensity * directions * (reach.high - reach.low).length_squared()
}

fn centre(item: &Item) -> DVec3 {
    (item.reach.low + item.reach.high) * 0.5
}

// Orders the items so that those before the index that is given are one child's.
fn split(items: &mut [Item], level: u32) -> usize {
    let half = items.len() / 2;
    let low = items.iter().fold(DVec3::INFINITY, |low, item| low.min(centre(item)));
    let high = items.iter().fold(DVec3::NEG_INFINITY, |high, item| high.max(centre(item)));
    let size = high - low;
    let widest = size.max_position();
    if size[widest] <= 0.0 {
        return half;
    }
    let by_half = |items: &mut [Item]| {
        items.select_nth_unstable_by(half, |a, b| {
            centre(a)[widest].total_cmp(&centre(b)[widest]).then(a.light.cmp(&b.light))
        });
        half
    };
    // So many levels more are needed at least.
    let needed = usize::BITS - (items.len() - 1).leading_zeros();
    if level + needed + 1 >= TREE_LEVELS || items.len() == 2 {
        return by_half(items);
    }
    let mut best = (f64::INFINITY, 0, 0);
    for axis in 0..3 {
        if size[axis] <= 0.0 {
            continue;
        }
        let mut bins: [(Option<Reach>, usize); BINS] = [(None, 0); BINS];
        for item in items.iter() {
            let bin = &mut bins[bin_of(item, axis, low, size)];
            bin.0 = Some(bin.0.map_or(item.reach, |sum| union(sum, item.reach)));
            bin.1 += 1;
        }
        let mut after = [0.0; BINS];
        let mut sum: Option<Reach> = None;
        for i in (1..BINS).rev() {
            sum = merged(sum, bins[i].0);
            after[i] = sum.map_or(f64::INFINITY, |sum| cost(&sum));
        }
        let longness = size[widest] / size[axis];
        let mut sum: Option<Reach> = None;
        for i in 1..BINS {
            sum = merged(sum, bins[i - 1].0);
            let whole = (sum.map_or(f64::INFINITY, |sum| cost(&sum)) + after[i]) * longness;
            if whole < best.0 {
                best = (whole, axis, i);
            }
        }
    }
    let (_, axis, at) = best;
    if at == 0 {
        return by_half(items);
    }
    // Stable, so that the tree is the same however it is built.
    items.sort_by_key(|item| bin_of(item, axis, low, size) >= at);
    let middle = items.partition_point(|item| bin_of(item, axis, low, size) < at);
    if middle == 0 || middle == items.len() { by_half(items) } else { middle }
}

fn merged(a: Option<Reach>, b: Option<Reach>) -> Option<Reach> {
    match (a, b) {
        (Some(a), Some(b)) => Some(union(a, b)),
        (a, b) => a.or(b),
    }
}

fn bin_of(item: &Item, axis: usize, low: DVec3, size: DVec3) -> usize {
    let share = (centre(item)[axis] - low[axis]) / size[axis];
    ((share * BINS as f64) as usize).min(BINS - 1)
}
