/// What WGSL's operators and built-in functions mean, one module per type. Every sum is written in the order in which
/// it is computed and nothing is contracted to a fused multiply-add, so that the bits are the same on every CPU.
pub mod wgsl {
    /// An index past the end reads the last element, as the bounds checks of a GPU do.
    #[inline(always)]
    pub fn index(i: usize, len: usize) -> usize {
        i.min(len.wrapping_sub(1))
    }

    pub mod float {
        #[inline(always)]
        pub fn abs(a: f32) -> f32 {
            a.abs()
        }
        // WGSL's own definition of min and max. std's leaves the sign of zero open and costs three instructions.
        #[inline(always)]
        pub fn min(a: f32, b: f32) -> f32 {
            if b < a { b } else { a }
        }
        #[inline(always)]
        pub fn max(a: f32, b: f32) -> f32 {
            if a < b { b } else { a }
        }
        #[inline(always)]
        pub fn clamp(a: f32, low: f32, high: f32) -> f32 {
            min(max(a, low), high)
        }
        #[inline(always)]
        pub fn saturate(a: f32) -> f32 {
            clamp(a, 0.0, 1.0)
        }
        #[inline(always)]
        pub fn ceil(a: f32) -> f32 {
            a.ceil()
        }
        #[inline(always)]
        pub fn floor(a: f32) -> f32 {
            a.floor()
        }
        #[inline(always)]
        pub fn round(a: f32) -> f32 {
            a.round_ties_even()
        }
        #[inline(always)]
        pub fn trunc(a: f32) -> f32 {
            a.trunc()
        }
        #[inline(always)]
        pub fn fract(a: f32) -> f32 {
            a - a.floor()
        }
        #[inline(always)]
        pub fn sign(a: f32) -> f32 {
            if a > 0.0 {
                1.0
            } else if a < 0.0 {
                -1.0
            } else {
                0.0
            }
        }
        #[inline(always)]
        pub fn fma(a: f32, b: f32, c: f32) -> f32 {
            a.mul_add(b, c)
        }
        #[inline(always)]
        pub fn mix(a: f32, b: f32, t: f32) -> f32 {
            a * (1.0 - t) + b * t
        }
        #[inline(always)]
        pub fn step(edge: f32, a: f32) -> f32 {
            if edge <= a { 1.0 } else { 0.0 }
        }
        #[inline(always)]
        pub fn smoothstep(low: f32, high: f32, a: f32) -> f32 {
            let t = saturate((a - low) / (high - low));
            t * t * (3.0 - 2.0 * t)
        }
        #[inline(always)]
        pub fn sqrt(a: f32) -> f32 {
            a.sqrt()
        }
        #[inline(always)]
        pub fn inverse_sqrt(a: f32) -> f32 {
            1.0 / a.sqrt()
        }
        #[inline(always)]
        pub fn radians(a: f32) -> f32 {
            a * 0.017_453_292_f32
        }
        #[inline(always)]
        pub fn degrees(a: f32) -> f32 {
            a * 57.295_78_f32
        }
        #[inline(always)]
        pub fn rem(a: f32, b: f32) -> f32 {
            a - b * (a / b).trunc()
        }
        #[inline(always)]
        pub fn quantize_to_f16(a: f32) -> f32 {
            super::pack::f32_from_f16(super::pack::f16_from_f32(a))
        }
        #[inline(always)]
        pub fn length(a: f32) -> f32 {
            a.abs()
        }
        #[inline(always)]
        pub fn distance(a: f32, b: f32) -> f32 {
            (a - b).abs()
        }
    }

