//! Many paths at once: the shading of [`crate::generated`] on the lanes of vector registers, and the schedule that keeps
//! the lanes full. Every lane gets the bits that [`Kernel::radiance`] would give, so that what a picture shows does not
//! depend on how many lanes there were.

use glam::{UVec2, Vec4};

use crate::generated::{Kernel, Parts};

/// How many paths advance together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// One: any CPU.
    One,
    /// Eight: x86-64 with AVX2.
    Eight,
    /// Sixteen: x86-64 with AVX-512.
    Sixteen,
}

impl Width {
    /// The widest that this CPU has.
    pub fn best() -> Self {
        [Self::Sixteen, Self::Eight].into_iter().find(|width| width.is_here()).unwrap_or(Self::One)
    }

    /// Whether this CPU has so many lanes.
    pub fn is_here(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        return match self {
            Self::One => true,
            Self::Eight => has_avx2(),
            Self::Sixteen => has_avx2() && has_avx512(),
        };
        #[cfg(not(target_arch = "x86_64"))]
        return self == Self::One;
    }
}

#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("popcnt")
}

#[cfg(target_arch = "x86_64")]
fn has_avx512() -> bool {
    is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
}

/// Which sample of which pixel, by the place of its result.
pub type PixelSample<'a> = &'a dyn Fn(usize) -> (UVec2, u32);

/// Fills `light` with [`Kernel::radiance`] of `pixel_sample(i)` for each index `i`. Lanes that the CPU does not have are
/// replaced by one.
pub fn radiance(kernel: &Kernel<'_>, width: Width, pixel_sample: PixelSample<'_>, light: &mut [Vec4]) {
    #[cfg(target_arch = "x86_64")]
    match width {
        Width::Sixteen if width.is_here() => return sixteen::radiance(kernel, pixel_sample, light),
        Width::Eight if width.is_here() => return eight::radiance(kernel, pixel_sample, light),
        _ => {}
    }
    for (i, light) in light.iter_mut().enumerate() {
        let (pixel, sample) = pixel_sample(i);
        *light = kernel.radiance(pixel, sample);
    }
}

/// As [`radiance`], but [`Kernel::radiance_parts`].
pub fn radiance_parts(kernel: &Kernel<'_>, width: Width, pixel_sample: PixelSample<'_>, parts: &mut [Parts]) {
    #[cfg(target_arch = "x86_64")]
    match width {
        Width::Sixteen if width.is_here() => return sixteen::radiance_parts(kernel, pixel_sample, parts),
        Width::Eight if width.is_here() => return eight::radiance_parts(kernel, pixel_sample, parts),
        _ => {}
    }
    for (i, parts) in parts.iter_mut().enumerate() {
        let (pixel, sample) = pixel_sample(i);
        *parts = kernel.radiance_parts(pixel, sample);
    }
}

