//! Eight numbers at a time, once for each instruction set that the walk is compiled for. All but [`Lanes::mul_add`]
//! give the same bits in all of them.
//!
//! This is the only place of the kernel with unsafe code. Two things need it: an intrinsic asks for a CPU that has the
//! instruction, which holds since [`Isa::best`] alone chooses, by what the CPU says; and the walk's stack is not
//! cleared for every ray.
#![allow(unsafe_code)]

use std::mem::MaybeUninit;

/// How many lanes there are.
pub const WIDTH: usize = 8;

/// Rays of one batch.
pub const BATCH: usize = 16;

/// A value for each lane, as it lies in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(32))]
pub struct Row(pub [f32; WIDTH]);

impl Row {
    /// The same bits as whole numbers.
    pub fn from_bits(bits: [u32; WIDTH]) -> Self {
        Row(bits.map(f32::from_bits))
    }
}

/// Some numbers side by side. Comparisons with a NaN are false; of `min` and `max`, the second operand wins beside a NaN.
pub trait Lanes: Copy {
    /// How many, a divisor of [`BATCH`].
    const COUNT: usize;
    /// A truth a lane.
    type Mask: Copy;
    fn splat(x: f32) -> Self;
    /// From the first numbers; zeros where there are too few.
    fn load(numbers: &[f32]) -> Self;
    /// To the first places; nowhere if there are too few.
    fn store(self, places: &mut [f32]);
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    fn sqrt(self) -> Self;
    fn min(self, other: Self) -> Self;
    fn max(self, other: Self) -> Self;
    /// `self * b + c`, rounded once or twice.
    fn mul_add(self, b: Self, c: Self) -> Self;
    fn lt(self, other: Self) -> Self::Mask;
    fn le(self, other: Self) -> Self::Mask;
    fn eq(self, other: Self) -> Self::Mask;
    /// Whether the bits are the same.
    fn same_bits(self, other: Self) -> Self::Mask;
    /// Whether the bits, as whole numbers, are less.
    fn bits_lt(self, other: Self) -> Self::Mask;
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    fn or(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// b and not a.
    fn and_not(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    fn select(reject: Self, accept: Self, mask: Self::Mask) -> Self;
    /// Bit i: lane i.
    fn bits(mask: Self::Mask) -> u32;
}

/// Eight lanes.
pub trait Eight: Lanes {
    /// Moves lane `order[i]` to lane i.
    fn permute(self, order: u64) -> Self;
}

/// An instruction set that the walk is compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Isa {
    /// What every CPU of the target has.
    Portable,
    /// x86-64 with AVX2, FMA and what came with them.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// x86-64 with AVX-512 F, BW, DQ and VL.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Isa {
    /// All that there are, the best last.
    pub const ALL: &[Isa] = &[
        Isa::Portable,
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2,
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512,
    ];

    /// The best that this CPU has.
    pub fn best() -> Isa {
        Isa::ALL.iter().rev().copied().find(|isa| isa.is_there()).unwrap_or(Isa::Portable)
    }

    /// Whether this CPU has it.
    pub fn is_there(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        use std::arch::is_x86_feature_detected as has;
        match self {
            Isa::Portable => true,
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => has!("avx2") && has!("fma") && has!("bmi1") && has!("bmi2") && has!("lzcnt") && has!("popcnt"),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => {
                let all = has!("avx512f") && has!("avx512bw") && has!("avx512dq") && has!("avx512vl");
                all && Isa::Avx2.is_there()
            }
        }
    }
}

/// Plain arrays, which a compiler turns into whatever lanes the target has.
#[derive(Clone, Copy)]
pub struct Portable([f32; WIDTH]);

macro_rules! each {
    ($i:ident, $value:expr) => {{
        let mut all = [Default::default(); WIDTH];
        for $i in 0..WIDTH {
            all[$i] = $value;
        }
        all
    }};
}

impl Lanes for Portable {
    const COUNT: usize = WIDTH;
    type Mask = [bool; WIDTH];
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Portable([x; WIDTH])
    }
    #[inline(always)]
    fn load(numbers: &[f32]) -> Self {
        Portable(numbers.first_chunk().copied().unwrap_or_default())
    }
    #[inline(always)]
    fn store(self, places: &mut [f32]) {
        if let Some(places) = places.first_chunk_mut() {
            *places = self.0;
        }
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Portable(each!(i, self.0[i] + other.0[i]))
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Portable(each!(i, self.0[i] - other.0[i]))
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Portable(each!(i, self.0[i] * other.0[i]))
    }
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Portable(each!(i, self.0[i] / other.0[i]))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Portable(each!(i, self.0[i].sqrt()))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Portable(each!(i, if self.0[i] < other.0[i] { self.0[i] } else { other.0[i] }))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Portable(each!(i, if self.0[i] > other.0[i] { self.0[i] } else { other.0[i] }))
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self.mul(b).add(c)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self::Mask {
        each!(i, self.0[i] < other.0[i])
    }
    #[inline(always)]
    fn le(self, other: Self) -> Self::Mask {
        each!(i, self.0[i] <= other.0[i])
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Self::Mask {
        each!(i, self.0[i] == other.0[i])
    }
    #[inline(always)]
    fn same_bits(self, other: Self) -> Self::Mask {
        each!(i, self.0[i].to_bits() == other.0[i].to_bits())
    }
    #[inline(always)]
    fn bits_lt(self, other: Self) -> Self::Mask {
        each!(i, self.0[i].to_bits() < other.0[i].to_bits())
    }
    #[inline(always)]
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        each!(i, a[i] & b[i])
    }
    #[inline(always)]
    fn or(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        each!(i, a[i] | b[i])
    }
    #[inline(always)]
    fn and_not(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        each!(i, !a[i] & b[i])
    }
    #[inline(always)]
    fn select(reject: Self, accept: Self, mask: Self::Mask) -> Self {
        Portable(each!(i, if mask[i] { accept.0[i] } else { reject.0[i] }))
    }
    #[inline(always)]
    fn bits(mask: Self::Mask) -> u32 {
        mask.iter().enumerate().fold(0, |bits, (i, &lane)| bits | u32::from(lane) << i)
    }
}