    macro_rules! integer {
        ($name:ident, $T:ident, $U:ident) => {
            pub mod $name {
                #[inline(always)]
                pub fn add(a: $T, b: $T) -> $T {
                    a.wrapping_add(b)
                }
                #[inline(always)]
                pub fn sub(a: $T, b: $T) -> $T {
                    a.wrapping_sub(b)
                }
                #[inline(always)]
                pub fn mul(a: $T, b: $T) -> $T {
                    a.wrapping_mul(b)
                }
                #[inline(always)]
                pub fn div(a: $T, b: $T) -> $T {
                    if b == 0 { a } else { a.wrapping_div(b) }
                }
                #[inline(always)]
                pub fn rem(a: $T, b: $T) -> $T {
                    if b == 0 { 0 } else { a.wrapping_rem(b) }
                }
                #[inline(always)]
                pub fn neg(a: $T) -> $T {
                    a.wrapping_neg()
                }
                #[inline(always)]
                pub fn shl(a: $T, b: u32) -> $T {
                    a.wrapping_shl(b)
                }
                #[inline(always)]
                pub fn shr(a: $T, b: u32) -> $T {
                    a.wrapping_shr(b)
                }
                #[inline(always)]
                pub fn min(a: $T, b: $T) -> $T {
                    a.min(b)
                }
                #[inline(always)]
                pub fn max(a: $T, b: $T) -> $T {
                    a.max(b)
                }
                #[inline(always)]
                pub fn clamp(a: $T, low: $T, high: $T) -> $T {
                    a.max(low).min(high)
                }
                #[inline(always)]
                pub fn count_one_bits(a: $T) -> $T {
                    a.count_ones() as $T
                }
                #[inline(always)]
                pub fn count_leading_zeros(a: $T) -> $T {
                    a.leading_zeros() as $T
                }
                #[inline(always)]
                pub fn count_trailing_zeros(a: $T) -> $T {
                    a.trailing_zeros() as $T
                }
                #[inline(always)]
                pub fn reverse_bits(a: $T) -> $T {
                    a.reverse_bits()
                }
                #[inline(always)]
                pub fn first_trailing_bit(a: $T) -> $T {
                    if a == 0 { !0 } else { a.trailing_zeros() as $T }
                }
                #[inline(always)]
                pub fn extract_bits(a: $T, offset: u32, count: u32) -> $T {
                    let offset = offset.min(32);
                    let count = count.min(32 - offset);
                    if count == 0 { 0 } else { (a << (32 - offset - count)) >> (32 - count) }
                }
                #[inline(always)]
                pub fn insert_bits(a: $T, bits: $T, offset: u32, count: u32) -> $T {
                    let offset = offset.min(32);
                    let count = count.min(32 - offset);
                    if count == 0 {
                        return a;
                    }
                    let mask = ((u32::MAX >> (32 - count)) << offset) as $T;
                    (a & !mask) | ((bits << offset) & mask)
                }
                #[inline(always)]
                pub fn abs(a: $T) -> $T {
                    $U::abs(a)
                }
                #[inline(always)]
                pub fn sign(a: $T) -> $T {
                    $U::sign(a)
                }
                #[inline(always)]
                pub fn first_leading_bit(a: $T) -> $T {
                    $U::first_leading_bit(a)
                }
                use super::$U;
            }
        };
    }
    mod signed {
        #[inline(always)]
        pub fn abs(a: i32) -> i32 {
            a.wrapping_abs()
        }
        #[inline(always)]
        pub fn sign(a: i32) -> i32 {
            a.signum()
        }
        #[inline(always)]
        pub fn first_leading_bit(a: i32) -> i32 {
            super::unsigned::first_leading_bit((a ^ (a >> 31)) as u32) as i32
        }
    }
    mod unsigned {
        #[inline(always)]
        pub fn abs(a: u32) -> u32 {
            a
        }
        #[inline(always)]
        pub fn sign(a: u32) -> u32 {
            a.min(1)
        }
        #[inline(always)]
        pub fn first_leading_bit(a: u32) -> u32 {
            if a == 0 { u32::MAX } else { 31 - a.leading_zeros() }
        }
    }
    integer!(int, i32, signed);
    integer!(uint, u32, unsigned);