/// The shaders on lanes, in registers of one kind, and their schedule.
#[cfg(target_arch = "x86_64")]
macro_rules! lanes {
    ($module:ident, $file:literal, $features:literal, $doc:literal) => {
        #[doc = $doc]
        // Registers are what unsafe code is for here: elements of slices at indices that were made valid, and the call of
        // what the CPU was seen to have.
        #[allow(
            unsafe_code,
            missing_docs,
            clippy::all,
            clippy::pedantic,
            non_snake_case,
            non_upper_case_globals,
            unused_imports,
            unused_parens,
            unused_mut,
            unused_variables,
            unused_assignments,
            unused_labels,
            unreachable_code,
            dead_code
        )]
        pub mod $module {
            include!(concat!(env!("OUT_DIR"), "/", $file));

            use glam::{UVec2, Vec4};
            use w::LANES;

            /// The ray queries, all lanes in one batch.
            mod native {
                use super::*;
                use crate::query::{self, BATCH, Hits, Rays};

                // A batch has as many rays as the widest registers have lanes.
                fn widened<T: Copy + Default>(a: [T; LANES]) -> [T; BATCH] {
                    core::array::from_fn(|k| a.get(k).copied().unwrap_or_default())
                }

                #[target_feature(enable = $features)]
                fn rays(o: w::V3<w::F>, d: w::V3<w::F>, t_max: w::F, start: w::U) -> Rays {
                    Rays {
                        o: [o.x, o.y, o.z].map(|x| widened(x.to_array())),
                        d: [d.x, d.y, d.z].map(|x| widened(x.to_array())),
                        t_max: widened(t_max.to_array()),
                        start: widened(start.to_array()),
                    }
                }

                #[target_feature(enable = $features)]
                pub fn bvh_closest(
                    lanes: &Lanes<'_>,
                    mask: w::M,
                    o: w::V3<w::F>,
                    d: w::V3<w::F>,
                    t_max: w::F,
                    start: w::U,
                ) -> HitLanes {
                    let mut hits = Hits::default();
                    query::bvh_closest_many(lanes.0, &rays(o, d, t_max, start), mask.bits(), &mut hits);
                    HitLanes {
                        t: w::F::gather(|k| hits.t[k]),
                        id: w::U::gather(|k| hits.id[k]),
                        uv: w::V2 { x: w::F::gather(|k| hits.u[k]), y: w::F::gather(|k| hits.v[k]) },
                        instance: w::U::gather(|k| hits.instance[k]),
                    }
                }

                #[target_feature(enable = $features)]
                pub fn bvh_any(
                    lanes: &Lanes<'_>,
                    mask: w::M,
                    o: w::V3<w::F>,
                    d: w::V3<w::F>,
                    t_max: w::F,
                    start: w::U,
                ) -> w::M {
                    w::M::from_bits(query::bvh_any_many(lanes.0, &rays(o, d, t_max, start), mask.bits()))
                }
            }

            /// As [`super::radiance`]; the CPU must have the lanes.
            pub(super) fn radiance(kernel: &Scalar<'_>, pixel_sample: super::PixelSample<'_>, light: &mut [Vec4]) {
                // SAFETY: the caller has asked the CPU for these features.
                unsafe { schedule::<false>(kernel, pixel_sample, light, &mut []) }
            }

            /// As [`super::radiance_parts`]; the CPU must have the lanes.
            pub(super) fn radiance_parts(
                kernel: &Scalar<'_>,
                pixel_sample: super::PixelSample<'_>,
                parts: &mut [Parts],
            ) {
                // SAFETY: as above.
                unsafe { schedule::<true>(kernel, pixel_sample, &mut [], parts) }
            }

            /// Waiting for so many lanes to be free before they are filled, and a path's start is paid once for all.
            const FREE: u32 = LANES as u32 / 2;

            // Fills `light`, or `in_parts` where light is wanted in parts.
            #[target_feature(enable = $features)]
            fn schedule<const PARTS: bool>(
                kernel: &Scalar<'_>,
                pixel_sample: super::PixelSample<'_>,
                light: &mut [Vec4],
                in_parts: &mut [Parts],
            ) {
                let lanes = Lanes(kernel);
                let count = if PARTS { in_parts.len() } else { light.len() };
                let mut next = 0;
                let mut slot = [0; LANES];
                let mut active = w::M::splat(false);
                let mut path = PathLanes::splat(Path::default());
                let mut parts = PartsLanes::splat(Parts::default());
                let mut finish = |ended: w::M, path: PathLanes, parts: PartsLanes, slot: &[usize; LANES]| {
                    if PARTS {
                        let result = lanes.parts_end(ended, parts, path);
                        for k in (0..LANES).filter(|&k| ended.get(k)) {
                            in_parts[slot[k]] = result.get(k);
                        }
                    } else {
                        let result = lanes.path_light(ended, path);
                        for k in (0..LANES).filter(|&k| ended.get(k)) {
                            light[slot[k]] = result.get(k);
                        }
                    }
                };
                loop {
                    // Free lanes take what comes next.
                    let free = LANES as u32 - active.bits().count_ones();
                    if next < count && (free >= FREE || active.none()) {
                        let mut fresh = 0;
                        let mut starts = [(UVec2::ZERO, 0); LANES];
                        for k in 0..LANES {
                            if !active.get(k) && next < count {
                                starts[k] = pixel_sample(next);
                                slot[k] = next;
                                fresh |= 1 << k;
                                next += 1;
                            }
                        }
                        let fresh = w::M::from_bits(fresh);
                        let pixel = w::V2::<w::U>::gather(|k| starts[k].0);
                        let sample = w::U::gather(|k| starts[k].1);
                        path = PathLanes::select(fresh, lanes.path_start(fresh, pixel, sample), path);
                        if PARTS {
                            parts = PartsLanes::select(fresh, PartsLanes::splat(Parts::default()), parts);
                        }
                        active = active.or(fresh);
                        // Some have ended before they began: no light comes from beside a fisheye's circle.
                        let ended = fresh.and_not(path.alive);
                        if ended.any() {
                            finish(ended, path, parts, &slot);
                            active = active.and_not(ended);
                        }
                    }
                    if active.none() {
                        if next < count {
                            continue;
                        }
                        return;
                    }
                    let hit = lanes.closest_hit(active, path.o, path.d, path.start);
                    if PARTS {
                        lanes.parts_shade(active, &mut parts, &mut path, hit);
                    } else {
                        lanes.path_shade(active, &mut path, hit);
                    }
                    let asks = active.and(path.shadow_t.gt(w::F::splat(0.0)));
                    if asks.any() {
                        let share = lanes.shadow_share(asks, path.shadow_o, path.shadow_d, path.shadow_t, path.start);
                        if PARTS {
                            lanes.parts_shadow(asks, &mut parts, &mut path, share);
                        } else {
                            lanes.path_shadow(asks, &mut path, share);
                        }
                    }
                    let ended = active.and_not(path.alive);
                    if ended.any() {
                        finish(ended, path, parts, &slot);
                        active = active.and(path.alive);
                    }
                }
            }
        }
    };
}

#[cfg(target_arch = "x86_64")]
lanes!(eight, "avx2.rs", "avx2,bmi1,bmi2,lzcnt,popcnt", "Eight lanes of AVX2.");
#[cfg(target_arch = "x86_64")]
lanes!(
    sixteen,
    "avx512.rs",
    "avx512f,avx512bw,avx512dq,avx512vl,avx2,bmi1,bmi2,lzcnt,popcnt",
    "Sixteen lanes of AVX-512."
);
