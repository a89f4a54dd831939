//! Optical constants of measured metals, by channel.

use glam::Vec3;
use kinora_scene::Spectrum;

/// Refractive index and extinction a channel.
pub fn constants(metal: Spectrum) -> [Vec3; 2] {
    let of = |n: [f32; 3], k: [f32; 3]| [Vec3::from_array(n), Vec3::from_array(k)];
    match metal {
        Spectrum::Ag => of([0.155, 0.117, 0.138], [4.828, 3.122, 2.147]),
        Spectrum::Cu => of([0.200, 0.924, 1.102], [3.912, 2.452, 2.142]),
        Spectrum::Au => of([0.143, 0.375, 1.442], [3.983, 2.386, 1.603]),
        _ => of([1.657, 0.880, 0.521], [9.224, 6.269, 4.837]),
    }
}

/// Reflectance at normal incidence.
pub fn facing(metal: Spectrum) -> Vec3 {
    let [n, k] = constants(metal);
    let k2 = k * k;
    let (less, more) = (n - Vec3::ONE, n + Vec3::ONE);
    (less * less + k2) / (more * more + k2)
}