    /// Access by lane, comparison and selection.
    macro_rules! vector {
        ($V:ident, $B:ident, $S:ty, [$($c:ident $i:literal),+] $last:ident) => {
            #[inline(always)]
            pub fn at(a: $V, i: usize) -> $S {
                match i {
                    $($i => a.$c,)+
                    _ => a.$last,
                }
            }
            #[inline(always)]
            pub fn at_mut(a: &mut $V, i: usize) -> &mut $S {
                match i {
                    $($i => &mut a.$c,)+
                    _ => &mut a.$last,
                }
            }
            #[inline(always)]
            pub fn eq(a: $V, b: $V) -> $B {
                $B::new($(a.$c == b.$c),+)
            }
            #[inline(always)]
            pub fn ne(a: $V, b: $V) -> $B {
                $B::new($(a.$c != b.$c),+)
            }
            #[inline(always)]
            pub fn select(reject: $V, accept: $V, condition: $B) -> $V {
                $V::new($(if condition.$c { accept.$c } else { reject.$c }),+)
            }
        };
    }

    /// Order, and a scalar function lifted to every lane.
    macro_rules! numeric {
        ($V:ident, $B:ident, $S:ty, [$($c:ident $i:literal),+]) => {
            #[inline(always)]
            pub fn lt(a: $V, b: $V) -> $B {
                $B::new($(a.$c < b.$c),+)
            }
            #[inline(always)]
            pub fn le(a: $V, b: $V) -> $B {
                $B::new($(a.$c <= b.$c),+)
            }
            #[inline(always)]
            pub fn gt(a: $V, b: $V) -> $B {
                $B::new($(a.$c > b.$c),+)
            }
            #[inline(always)]
            pub fn ge(a: $V, b: $V) -> $B {
                $B::new($(a.$c >= b.$c),+)
            }
            #[inline(always)]
            fn map(a: $V, f: impl Fn($S) -> $S) -> $V {
                $V::new($(f(a.$c)),+)
            }
            #[inline(always)]
            fn zip(a: $V, b: $V, f: impl Fn($S, $S) -> $S) -> $V {
                $V::new($(f(a.$c, b.$c)),+)
            }
            #[inline(always)]
            fn zip3(a: $V, b: $V, c: $V, f: impl Fn($S, $S, $S) -> $S) -> $V {
                $V::new($(f(a.$c, b.$c, c.$c)),+)
            }
        };
    }

    macro_rules! lift {
        ($V:ident, $s:ident, [$($one:ident)*], [$($two:ident)*], [$($three:ident)*]) => {
            $(#[inline(always)]
            pub fn $one(a: $V) -> $V {
                map(a, super::$s::$one)
            })*
            $(#[inline(always)]
            pub fn $two(a: $V, b: $V) -> $V {
                zip(a, b, super::$s::$two)
            })*
            $(#[inline(always)]
            pub fn $three(a: $V, b: $V, c: $V) -> $V {
                zip3(a, b, c, super::$s::$three)
            })*
        };
    }

