/// Eight lanes in AVX2's registers, and what WGSL's scalar operators mean on them: the same bits as one lane after the
/// other through `wgsl`.
pub mod w {
    use core::arch::x86_64::*;

    /// How many lanes.
    pub const LANES: usize = 8;

    /// `f32`s.
    #[derive(Clone, Copy)]
    #[repr(transparent)]
    pub struct F(__m256);
    /// `i32`s.
    #[derive(Clone, Copy)]
    #[repr(transparent)]
    pub struct I(__m256i);
    /// `u32`s.
    #[derive(Clone, Copy)]
    #[repr(transparent)]
    pub struct U(__m256i);
    /// `bool`s: all bits of a lane or none.
    #[derive(Clone, Copy)]
    #[repr(transparent)]
    pub struct M(__m256);

    impl M {
        #[lanes]
        pub fn splat(a: bool) -> Self {
            Self(_mm256_castsi256_ps(_mm256_set1_epi32(-i32::from(a))))
        }
        #[lanes]
        pub fn bits(self) -> u32 {
            _mm256_movemask_ps(self.0) as u32
        }
        #[lanes]
        pub fn from_bits(bits: u32) -> Self {
            let lane = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let bits = _mm256_and_si256(_mm256_set1_epi32(bits as i32), lane);
            Self(_mm256_castsi256_ps(_mm256_cmpeq_epi32(bits, lane)))
        }
        #[lanes]
        pub fn and(self, b: Self) -> Self {
            Self(_mm256_and_ps(self.0, b.0))
        }
        #[lanes]
        pub fn or(self, b: Self) -> Self {
            Self(_mm256_or_ps(self.0, b.0))
        }
        #[lanes]
        pub fn xor(self, b: Self) -> Self {
            Self(_mm256_xor_ps(self.0, b.0))
        }
        /// `self && !b`
        #[lanes]
        pub fn and_not(self, b: Self) -> Self {
            Self(_mm256_andnot_ps(b.0, self.0))
        }
        #[lanes]
        pub fn select(m: M, accept: Self, reject: Self) -> Self {
            Self(_mm256_blendv_ps(reject.0, accept.0, m.0))
        }
    }