impl Eight for Portable {
    #[inline(always)]
    fn permute(self, order: u64) -> Self {
        Portable(each!(i, self.0[(order >> (8 * i)) as usize & (WIDTH - 1)]))
    }
}

#[cfg(target_arch = "x86_64")]
pub use x86::{Avx2, Avx512, Avx512x16};

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::*;

    use super::{Eight, Lanes};

    /// Eight lanes, vectors as masks.
    #[derive(Clone, Copy)]
    pub struct Avx2(__m256);

    /// Eight lanes with mask registers.
    #[derive(Clone, Copy)]
    pub struct Avx512(__m256);

    /// Sixteen lanes with mask registers.
    #[derive(Clone, Copy)]
    pub struct Avx512x16(__m512);

    // SAFETY of all that follows: these types are only used below functions that are called where the CPU has the
    // instructions; loads and stores are of as many numbers as were just counted.
    macro_rules! binary {
        ($T:ident, $($name:ident $intrinsic:ident),+) => {
            $(#[inline(always)]
            fn $name(self, other: Self) -> Self {
                $T(unsafe { $intrinsic(self.0, other.0) })
            })+
        };
    }

    macro_rules! plain {
        ($T:ident, $count:literal, $set:ident, $zero:ident, $load:ident, $store:ident, $sqrt:ident, $fmadd:ident) => {
            const COUNT: usize = $count;
            #[inline(always)]
            fn splat(x: f32) -> Self {
                $T(unsafe { $set(x) })
            }
            #[inline(always)]
            fn load(numbers: &[f32]) -> Self {
                if numbers.len() < $count {
                    return $T(unsafe { $zero() });
                }
                $T(unsafe { $load(numbers.as_ptr()) })
            }
            #[inline(always)]
            fn store(self, places: &mut [f32]) {
                if places.len() >= $count {
                    unsafe { $store(places.as_mut_ptr(), self.0) };
                }
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $T(unsafe { $sqrt(self.0) })
            }
            #[inline(always)]
            fn mul_add(self, b: Self, c: Self) -> Self {
                $T(unsafe { $fmadd(self.0, b.0, c.0) })
            }
        };
    }

    macro_rules! plain_256 {
        ($T:ident) => {
            plain!(
                $T, 8, _mm256_set1_ps, _mm256_setzero_ps, _mm256_loadu_ps, _mm256_storeu_ps, _mm256_sqrt_ps, _mm256_fmadd_ps
            );
            binary!(
                $T, add _mm256_add_ps, sub _mm256_sub_ps, mul _mm256_mul_ps, div _mm256_div_ps, min _mm256_min_ps,
                max _mm256_max_ps
            );
        };
    }

    macro_rules! mask_registers {
        ($T:ident, $M:ident, $compare:ident, $same:ident, $less:ident, $integers:ident, $blend:ident) => {
            type Mask = $M;
            #[inline(always)]
            fn lt(self, other: Self) -> Self::Mask {
                unsafe { $compare::<_CMP_LT_OQ>(self.0, other.0) }
            }
            #[inline(always)]
            fn le(self, other: Self) -> Self::Mask {
                unsafe { $compare::<_CMP_LE_OQ>(self.0, other.0) }
            }
            #[inline(always)]
            fn eq(self, other: Self) -> Self::Mask {
                unsafe { $compare::<_CMP_EQ_OQ>(self.0, other.0) }
            }
            #[inline(always)]
            fn same_bits(self, other: Self) -> Self::Mask {
                unsafe { $same($integers(self.0), $integers(other.0)) }
            }
            #[inline(always)]
            fn bits_lt(self, other: Self) -> Self::Mask {
                unsafe { $less($integers(self.0), $integers(other.0)) }
            }
            #[inline(always)]
            fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask {
                a & b
            }
            #[inline(always)]
            fn or(a: Self::Mask, b: Self::Mask) -> Self::Mask {
                a | b
            }
            #[inline(always)]
            fn and_not(a: Self::Mask, b: Self::Mask) -> Self::Mask {
                !a & b
            }
            #[inline(always)]
            fn select(reject: Self, accept: Self, mask: Self::Mask) -> Self {
                $T(unsafe { $blend(mask, reject.0, accept.0) })
            }
            #[inline(always)]
            fn bits(mask: Self::Mask) -> u32 {
                u32::from(mask)
            }
        };
    }

    macro_rules! permute {
        ($T:ident) => {
            impl Eight for $T {
                #[inline(always)]
                fn permute(self, order: u64) -> Self {
                    $T(unsafe {
                        _mm256_permutevar8x32_ps(self.0, _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(order as i64)))
                    })
                }
            }
        };
    }

    impl Lanes for Avx2 {
        type Mask = __m256;
        plain_256!(Avx2);
        #[inline(always)]
        fn lt(self, other: Self) -> Self::Mask {
            unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0) }
        }
        #[inline(always)]
        fn le(self, other: Self) -> Self::Mask {
            unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0) }
        }
        #[inline(always)]
        fn eq(self, other: Self) -> Self::Mask {
            unsafe { _mm256_cmp_ps::<_CMP_EQ_OQ>(self.0, other.0) }
        }
        #[inline(always)]
        fn same_bits(self, other: Self) -> Self::Mask {
            unsafe {
                _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_castps_si256(self.0), _mm256_castps_si256(other.0)))
            }
        }
        #[inline(always)]
        fn bits_lt(self, other: Self) -> Self::Mask {
            // Signed comparison of numbers whose highest bit was flipped.
            unsafe {
                let flip = _mm256_set1_epi32(i32::MIN);
                let (a, b) = (_mm256_castps_si256(self.0), _mm256_castps_si256(other.0));
                _mm256_castsi256_ps(_mm256_cmpgt_epi32(_mm256_xor_si256(b, flip), _mm256_xor_si256(a, flip)))
            }
        }
        #[inline(always)]
        fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask {
            unsafe { _mm256_and_ps(a, b) }
        }
        #[inline(always)]
        fn or(a: Self::Mask, b: Self::Mask) -> Self::Mask {
            unsafe { _mm256_or_ps(a, b) }
        }
        #[inline(always)]
        fn and_not(a: Self::Mask, b: Self::Mask) -> Self::Mask {
            unsafe { _mm256_andnot_ps(a, b) }
        }
        #[inline(always)]
        fn select(reject: Self, accept: Self, mask: Self::Mask) -> Self {
            Avx2(unsafe { _mm256_blendv_ps(reject.0, accept.0, mask) })
        }
        #[inline(always)]
        fn bits(mask: Self::Mask) -> u32 {
            unsafe { _mm256_movemask_ps(mask) as u32 }
        }
    }
    permute!(Avx2);

    impl Lanes for Avx512 {
        plain_256!(Avx512);
        mask_registers!(
            Avx512,
            __mmask8,
            _mm256_cmp_ps_mask,
            _mm256_cmpeq_epi32_mask,
            _mm256_cmplt_epu32_mask,
            _mm256_castps_si256,
            _mm256_mask_blend_ps
        );
    }
    permute!(Avx512);

    impl Lanes for Avx512x16 {
        plain!(
            Avx512x16,
            16,
            _mm512_set1_ps,
            _mm512_setzero_ps,
            _mm512_loadu_ps,
            _mm512_storeu_ps,
            _mm512_sqrt_ps,
            _mm512_fmadd_ps
        );
        binary!(
            Avx512x16, add _mm512_add_ps, sub _mm512_sub_ps, mul _mm512_mul_ps, div _mm512_div_ps, min _mm512_min_ps,
            max _mm512_max_ps
        );
        mask_registers!(
            Avx512x16,
            __mmask16,
            _mm512_cmp_ps_mask,
            _mm512_cmpeq_epi32_mask,
            _mm512_cmplt_epu32_mask,
            _mm512_castps_si512,
            _mm512_mask_blend_ps
        );
    }
}