    macro_rules! float_vector {
        ($name:ident, $V:ident, $I:ident, $U:ident, $B:ident, $as_int:ident, $as_uint:ident, [$c0:ident $i0:literal $(, $c:ident $i:literal)+] $last:ident) => {
            pub mod $name {
                use glam::{$B, $I, $U, $V};
                vector!($V, $B, f32, [$c0 $i0 $(, $c $i)+] $last);
                numeric!($V, $B, f32, [$c0 $i0 $(, $c $i)+]);
                lift!(
                    $V,
                    float,
                    [abs saturate ceil floor round trunc fract sign sqrt inverse_sqrt radians degrees quantize_to_f16],
                    [min max step rem],
                    [clamp fma mix smoothstep]
                );
                #[inline(always)]
                pub fn dot(a: $V, b: $V) -> f32 {
                    a.$c0 * b.$c0 $(+ a.$c * b.$c)+
                }
                #[inline(always)]
                pub fn length(a: $V) -> f32 {
                    dot(a, a).sqrt()
                }
                #[inline(always)]
                pub fn distance(a: $V, b: $V) -> f32 {
                    length(a - b)
                }
                #[inline(always)]
                pub fn normalize(a: $V) -> $V {
                    a * (1.0 / length(a))
                }
                #[inline(always)]
                pub fn reflect(a: $V, normal: $V) -> $V {
                    a - normal * (2.0 * dot(normal, a))
                }
                #[inline(always)]
                pub fn refract(a: $V, normal: $V, eta: f32) -> $V {
                    let cosine = dot(normal, a);
                    let k = 1.0 - eta * eta * (1.0 - cosine * cosine);
                    if k < 0.0 { $V::ZERO } else { a * eta - normal * (eta * cosine + k.sqrt()) }
                }
                #[inline(always)]
                pub fn face_forward(a: $V, b: $V, normal: $V) -> $V {
                    if dot(b, normal) < 0.0 { a } else { -a }
                }
                #[inline(always)]
                pub fn to_int(a: $V) -> $I {
                    a.$as_int()
                }
                #[inline(always)]
                pub fn to_uint(a: $V) -> $U {
                    a.$as_uint()
                }
                #[inline(always)]
                pub fn to_bool(a: $V) -> $B {
                    ne(a, $V::ZERO)
                }
                #[inline(always)]
                pub fn bits_int(a: $V) -> $I {
                    $I::new(a.$c0.to_bits() as i32 $(, a.$c.to_bits() as i32)+)
                }
                #[inline(always)]
                pub fn bits_uint(a: $V) -> $U {
                    $U::new(a.$c0.to_bits() $(, a.$c.to_bits())+)
                }
            }
        };
    }
    float_vector!(vec2, Vec2, IVec2, UVec2, BVec2, as_ivec2, as_uvec2, [x 0, y 1] y);
    float_vector!(vec3, Vec3, IVec3, UVec3, BVec3, as_ivec3, as_uvec3, [x 0, y 1, z 2] z);
    float_vector!(vec4, Vec4, IVec4, UVec4, BVec4, as_ivec4, as_uvec4, [x 0, y 1, z 2, w 3] w);

    #[inline(always)]
    pub fn cross(a: glam::Vec3, b: glam::Vec3) -> glam::Vec3 {
        glam::Vec3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
    }

