/// Sixteen lanes in AVX-512's registers, and what WGSL's scalar operators mean on them: the same bits as one lane after
/// the other through `wgsl`.
pub mod w {
    use core::arch::x86_64::*;
    use core::mem::transmute;

    /// How many lanes.
    pub const LANES: usize = 16;

    /// `f32`s.
    #[derive(Clone, Copy)]
    #[repr(transparent)]
    pub struct F(__m512);
    /// `i32`s.
    #[derive(Clone, Copy)]
    #[repr(transparent)]
    pub struct I(__m512i);
    /// `u32`s.
    #[derive(Clone, Copy)]
    #[repr(transparent)]
    pub struct U(__m512i);
    /// `bool`s: a bit a lane.
    #[derive(Clone, Copy)]
    #[repr(transparent)]
    pub struct M(__mmask16);

    impl M {
        #[lanes]
        pub fn splat(a: bool) -> Self {
            Self(if a { 0xffff } else { 0 })
        }
        #[lanes]
        pub fn bits(self) -> u32 {
            u32::from(self.0)
        }
        #[lanes]
        pub fn from_bits(bits: u32) -> Self {
            Self(bits as u16)
        }
        #[lanes]
        pub fn and(self, b: Self) -> Self {
            Self(self.0 & b.0)
        }
        #[lanes]
        pub fn or(self, b: Self) -> Self {
            Self(self.0 | b.0)
        }
        #[lanes]
        pub fn xor(self, b: Self) -> Self {
            Self(self.0 ^ b.0)
        }
        /// `self && !b`
        #[lanes]
        pub fn and_not(self, b: Self) -> Self {
            Self(self.0 & !b.0)
        }
        #[lanes]
        pub fn select(m: M, accept: Self, reject: Self) -> Self {
            Self((accept.0 & m.0) | (reject.0 & !m.0))
        }
    }

