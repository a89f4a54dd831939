//! Functions of a point that look random and depend on nothing else. The kernel has the same in f32, with the same
//! hashes: they must never change between versions.

/// PCG output hash (Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020).
fn pcg(v: u32) -> u32 {
    let state = v.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// A number in 0..1, 1 excluded, from the high 24 bits.
fn unit(hash: u32) -> f64 {
    f64::from(hash >> 8) / f64::from(1 << 24)
}

/// The cell of a coordinate, and the place in it, 0..1. Farther than 1e9 there is only the last cell.
fn cell_of(x: f64) -> (u32, f64) {
    let x = x.clamp(-1e9, 1e9);
    let low = x.floor();
    (low as i64 as u32, x - low)
}

/// Gradient noise, -1..1: 0 at whole coordinates, smooth between them. Perlin, "Improving Noise" (2002), with hashed
/// instead of tabulated gradients. NaN where a coordinate is not finite.
pub fn gradient_noise(at: [f64; 3]) -> f64 {
    if at.iter().any(|part| !part.is_finite()) {
        return f64::NAN;
    }
    let [(x, fx), (y, fy), (z, fz)] = at.map(cell_of);
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let corner = |dx: u32, dy: u32, dz: u32| {
        let hash = pcg(x.wrapping_add(dx).wrapping_add(pcg(y.wrapping_add(dy).wrapping_add(pcg(z.wrapping_add(dz))))));
        gradient(hash, [fx - f64::from(dx), fy - f64::from(dy), fz - f64::from(dz)])
    };
    let row = |dy, dz| mix(corner(0, dy, dz), corner(1, dy, dz), fade(fx));
    let sheet = |dz| mix(row(0, dz), row(1, dz), fade(fy));
    mix(sheet(0), sheet(1), fade(fz)).clamp(-1.0, 1.0)
}

/// The scalar product with one of the twelve edge directions of a cube, four of them twice.
fn gradient(hash: u32, [x, y, z]: [f64; 3]) -> f64 {
    let h = hash >> 28;
    let u = if h < 8 { x } else { y };
    let v = match h {
        0..4 => y,
        12 | 14 => x,
        _ => z,
    };
    (if h & 1 == 0 { u } else { -u }) + if h & 2 == 0 { v } else { -v }
}

/// Cellular noise over the first `axes` coordinates, 1 to 3, the others being 0: every cell of the lattice has one point somewhere in it. The
/// distance to the nearest, at most 1, and a number in 0..1 that tells it from the others. Worley, "A Cellular Texture
/// Basis Function" (1996); at most 1, since beyond that a point two cells away may be nearer. NaN where a coordinate is
/// not finite.
pub fn cellular_noise(at: [f64; 3], axes: u8) -> [f64; 2] {
    if at.iter().any(|part| !part.is_finite()) {
        return [f64::NAN; 2];
    }
    let [(x, fx), (y, fy), (z, fz)] = at.map(cell_of);
    let around = |axis: u8| if axis < axes { -1..=1 } else { 0..=0 };
    let (mut nearest, mut found) = (f64::INFINITY, 0);
    for k in around(2) {
        for j in around(1) {
            for i in around(0) {
                let step = |cell: u32, by: i32| cell.wrapping_add(by as u32);
                let hash = pcg(step(x, i).wrapping_add(pcg(step(y, j).wrapping_add(pcg(step(z, k))))));
                let second = pcg(hash);
                let third = pcg(second);
                let dx = f64::from(i) + unit(hash) - fx;
                let dy = if axes > 1 { f64::from(j) + unit(second) - fy } else { 0.0 };
                let dz = if axes > 2 { f64::from(k) + unit(third) - fz } else { 0.0 };
                let distance = dx * dx + dy * dy + dz * dz;
                if distance < nearest {
                    (nearest, found) = (distance, third);
                }
            }
        }
    }
    [nearest.sqrt().min(1.0), unit(pcg(found))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_zero_at_lattice_points_and_smooth() {
        assert_eq!(gradient_noise([3.0, -2.0, 7.0]), 0.0);
        let mut largest: f64 = 0.0;
        for i in 0..1000 {
            let x = f64::from(i) * 0.0317;
            let step = gradient_noise([x, 0.3, 0.7]) - gradient_noise([x + 1e-4, 0.3, 0.7]);
            assert!(step.abs() < 1e-3, "{x}");
            largest = largest.max(gradient_noise([x, 0.3, 0.7]).abs());
        }
        assert!(largest > 0.3 && largest <= 1.0, "{largest}");
        assert!(gradient_noise([f64::NAN, 0.0, 0.0]).is_nan());
        assert!(gradient_noise([1e300, 0.5, 0.5]).is_finite());
    }

    #[test]
    fn cells_are_continuous_and_their_numbers_even() {
        let (mut sum, mut count) = (0.0, 0.0);
        for i in 0..2000 {
            let x = f64::from(i) * 0.0137;
            for axes in 1..=3 {
                let part = |axis: u8, part: f64| if axis < axes { part } else { 0.0 };
                let at = |x: f64| cellular_noise([x, part(1, 1.3 * x), part(2, 0.4 - x)], axes)[0];
                assert!((at(x) - at(x + 1e-4)).abs() < 3e-4, "{x} {axes}");
                assert!((0.0..=1.0).contains(&at(x)));
            }
            sum += cellular_noise([x * 31.0, x * 17.0, 0.5], 3)[1];
            count += 1.0;
        }
        assert!((sum / count - 0.5_f64).abs() < 0.02, "{}", sum / count);
        // The point of a cell is at distance 0 from itself.
        let hash = pcg(4_u32.wrapping_add(pcg(0_u32.wrapping_add(pcg(0)))));
        assert!(cellular_noise([4.0 + unit(hash), 0.7, 0.2], 1)[0] < 1e-12);
    }

    #[test]
    fn what_is_written_down_stays() {
        // Written down once: a change changes every scene that was ever made.
        let noise = gradient_noise([0.3, 1.7, -2.2]);
        let [distance, id] = cellular_noise([0.3, 1.7, -2.2], 3);
        assert_eq!(
            [noise, distance, id].map(|x| (x * 1e6).round()),
            [13866.0, 414102.0, 511415.0],
            "{noise} {distance} {id}"
        );
    }
}