    macro_rules! int_vector {
        ($name:ident, $V:ident, $S:ident, $s:ident, $F:ident, $B:ident, $U:ident, $as_float:ident, $to_other:ident, $as_other:ident, $Other:ident, [$c0:ident $i0:literal $(, $c:ident $i:literal)+] $last:ident) => {
            pub mod $name {
                use glam::{$B, $F, IVec2, IVec3, IVec4, UVec2, UVec3, UVec4};
                vector!($V, $B, $S, [$c0 $i0 $(, $c $i)+] $last);
                numeric!($V, $B, $S, [$c0 $i0 $(, $c $i)+]);
                lift!(
                    $V,
                    $s,
                    [abs sign neg count_one_bits count_leading_zeros count_trailing_zeros reverse_bits first_leading_bit first_trailing_bit],
                    [add sub mul div rem min max],
                    [clamp]
                );
                #[inline(always)]
                pub fn shl(a: $V, b: $U) -> $V {
                    $V::new(a.$c0.wrapping_shl(b.$c0) $(, a.$c.wrapping_shl(b.$c))+)
                }
                #[inline(always)]
                pub fn shr(a: $V, b: $U) -> $V {
                    $V::new(a.$c0.wrapping_shr(b.$c0) $(, a.$c.wrapping_shr(b.$c))+)
                }
                #[inline(always)]
                pub fn dot(a: $V, b: $V) -> $S {
                    a.$c0.wrapping_mul(b.$c0)$(.wrapping_add(a.$c.wrapping_mul(b.$c)))+
                }
                #[inline(always)]
                pub fn extract_bits(a: $V, offset: u32, count: u32) -> $V {
                    map(a, |a| super::$s::extract_bits(a, offset, count))
                }
                #[inline(always)]
                pub fn insert_bits(a: $V, bits: $V, offset: u32, count: u32) -> $V {
                    zip(a, bits, |a, bits| super::$s::insert_bits(a, bits, offset, count))
                }
                #[inline(always)]
                pub fn to_float(a: $V) -> $F {
                    a.$as_float()
                }
                #[inline(always)]
                pub fn $to_other(a: $V) -> $Other {
                    a.$as_other()
                }
                #[inline(always)]
                pub fn to_bool(a: $V) -> $B {
                    ne(a, $V::ZERO)
                }
                #[inline(always)]
                pub fn bits_float(a: $V) -> $F {
                    $F::new(f32::from_bits(a.$c0 as u32) $(, f32::from_bits(a.$c as u32))+)
                }
            }
        };
    }
    int_vector!(ivec2, IVec2, i32, int, Vec2, BVec2, UVec2, as_vec2, to_uint, as_uvec2, UVec2, [x 0, y 1] y);
    int_vector!(ivec3, IVec3, i32, int, Vec3, BVec3, UVec3, as_vec3, to_uint, as_uvec3, UVec3, [x 0, y 1, z 2] z);
    int_vector!(ivec4, IVec4, i32, int, Vec4, BVec4, UVec4, as_vec4, to_uint, as_uvec4, UVec4, [x 0, y 1, z 2, w 3] w);
    int_vector!(uvec2, UVec2, u32, uint, Vec2, BVec2, UVec2, as_vec2, to_int, as_ivec2, IVec2, [x 0, y 1] y);
    int_vector!(uvec3, UVec3, u32, uint, Vec3, BVec3, UVec3, as_vec3, to_int, as_ivec3, IVec3, [x 0, y 1, z 2] z);
    int_vector!(uvec4, UVec4, u32, uint, Vec4, BVec4, UVec4, as_vec4, to_int, as_ivec4, IVec4, [x 0, y 1, z 2, w 3] w);

    macro_rules! bool_vector {
        ($name:ident, $B:ident, $F:ident, $I:ident, $U:ident, [$($c:ident $i:literal),+] $last:ident) => {
            pub mod $name {
                use glam::{$B, $F, $I, $U};
                vector!($B, $B, bool, [$($c $i),+] $last);
                #[inline(always)]
                pub fn to_float(a: $B) -> $F {
                    $F::new($(if a.$c { 1.0 } else { 0.0 }),+)
                }
                #[inline(always)]
                pub fn to_int(a: $B) -> $I {
                    $I::new($(a.$c as i32),+)
                }
                #[inline(always)]
                pub fn to_uint(a: $B) -> $U {
                    $U::new($(a.$c as u32),+)
                }
            }
        };
    }
    bool_vector!(bvec2, BVec2, Vec2, IVec2, UVec2, [x 0, y 1] y);
    bool_vector!(bvec3, BVec3, Vec3, IVec3, UVec3, [x 0, y 1, z 2] z);
    bool_vector!(bvec4, BVec4, Vec4, IVec4, UVec4, [x 0, y 1, z 2, w 3] w);