    impl F {
        #[lanes]
        pub fn splat(a: f32) -> Self {
            Self(_mm512_set1_ps(a))
        }
        #[lanes]
        pub fn to_array(self) -> [f32; LANES] {
            // SAFETY: both are 64 bytes, and all bits are numbers.
            unsafe { transmute(self.0) }
        }
        #[lanes]
        pub fn from_array(a: [f32; LANES]) -> Self {
            // SAFETY: both are 64 bytes, and all bits are numbers.
            Self(unsafe { transmute(a) })
        }
        #[lanes]
        pub fn select(m: M, accept: Self, reject: Self) -> Self {
            Self(_mm512_mask_blend_ps(m.0, reject.0, accept.0))
        }
        #[lanes]
        pub fn add(self, b: Self) -> Self {
            Self(_mm512_add_ps(self.0, b.0))
        }
        #[lanes]
        pub fn sub(self, b: Self) -> Self {
            Self(_mm512_sub_ps(self.0, b.0))
        }
        #[lanes]
        pub fn mul(self, b: Self) -> Self {
            Self(_mm512_mul_ps(self.0, b.0))
        }
        #[lanes]
        pub fn div(self, b: Self) -> Self {
            Self(_mm512_div_ps(self.0, b.0))
        }
        #[lanes]
        pub fn neg(self) -> Self {
            Self(_mm512_xor_ps(self.0, _mm512_set1_ps(-0.0)))
        }
        #[lanes]
        pub fn abs(self) -> Self {
            Self(_mm512_andnot_ps(_mm512_set1_ps(-0.0), self.0))
        }
        // `minps` and `maxps` give their second operand unless the first is less, or greater: WGSL's definition.
        #[lanes]
        pub fn min(self, b: Self) -> Self {
            Self(_mm512_min_ps(b.0, self.0))
        }
        #[lanes]
        pub fn max(self, b: Self) -> Self {
            Self(_mm512_max_ps(b.0, self.0))
        }
        #[lanes]
        pub fn sqrt(self) -> Self {
            Self(_mm512_sqrt_ps(self.0))
        }
        #[lanes]
        pub fn floor(self) -> Self {
            Self(_mm512_roundscale_ps::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(self.0))
        }
        #[lanes]
        pub fn ceil(self) -> Self {
            Self(_mm512_roundscale_ps::<{ _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC }>(self.0))
        }
        #[lanes]
        pub fn trunc(self) -> Self {
            Self(_mm512_roundscale_ps::<{ _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC }>(self.0))
        }
        #[lanes]
        pub fn round(self) -> Self {
            Self(_mm512_roundscale_ps::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(self.0))
        }
        #[lanes]
        pub fn eq(self, b: Self) -> M {
            M(_mm512_cmp_ps_mask::<_CMP_EQ_OQ>(self.0, b.0))
        }
        #[lanes]
        pub fn ne(self, b: Self) -> M {
            M(_mm512_cmp_ps_mask::<_CMP_NEQ_UQ>(self.0, b.0))
        }
        #[lanes]
        pub fn lt(self, b: Self) -> M {
            M(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, b.0))
        }
        #[lanes]
        pub fn le(self, b: Self) -> M {
            M(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, b.0))
        }
        #[lanes]
        pub fn gt(self, b: Self) -> M {
            M(_mm512_cmp_ps_mask::<_CMP_GT_OQ>(self.0, b.0))
        }
        #[lanes]
        pub fn ge(self, b: Self) -> M {
            M(_mm512_cmp_ps_mask::<_CMP_GE_OQ>(self.0, b.0))
        }
        #[lanes]
        pub fn bits_int(self) -> I {
            I(_mm512_castps_si512(self.0))
        }
        #[lanes]
        pub fn bits_uint(self) -> U {
            U(_mm512_castps_si512(self.0))
        }
        // Rust's `as`: what is too large ends at the largest value, what is no number is 0.
        #[lanes]
        pub fn to_int(self) -> I {
            let number = _mm512_cmp_ps_mask::<_CMP_ORD_Q>(self.0, self.0);
            let near = _mm512_maskz_cvttps_epi32(number, self.0);
            let large = _mm512_cmp_ps_mask::<_CMP_GE_OQ>(self.0, _mm512_set1_ps(2_147_483_648.0));
            I(_mm512_mask_blend_epi32(large, near, _mm512_set1_epi32(i32::MAX)))
        }
        #[lanes]
        pub fn to_uint(self) -> U {
            // What is too large gives all ones.
            U(_mm512_cvttps_epu32(_mm512_max_ps(self.0, _mm512_setzero_ps())))
        }
    }

    // What `I` and `U` share.
    macro_rules! integer {
        ($T:ident, $t:ident) => {
            impl $T {
                #[lanes]
                pub fn splat(a: $t) -> Self {
                    Self(_mm512_set1_epi32(a as i32))
                }
                #[lanes]
                pub fn to_array(self) -> [$t; LANES] {
                    // SAFETY: both are 64 bytes, and all bits are numbers.
                    unsafe { transmute(self.0) }
                }
                #[lanes]
                pub fn from_array(a: [$t; LANES]) -> Self {
                    // SAFETY: both are 64 bytes, and all bits are numbers.
                    Self(unsafe { transmute(a) })
                }
                #[lanes]
                pub fn select(m: M, accept: Self, reject: Self) -> Self {
                    Self(_mm512_mask_blend_epi32(m.0, reject.0, accept.0))
                }
                #[lanes]
                pub fn add(self, b: Self) -> Self {
                    Self(_mm512_add_epi32(self.0, b.0))
                }
                #[lanes]
                pub fn sub(self, b: Self) -> Self {
                    Self(_mm512_sub_epi32(self.0, b.0))
                }
                #[lanes]
                pub fn mul(self, b: Self) -> Self {
                    Self(_mm512_mullo_epi32(self.0, b.0))
                }
                #[lanes]
                pub fn neg(self) -> Self {
                    Self(_mm512_sub_epi32(_mm512_setzero_si512(), self.0))
                }
                #[lanes]
                pub fn and(self, b: Self) -> Self {
                    Self(_mm512_and_si512(self.0, b.0))
                }
                #[lanes]
                pub fn or(self, b: Self) -> Self {
                    Self(_mm512_or_si512(self.0, b.0))
                }
                #[lanes]
                pub fn xor(self, b: Self) -> Self {
                    Self(_mm512_xor_si512(self.0, b.0))
                }
                #[lanes]
                pub fn not(self) -> Self {
                    Self(_mm512_xor_si512(self.0, _mm512_set1_epi32(-1)))
                }
                #[lanes]
                pub fn shl(self, b: U) -> Self {
                    Self(_mm512_sllv_epi32(self.0, _mm512_and_si512(b.0, _mm512_set1_epi32(31))))
                }
                #[lanes]
                pub fn eq(self, b: Self) -> M {
                    M(_mm512_cmpeq_epi32_mask(self.0, b.0))
                }
                #[lanes]
                pub fn reverse_bits(self) -> Self {
                    // Bytes turned about, then each byte's halves looked up.
                    let turn = _mm512_broadcast_i32x4(_mm_setr_epi8(
                        3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12,
                    ));
                    let low = _mm512_broadcast_i32x4(_mm_setr_epi8(
                        0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15,
                    ));
                    let nibble = _mm512_set1_epi8(15);
                    let a = _mm512_shuffle_epi8(self.0, turn);
                    let first = _mm512_shuffle_epi8(low, _mm512_and_si512(a, nibble));
                    let second = _mm512_shuffle_epi8(low, _mm512_and_si512(_mm512_srli_epi32::<4>(a), nibble));
                    Self(_mm512_or_si512(_mm512_slli_epi32::<4>(first), second))
                }
                #[lanes]
                pub fn bits_float(self) -> F {
                    F(_mm512_castsi512_ps(self.0))
                }
            }
        };
    }
    integer!(I, i32);
    integer!(U, u32);

    impl I {
        #[lanes]
        pub fn min(self, b: Self) -> Self {
            Self(_mm512_min_epi32(self.0, b.0))
        }
        #[lanes]
        pub fn max(self, b: Self) -> Self {
            Self(_mm512_max_epi32(self.0, b.0))
        }
        #[lanes]
        pub fn lt(self, b: Self) -> M {
            M(_mm512_cmplt_epi32_mask(self.0, b.0))
        }
        #[lanes]
        pub fn shr(self, b: U) -> Self {
            Self(_mm512_srav_epi32(self.0, _mm512_and_si512(b.0, _mm512_set1_epi32(31))))
        }
        #[lanes]
        pub fn abs(self) -> Self {
            Self(_mm512_abs_epi32(self.0))
        }
        #[lanes]
        pub fn to_uint(self) -> U {
            U(self.0)
        }
        #[lanes]
        pub fn to_float(self) -> F {
            F(_mm512_cvtepi32_ps(self.0))
        }
    }

    impl U {
        #[lanes]
        pub fn min(self, b: Self) -> Self {
            Self(_mm512_min_epu32(self.0, b.0))
        }
        #[lanes]
        pub fn max(self, b: Self) -> Self {
            Self(_mm512_max_epu32(self.0, b.0))
        }
        #[lanes]
        pub fn lt(self, b: Self) -> M {
            M(_mm512_cmplt_epu32_mask(self.0, b.0))
        }
        #[lanes]
        pub fn shr(self, b: U) -> Self {
            Self(_mm512_srlv_epi32(self.0, _mm512_and_si512(b.0, _mm512_set1_epi32(31))))
        }
        #[lanes]
        pub fn abs(self) -> Self {
            self
        }
        #[lanes]
        pub fn to_int(self) -> I {
            I(self.0)
        }
        #[lanes]
        pub fn to_float(self) -> F {
            F(_mm512_cvtepu32_ps(self.0))
        }
    }

    // Rows of four as four columns: 4×4 blocks are turned within each quarter of a register.
    #[lanes]
    fn rows<T: bytemuck::Pod>(f: impl Fn(usize) -> T) -> [__m512; 4] {
        let row = |k| bytemuck::cast::<T, __m128>(f(k));
        let quarters = |k| {
            let a = _mm512_castps128_ps512(row(k));
            let a = _mm512_insertf32x4::<1>(a, row(k + 4));
            let a = _mm512_insertf32x4::<2>(a, row(k + 8));
            _mm512_insertf32x4::<3>(a, row(k + 12))
        };
        let (a, b, c, d) = (quarters(0), quarters(1), quarters(2), quarters(3));
        let low = [_mm512_unpacklo_ps(a, b), _mm512_unpacklo_ps(c, d)];
        let high = [_mm512_unpackhi_ps(a, b), _mm512_unpackhi_ps(c, d)];
        [
            _mm512_shuffle_ps::<0x44>(low[0], low[1]),
            _mm512_shuffle_ps::<0xee>(low[0], low[1]),
            _mm512_shuffle_ps::<0x44>(high[0], high[1]),
            _mm512_shuffle_ps::<0xee>(high[0], high[1]),
        ]
    }
    #[lanes]
    fn four_floats(f: impl Fn(usize) -> glam::Vec4) -> V4<F> {
        let [x, y, z, w] = rows(f);
        V4 { x: F(x), y: F(y), z: F(z), w: F(w) }
    }
    #[lanes]
    fn four_ints(f: impl Fn(usize) -> glam::IVec4) -> V4<I> {
        let [x, y, z, w] = rows(f);
        let cast = |a| I(_mm512_castps_si512(a));
        V4 { x: cast(x), y: cast(y), z: cast(z), w: cast(w) }
    }
    #[lanes]
    fn four_uints(f: impl Fn(usize) -> glam::UVec4) -> V4<U> {
        let [x, y, z, w] = rows(f);
        let cast = |a| U(_mm512_castps_si512(a));
        V4 { x: cast(x), y: cast(y), z: cast(z), w: cast(w) }
    }
    #[lanes]
    fn each<T>(f: impl Fn(usize) -> T) -> [T; LANES] {
        [
            f(0), f(1), f(2), f(3), f(4), f(5), f(6), f(7), f(8), f(9), f(10), f(11), f(12), f(13), f(14), f(15),
        ]
    }