/// Nodes and leaves still to visit, with the distances at which the ray enters them.
pub struct Stack {
    entries: usize,
    near: MaybeUninit<[f32; Stack::SIZE]>,
    items: MaybeUninit<[u32; Stack::SIZE]>,
}

impl Stack {
    /// Entries that there is room for.
    pub const SIZE: usize = 256;

    #[inline(always)]
    pub const fn new() -> Self {
        Stack { entries: 0, near: MaybeUninit::uninit(), items: MaybeUninit::uninit() }
    }

    /// Puts the first `count` lanes on top, the last of them topmost; nothing if there is no room.
    #[inline(always)]
    pub fn push<L: Eight>(&mut self, near: L, items: L, count: usize) {
        if self.entries > Stack::SIZE - WIDTH || count > WIDTH {
            return;
        }
        // SAFETY: all eight lanes fit, as was just asked. What lies beyond the entries is written, never read.
        unsafe {
            let at = self.near.as_mut_ptr().cast::<f32>().add(self.entries);
            near.store(std::slice::from_raw_parts_mut(at, WIDTH));
            let at = self.items.as_mut_ptr().cast::<f32>().add(self.entries);
            items.store(std::slice::from_raw_parts_mut(at, WIDTH));
        }
        self.entries += count;
    }

    #[inline(always)]
    pub fn pop(&mut self) -> Option<(f32, u32)> {
        self.entries = self.entries.checked_sub(1)?;
        // SAFETY: the entry was written by `push`, which alone raises `entries`.
        unsafe {
            let near = *self.near.as_ptr().cast::<f32>().add(self.entries);
            let item = *self.items.as_ptr().cast::<u32>().add(self.entries);
            Some((near, item))
        }
    }
}