    macro_rules! matrix {
        ($name:ident, $M:ident, $V:ident, $v:ident, [$c0:ident $a0:ident $i0:literal $(, $c:ident $a:ident $i:literal)+] $last:ident) => {
            pub mod $name {
                use glam::{$M, $V};
                #[inline(always)]
                pub fn at(m: $M, i: usize) -> $V {
                    match i {
                        $i0 => m.$a0,
                        $($i => m.$a,)+
                        _ => m.$last,
                    }
                }
                #[inline(always)]
                pub fn at_mut(m: &mut $M, i: usize) -> &mut $V {
                    match i {
                        $i0 => &mut m.$a0,
                        $($i => &mut m.$a,)+
                        _ => &mut m.$last,
                    }
                }
                #[inline(always)]
                pub fn mul_vector(m: $M, v: $V) -> $V {
                    m.$a0 * v.$c0 $(+ m.$a * v.$c)+
                }
                #[inline(always)]
                pub fn vector_mul(v: $V, m: $M) -> $V {
                    $V::new(super::$v::dot(v, m.$a0) $(, super::$v::dot(v, m.$a))+)
                }
                #[inline(always)]
                pub fn mul(m: $M, n: $M) -> $M {
                    $M::from_cols(mul_vector(m, n.$a0) $(, mul_vector(m, n.$a))+)
                }
                #[inline(always)]
                pub fn scale(m: $M, s: f32) -> $M {
                    $M::from_cols(m.$a0 * s $(, m.$a * s)+)
                }
                #[inline(always)]
                pub fn add(m: $M, n: $M) -> $M {
                    $M::from_cols(m.$a0 + n.$a0 $(, m.$a + n.$a)+)
                }
                #[inline(always)]
                pub fn sub(m: $M, n: $M) -> $M {
                    $M::from_cols(m.$a0 - n.$a0 $(, m.$a - n.$a)+)
                }
                #[inline(always)]
                pub fn neg(m: $M) -> $M {
                    $M::from_cols(-m.$a0 $(, -m.$a)+)
                }
                #[inline(always)]
                pub fn transpose(m: $M) -> $M {
                    m.transpose()
                }
                #[inline(always)]
                pub fn determinant(m: $M) -> f32 {
                    super::determinant::$name(m)
                }
            }
        };
    }
    matrix!(mat2, Mat2, Vec2, vec2, [x x_axis 0, y y_axis 1] y_axis);
    matrix!(mat3, Mat3, Vec3, vec3, [x x_axis 0, y y_axis 1, z z_axis 2] z_axis);
    matrix!(mat4, Mat4, Vec4, vec4, [x x_axis 0, y y_axis 1, z z_axis 2, w w_axis 3] w_axis);

    mod determinant {
        use glam::{Mat2, Mat3, Mat4};
        #[inline]
        pub fn mat2(m: Mat2) -> f32 {
            m.x_axis.x * m.y_axis.y - m.x_axis.y * m.y_axis.x
        }
        #[inline]
        pub fn mat3(m: Mat3) -> f32 {
            super::vec3::dot(m.x_axis, super::cross(m.y_axis, m.z_axis))
        }
        #[inline]
        pub fn mat4(m: Mat4) -> f32 {
            let (a, b, c, d) = (m.x_axis, m.y_axis, m.z_axis, m.w_axis);
            let low = [a.x * b.y - a.y * b.x, a.x * c.y - a.y * c.x, a.x * d.y - a.y * d.x];
            let low = [low[0], low[1], low[2], b.x * c.y - b.y * c.x, b.x * d.y - b.y * d.x, c.x * d.y - c.y * d.x];
            let high = [c.z * d.w - c.w * d.z, b.z * d.w - b.w * d.z, b.z * c.w - b.w * c.z];
            let high = [high[0], high[1], high[2], a.z * d.w - a.w * d.z, a.z * c.w - a.w * c.z, a.z * b.w - a.w * b.z];
            low[0] * high[0] - low[1] * high[1] + low[2] * high[2] + low[3] * high[3] - low[4] * high[4]
                + low[5] * high[5]
        }
    }

    pub mod pack {
        use glam::{Vec2, Vec4};