    impl F {
        #[lanes]
        pub fn splat(a: f32) -> Self {
            Self(_mm256_set1_ps(a))
        }
        #[lanes]
        pub fn to_array(self) -> [f32; LANES] {
            bytemuck::cast(self.0)
        }
        #[lanes]
        pub fn from_array(a: [f32; LANES]) -> Self {
            Self(bytemuck::cast(a))
        }
        #[lanes]
        pub fn select(m: M, accept: Self, reject: Self) -> Self {
            Self(_mm256_blendv_ps(reject.0, accept.0, m.0))
        }
        #[lanes]
        pub fn add(self, b: Self) -> Self {
            Self(_mm256_add_ps(self.0, b.0))
        }
        #[lanes]
        pub fn sub(self, b: Self) -> Self {
            Self(_mm256_sub_ps(self.0, b.0))
        }
        #[lanes]
        pub fn mul(self, b: Self) -> Self {
            Self(_mm256_mul_ps(self.0, b.0))
        }
        #[lanes]
        pub fn div(self, b: Self) -> Self {
            Self(_mm256_div_ps(self.0, b.0))
        }
        #[lanes]
        pub fn neg(self) -> Self {
            Self(_mm256_xor_ps(self.0, _mm256_set1_ps(-0.0)))
        }
        #[lanes]
        pub fn abs(self) -> Self {
            Self(_mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0))
        }
        // `minps` and `maxps` give their second operand unless the first is less, or greater: WGSL's definition.
        #[lanes]
        pub fn min(self, b: Self) -> Self {
            Self(_mm256_min_ps(b.0, self.0))
        }
        #[lanes]
        pub fn max(self, b: Self) -> Self {
            Self(_mm256_max_ps(b.0, self.0))
        }
        #[lanes]
        pub fn sqrt(self) -> Self {
            Self(_mm256_sqrt_ps(self.0))
        }
        #[lanes]
        pub fn floor(self) -> Self {
            Self(_mm256_floor_ps(self.0))
        }
        #[lanes]
        pub fn ceil(self) -> Self {
            Self(_mm256_ceil_ps(self.0))
        }
        #[lanes]
        pub fn trunc(self) -> Self {
            Self(_mm256_round_ps::<{ _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC }>(self.0))
        }
        #[lanes]
        pub fn round(self) -> Self {
            Self(_mm256_round_ps::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(self.0))
        }
        #[lanes]
        pub fn eq(self, b: Self) -> M {
            M(_mm256_cmp_ps::<_CMP_EQ_OQ>(self.0, b.0))
        }
        #[lanes]
        pub fn ne(self, b: Self) -> M {
            M(_mm256_cmp_ps::<_CMP_NEQ_UQ>(self.0, b.0))
        }
        #[lanes]
        pub fn lt(self, b: Self) -> M {
            M(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, b.0))
        }
        #[lanes]
        pub fn le(self, b: Self) -> M {
            M(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, b.0))
        }
        #[lanes]
        pub fn gt(self, b: Self) -> M {
            M(_mm256_cmp_ps::<_CMP_GT_OQ>(self.0, b.0))
        }
        #[lanes]
        pub fn ge(self, b: Self) -> M {
            M(_mm256_cmp_ps::<_CMP_GE_OQ>(self.0, b.0))
        }
        #[lanes]
        pub fn bits_int(self) -> I {
            I(_mm256_castps_si256(self.0))
        }
        #[lanes]
        pub fn bits_uint(self) -> U {
            U(_mm256_castps_si256(self.0))
        }
        // Rust's `as`: what is too large ends at the largest value, what is no number is 0.
        #[lanes]
        pub fn to_int(self) -> I {
            let near = _mm256_castsi256_ps(_mm256_cvttps_epi32(self.0));
            let most = _mm256_castsi256_ps(_mm256_set1_epi32(i32::MAX));
            let large = _mm256_cmp_ps::<_CMP_GE_OQ>(self.0, _mm256_set1_ps(2_147_483_648.0));
            let number = _mm256_cmp_ps::<_CMP_ORD_Q>(self.0, self.0);
            I(_mm256_castps_si256(_mm256_and_ps(_mm256_blendv_ps(near, most, large), number)))
        }
        #[lanes]
        pub fn to_uint(self) -> U {
            let half = _mm256_set1_ps(2_147_483_648.0);
            let a = _mm256_max_ps(self.0, _mm256_setzero_ps());
            let low = _mm256_cvttps_epi32(a);
            let high = _mm256_xor_si256(_mm256_cvttps_epi32(_mm256_sub_ps(a, half)), _mm256_set1_epi32(i32::MIN));
            let upper = _mm256_cmp_ps::<_CMP_GE_OQ>(a, half);
            let near = _mm256_blendv_ps(_mm256_castsi256_ps(low), _mm256_castsi256_ps(high), upper);
            let large = _mm256_cmp_ps::<_CMP_GE_OQ>(a, _mm256_set1_ps(4_294_967_296.0));
            U(_mm256_castps_si256(_mm256_or_ps(near, large)))
        }
    }

    // What `I` and `U` share.
    macro_rules! integer {
        ($T:ident, $t:ident) => {
            impl $T {
                #[lanes]
                pub fn splat(a: $t) -> Self {
                    Self(_mm256_set1_epi32(a as i32))
                }
                #[lanes]
                pub fn to_array(self) -> [$t; LANES] {
                    bytemuck::cast(self.0)
                }
                #[lanes]
                pub fn from_array(a: [$t; LANES]) -> Self {
                    Self(bytemuck::cast(a))
                }
                #[lanes]
                pub fn select(m: M, accept: Self, reject: Self) -> Self {
                    let (accept, reject) = (_mm256_castsi256_ps(accept.0), _mm256_castsi256_ps(reject.0));
                    Self(_mm256_castps_si256(_mm256_blendv_ps(reject, accept, m.0)))
                }
                #[lanes]
                pub fn add(self, b: Self) -> Self {
                    Self(_mm256_add_epi32(self.0, b.0))
                }
                #[lanes]
                pub fn sub(self, b: Self) -> Self {
                    Self(_mm256_sub_epi32(self.0, b.0))
                }
                #[lanes]
                pub fn mul(self, b: Self) -> Self {
                    Self(_mm256_mullo_epi32(self.0, b.0))
                }
                #[lanes]
                pub fn neg(self) -> Self {
                    Self(_mm256_sub_epi32(_mm256_setzero_si256(), self.0))
                }
                #[lanes]
                pub fn and(self, b: Self) -> Self {
                    Self(_mm256_and_si256(self.0, b.0))
                }
                #[lanes]
                pub fn or(self, b: Self) -> Self {
                    Self(_mm256_or_si256(self.0, b.0))
                }
                #[lanes]
                pub fn xor(self, b: Self) -> Self {
                    Self(_mm256_xor_si256(self.0, b.0))
                }
                #[lanes]
                pub fn not(self) -> Self {
                    Self(_mm256_xor_si256(self.0, _mm256_set1_epi32(-1)))
                }
                #[lanes]
                pub fn shl(self, b: U) -> Self {
                    Self(_mm256_sllv_epi32(self.0, _mm256_and_si256(b.0, _mm256_set1_epi32(31))))
                }
                #[lanes]
                pub fn eq(self, b: Self) -> M {
                    M(_mm256_castsi256_ps(_mm256_cmpeq_epi32(self.0, b.0)))
                }
                #[lanes]
                pub fn reverse_bits(self) -> Self {
                    // Bytes turned about, then each byte's halves looked up.
                    let turn = _mm256_setr_epi8(
                        3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12, 3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8,
                        15, 14, 13, 12,
                    );
                    let low = _mm256_setr_epi8(
                        0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15, 0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13,
                        3, 11, 7, 15,
                    );
                    let nibble = _mm256_set1_epi8(15);
                    let a = _mm256_shuffle_epi8(self.0, turn);
                    let first = _mm256_shuffle_epi8(low, _mm256_and_si256(a, nibble));
                    let second = _mm256_shuffle_epi8(low, _mm256_and_si256(_mm256_srli_epi32::<4>(a), nibble));
                    Self(_mm256_or_si256(_mm256_slli_epi32::<4>(first), second))
                }
            }
        };
    }
    integer!(I, i32);
    integer!(U, u32);

    impl I {
        #[lanes]
        pub fn min(self, b: Self) -> Self {
            Self(_mm256_min_epi32(self.0, b.0))
        }
        #[lanes]
        pub fn max(self, b: Self) -> Self {
            Self(_mm256_max_epi32(self.0, b.0))
        }
        #[lanes]
        pub fn lt(self, b: Self) -> M {
            M(_mm256_castsi256_ps(_mm256_cmpgt_epi32(b.0, self.0)))
        }
        #[lanes]
        pub fn shr(self, b: U) -> Self {
            Self(_mm256_srav_epi32(self.0, _mm256_and_si256(b.0, _mm256_set1_epi32(31))))
        }
        #[lanes]
        pub fn abs(self) -> Self {
            Self(_mm256_abs_epi32(self.0))
        }
        #[lanes]
        pub fn to_uint(self) -> U {
            U(self.0)
        }
        #[lanes]
        pub fn to_float(self) -> F {
            F(_mm256_cvtepi32_ps(self.0))
        }
        #[lanes]
        pub fn bits_float(self) -> F {
            F(_mm256_castsi256_ps(self.0))
        }
    }

    impl U {
        #[lanes]
        pub fn min(self, b: Self) -> Self {
            Self(_mm256_min_epu32(self.0, b.0))
        }
        #[lanes]
        pub fn max(self, b: Self) -> Self {
            Self(_mm256_max_epu32(self.0, b.0))
        }
        #[lanes]
        pub fn lt(self, b: Self) -> M {
            let flip = _mm256_set1_epi32(i32::MIN);
            M(_mm256_castsi256_ps(_mm256_cmpgt_epi32(_mm256_xor_si256(b.0, flip), _mm256_xor_si256(self.0, flip))))
        }
        #[lanes]
        pub fn shr(self, b: U) -> Self {
            Self(_mm256_srlv_epi32(self.0, _mm256_and_si256(b.0, _mm256_set1_epi32(31))))
        }
        #[lanes]
        pub fn abs(self) -> Self {
            self
        }
        #[lanes]
        pub fn to_int(self) -> I {
            I(self.0)
        }
        /// Both halves are exact, so that only their sum is rounded.
        #[lanes]
        pub fn to_float(self) -> F {
            let high = _mm256_cvtepi32_ps(_mm256_srli_epi32::<16>(self.0));
            let low = _mm256_cvtepi32_ps(_mm256_and_si256(self.0, _mm256_set1_epi32(0xffff)));
            F(_mm256_add_ps(_mm256_mul_ps(high, _mm256_set1_ps(65536.0)), low))
        }
        #[lanes]
        pub fn bits_float(self) -> F {
            F(_mm256_castsi256_ps(self.0))
        }
    }

    #[lanes]
    fn transpose(row: [__m128; LANES]) -> [__m256; 4] {
        let pair = [
            _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(row[0]), row[4]),
            _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(row[1]), row[5]),
            _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(row[2]), row[6]),
            _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(row[3]), row[7]),
        ];
        let low = [_mm256_unpacklo_ps(pair[0], pair[1]), _mm256_unpacklo_ps(pair[2], pair[3])];
        let high = [_mm256_unpackhi_ps(pair[0], pair[1]), _mm256_unpackhi_ps(pair[2], pair[3])];
        [
            _mm256_shuffle_ps::<0x44>(low[0], low[1]),
            _mm256_shuffle_ps::<0xee>(low[0], low[1]),
            _mm256_shuffle_ps::<0x44>(high[0], high[1]),
            _mm256_shuffle_ps::<0xee>(high[0], high[1]),
        ]
    }

    #[lanes]
    fn rows<T: bytemuck::Pod>(f: impl Fn(usize) -> T) -> [__m256; 4] {
        let row = |k| bytemuck::cast::<T, __m128>(f(k));
        transpose([row(0), row(1), row(2), row(3), row(4), row(5), row(6), row(7)])
    }
    #[lanes]
    fn four_floats(f: impl Fn(usize) -> glam::Vec4) -> V4<F> {
        let [x, y, z, w] = rows(f);
        V4 { x: F(x), y: F(y), z: F(z), w: F(w) }
    }
    #[lanes]
    fn four_ints(f: impl Fn(usize) -> glam::IVec4) -> V4<I> {
        let [x, y, z, w] = rows(f);
        let cast = |a| I(_mm256_castps_si256(a));
        V4 { x: cast(x), y: cast(y), z: cast(z), w: cast(w) }
    }
    #[lanes]
    fn four_uints(f: impl Fn(usize) -> glam::UVec4) -> V4<U> {
        let [x, y, z, w] = rows(f);
        let cast = |a| U(_mm256_castps_si256(a));
        V4 { x: cast(x), y: cast(y), z: cast(z), w: cast(w) }
    }
    #[lanes]
    fn each<T>(f: impl Fn(usize) -> T) -> [T; LANES] {
        [f(0), f(1), f(2), f(3), f(4), f(5), f(6), f(7)]
    }