        /// IEEE 754 binary16, rounded to nearest even.
        #[inline]
        pub fn f16_from_f32(a: f32) -> u32 {
            let bits = a.to_bits();
            let sign = (bits >> 16) & 0x8000;
            let magnitude = bits & 0x7fff_ffff;
            if magnitude > 0x7f80_0000 {
                return sign | 0x7e00;
            }
            if magnitude >= 0x4780_0000 {
                return sign | 0x7c00;
            }
            if magnitude < 0x3880_0000 {
                // A subnormal half counts in units of 2^-24: adding 0.5 leaves them, rounded, in the low bits.
                return sign | (f32::from_bits(magnitude) + 0.5).to_bits().wrapping_sub(0x3f00_0000);
            }
            let odd = (magnitude >> 13) & 1;
            sign | (magnitude.wrapping_sub(0x3800_0000).wrapping_add(0xfff).wrapping_add(odd) >> 13)
        }
        #[inline]
        pub fn f32_from_f16(bits: u32) -> f32 {
            let sign = (bits & 0x8000) << 16;
            let magnitude = bits & 0x7fff;
            if magnitude >= 0x7c00 {
                return f32::from_bits(sign | 0x7f80_0000 | ((magnitude & 0x3ff) << 13));
            }
            if magnitude < 0x400 {
                return f32::from_bits(sign | (magnitude as f32 * (1.0 / 16_777_216.0)).to_bits());
            }
            f32::from_bits(sign | ((magnitude << 13) + 0x3800_0000))
        }
        #[inline(always)]
        fn unorm(a: f32, scale: f32) -> u32 {
            (0.5 + scale * super::float::saturate(a)).floor() as u32
        }
        #[inline(always)]
        fn snorm(a: f32, scale: f32) -> u32 {
            (0.5 + scale * super::float::clamp(a, -1.0, 1.0)).floor() as i32 as u32
        }
        #[inline]
        pub fn pack_4x8_unorm(a: Vec4) -> u32 {
            let lane = |a: f32| unorm(a, 255.0);
            lane(a.x) | lane(a.y) << 8 | lane(a.z) << 16 | lane(a.w) << 24
        }
        #[inline]
        pub fn pack_4x8_snorm(a: Vec4) -> u32 {
            let lane = |a: f32| snorm(a, 127.0) & 0xff;
            lane(a.x) | lane(a.y) << 8 | lane(a.z) << 16 | lane(a.w) << 24
        }
        #[inline]
        pub fn pack_2x16_unorm(a: Vec2) -> u32 {
            unorm(a.x, 65535.0) | unorm(a.y, 65535.0) << 16
        }
        #[inline]
        pub fn pack_2x16_snorm(a: Vec2) -> u32 {
            (snorm(a.x, 32767.0) & 0xffff) | snorm(a.y, 32767.0) << 16
        }
        #[inline]
        pub fn pack_2x16_float(a: Vec2) -> u32 {
            f16_from_f32(a.x) | f16_from_f32(a.y) << 16
        }
        #[inline]
        pub fn unpack_4x8_unorm(a: u32) -> Vec4 {
            let lane = |shift: u32| ((a >> shift) & 0xff) as f32 / 255.0;
            Vec4::new(lane(0), lane(8), lane(16), lane(24))
        }
        #[inline]
        pub fn unpack_4x8_snorm(a: u32) -> Vec4 {
            let lane = |shift: u32| super::float::max(((a >> shift) as i8) as f32 / 127.0, -1.0);
            Vec4::new(lane(0), lane(8), lane(16), lane(24))
        }
        #[inline]
        pub fn unpack_2x16_unorm(a: u32) -> Vec2 {
            Vec2::new((a & 0xffff) as f32 / 65535.0, (a >> 16) as f32 / 65535.0)
        }
        #[inline]
        pub fn unpack_2x16_snorm(a: u32) -> Vec2 {
            let lane = |shift: u32| super::float::max(((a >> shift) as i16) as f32 / 32767.0, -1.0);
            Vec2::new(lane(0), lane(16))
        }
        #[inline]
        pub fn unpack_2x16_float(a: u32) -> Vec2 {
            Vec2::new(f32_from_f16(a & 0xffff), f32_from_f16(a >> 16))
        }
    }
}
