
    // What follows knows neither the number of lanes nor the registers.

    /// A vector of two, such as `V2<F>`; also a matrix, as its columns.
    #[derive(Clone, Copy)]
    pub struct V2<T> {
        pub x: T,
        pub y: T,
    }
    /// A vector of three.
    #[derive(Clone, Copy)]
    pub struct V3<T> {
        pub x: T,
        pub y: T,
        pub z: T,
    }
    /// A vector of four.
    #[derive(Clone, Copy)]
    pub struct V4<T> {
        pub x: T,
        pub y: T,
        pub z: T,
        pub w: T,
    }

    use super::wgsl;

    /// A slice and an index a lane, each past the end made the last.
    pub struct Rows<'a, T> {
        slice: &'a [T],
        index: [u32; LANES],
    }
    impl<'a, T> Rows<'a, T> {
        #[lanes]
        pub fn new(slice: &'a [T], index: U) -> Self {
            assert!(!slice.is_empty(), "a read of an empty slice");
            let last = u32::try_from(slice.len() - 1).unwrap_or(u32::MAX);
            Self { slice, index: index.min(U::splat(last)).to_array() }
        }
        /// The element of lane `k` below `LANES`.
        #[lanes]
        pub fn at(&self, k: usize) -> &'a T {
            let index = self.index[k % LANES] as usize;
            // SAFETY: `new` made every index one of the slice.
            unsafe { self.slice.get_unchecked(index) }
        }
    }

    /// Four elements of a slice from an index on for each lane of `mask`, each past the end made the last.
    #[lanes]
    pub fn fours(mask: M, slice: &[u32], index: U) -> V4<U> {
        let last = u32::try_from(slice.len().saturating_sub(4)).unwrap_or(u32::MAX);
        let inside = index.le(U::splat(last));
        if slice.len() >= 4 && mask.and_not(inside).none() {
            let index = index.min(U::splat(last)).to_array();
            // SAFETY: every index leaves three elements behind it.
            let four = |k: usize| unsafe { slice.as_ptr().add(index[k % LANES] as usize).cast::<[u32; 4]>().read() };
            return V4::<U>::gather(|k| glam::UVec4::from_array(four(k)));
        }
        let element = |i: u32| {
            let rows = Rows::new(slice, index.add(U::splat(i)));
            U::gather(|k| *rows.at(k))
        };
        V4 { x: element(0), y: element(1), z: element(2), w: element(3) }
    }

    /// The index that all lanes of `mask` have, made the last of `count` where it is past the end.
    #[lanes]
    fn shared(mask: M, index: U, count: usize) -> Option<usize> {
        let first = index.get(mask.bits().trailing_zeros() as usize);
        mask.and_not(index.eq(U::splat(first))).none().then(|| (first as usize).min(count - 1))
    }

    /// An element of a long array for each lane of `mask`.
    #[lanes]
    pub fn pick<const N: usize>(array: &[F; N], index: U, mask: M) -> F {
        if let Some(all) = shared(mask, index, N) {
            return array[all];
        }
        let mut value = array[N - 1];
        for (i, element) in array.iter().enumerate().take(N - 1) {
            value = F::select(index.eq(U::splat(i as u32)), *element, value);
        }
        value
    }

    /// Stores into a long array for each lane of `mask`.
    #[lanes]
    pub fn put<const N: usize>(array: &mut [F; N], index: U, mask: M, value: F) {
        if let Some(all) = shared(mask, index, N) {
            array[all] = F::select(mask, value, array[all]);
            return;
        }
        let index = index.min(U::splat(N as u32 - 1));
        for (i, element) in array.iter_mut().enumerate() {
            *element = F::select(mask.and(index.eq(U::splat(i as u32))), value, *element);
        }
    }

    impl M {
        #[lanes]
        pub fn not(self) -> Self {
            Self::splat(true).and_not(self)
        }
        #[lanes]
        pub fn any(self) -> bool {
            self.bits() != 0
        }
        #[lanes]
        pub fn none(self) -> bool {
            self.bits() == 0
        }
        #[lanes]
        pub fn eq(self, b: Self) -> Self {
            self.xor(b).not()
        }
        #[lanes]
        pub fn ne(self, b: Self) -> Self {
            self.xor(b)
        }
        #[lanes]
        pub fn get(self, k: usize) -> bool {
            self.bits() >> k & 1 == 1
        }
        #[lanes]
        pub fn gather(f: impl Fn(usize) -> bool) -> Self {
            let bits = each(|k| u32::from(f(k)) << k);
            Self::from_bits(bits.into_iter().fold(0, |sum, bit| sum | bit))
        }
        #[lanes]
        pub fn to_float(self) -> F {
            F::select(self, F::splat(1.0), F::splat(0.0))
        }
        #[lanes]
        pub fn to_int(self) -> I {
            I::select(self, I::splat(1), I::splat(0))
        }
        #[lanes]
        pub fn to_uint(self) -> U {
            U::select(self, U::splat(1), U::splat(0))
        }
    }

    impl F {
        #[lanes]
        pub fn get(self, k: usize) -> f32 {
            self.to_array()[k % LANES]
        }
        #[lanes]
        pub fn gather(f: impl Fn(usize) -> f32) -> Self {
            Self::from_array(each(f))
        }
        #[lanes]
        fn map(self, f: impl Fn(f32) -> f32) -> Self {
            let a = self.to_array();
            Self::from_array(each(|k| f(a[k])))
        }
        #[lanes]
        pub fn clamp(self, low: Self, high: Self) -> Self {
            self.max(low).min(high)
        }
        #[lanes]
        pub fn saturate(self) -> Self {
            self.clamp(Self::splat(0.0), Self::splat(1.0))
        }
        #[lanes]
        pub fn fract(self) -> Self {
            self.sub(self.floor())
        }
        #[lanes]
        pub fn sign(self) -> Self {
            let zero = Self::splat(0.0);
            let below = Self::select(self.lt(zero), Self::splat(-1.0), zero);
            Self::select(self.gt(zero), Self::splat(1.0), below)
        }
        #[lanes]
        pub fn fma(self, b: Self, c: Self) -> Self {
            let (a, b, c) = (self.to_array(), b.to_array(), c.to_array());
            Self::from_array(each(|k| a[k].mul_add(b[k], c[k])))
        }
        #[lanes]
        pub fn mix(self, b: Self, t: Self) -> Self {
            self.mul(Self::splat(1.0).sub(t)).add(b.mul(t))
        }
        /// `step(self, a)`
        #[lanes]
        pub fn step(self, a: Self) -> Self {
            Self::select(self.le(a), Self::splat(1.0), Self::splat(0.0))
        }
        /// `smoothstep(self, high, a)`
        #[lanes]
        pub fn smoothstep(self, high: Self, a: Self) -> Self {
            let t = a.sub(self).div(high.sub(self)).saturate();
            t.mul(t).mul(Self::splat(3.0).sub(Self::splat(2.0).mul(t)))
        }
        #[lanes]
        pub fn inverse_sqrt(self) -> Self {
            Self::splat(1.0).div(self.sqrt())
        }
        #[lanes]
        pub fn radians(self) -> Self {
            self.mul(Self::splat(0.017_453_292_f32))
        }
        #[lanes]
        pub fn degrees(self) -> Self {
            self.mul(Self::splat(57.295_78_f32))
        }
        #[lanes]
        pub fn rem(self, b: Self) -> Self {
            self.sub(b.mul(self.div(b).trunc()))
        }
        #[lanes]
        pub fn quantize_to_f16(self) -> Self {
            self.map(wgsl::float::quantize_to_f16)
        }
        #[lanes]
        pub fn length(self) -> Self {
            self.abs()
        }
        #[lanes]
        pub fn distance(self, b: Self) -> Self {
            self.sub(b).abs()
        }
        #[lanes]
        pub fn to_bool(self) -> M {
            self.ne(Self::splat(0.0))
        }
    }

    macro_rules! whole {
        ($T:ident, $t:ident, $module:ident) => {
            impl $T {
                #[lanes]
                pub fn get(self, k: usize) -> $t {
                    self.to_array()[k % LANES]
                }
                #[lanes]
                pub fn gather(f: impl Fn(usize) -> $t) -> Self {
                    Self::from_array(each(f))
                }
                #[lanes]
                fn map(self, f: impl Fn($t) -> $t) -> Self {
                    let a = self.to_array();
                    Self::from_array(each(|k| f(a[k])))
                }
                #[lanes]
                fn zip(self, b: Self, f: impl Fn($t, $t) -> $t) -> Self {
                    let (a, b) = (self.to_array(), b.to_array());
                    Self::from_array(each(|k| f(a[k], b[k])))
                }
                #[lanes]
                pub fn ne(self, b: Self) -> M {
                    self.eq(b).not()
                }
                #[lanes]
                pub fn gt(self, b: Self) -> M {
                    b.lt(self)
                }
                #[lanes]
                pub fn le(self, b: Self) -> M {
                    b.lt(self).not()
                }
                #[lanes]
                pub fn ge(self, b: Self) -> M {
                    self.lt(b).not()
                }
                #[lanes]
                pub fn div(self, b: Self) -> Self {
                    self.zip(b, wgsl::$module::div)
                }
                #[lanes]
                pub fn rem(self, b: Self) -> Self {
                    self.zip(b, wgsl::$module::rem)
                }
                #[lanes]
                pub fn clamp(self, low: Self, high: Self) -> Self {
                    self.max(low).min(high)
                }
                #[lanes]
                pub fn sign(self) -> Self {
                    self.map(wgsl::$module::sign)
                }
                #[lanes]
                pub fn count_one_bits(self) -> Self {
                    self.map(wgsl::$module::count_one_bits)
                }
                #[lanes]
                pub fn count_leading_zeros(self) -> Self {
                    self.map(wgsl::$module::count_leading_zeros)
                }
                #[lanes]
                pub fn count_trailing_zeros(self) -> Self {
                    self.map(wgsl::$module::count_trailing_zeros)
                }
                #[lanes]
                pub fn first_leading_bit(self) -> Self {
                    self.map(wgsl::$module::first_leading_bit)
                }
                #[lanes]
                pub fn first_trailing_bit(self) -> Self {
                    self.map(wgsl::$module::first_trailing_bit)
                }
                #[lanes]
                pub fn extract_bits(self, offset: U, count: U) -> Self {
                    let (a, offset, count) = (self.to_array(), offset.to_array(), count.to_array());
                    Self::from_array(each(|k| wgsl::$module::extract_bits(a[k], offset[k], count[k])))
                }
                #[lanes]
                pub fn insert_bits(self, bits: Self, offset: U, count: U) -> Self {
                    let (a, bits) = (self.to_array(), bits.to_array());
                    let (offset, count) = (offset.to_array(), count.to_array());
                    Self::from_array(each(|k| wgsl::$module::insert_bits(a[k], bits[k], offset[k], count[k])))
                }
                #[lanes]
                pub fn to_bool(self) -> M {
                    self.ne(Self::splat(0))
                }
            }
        };
    }
    whole!(I, i32, int);
    whole!(U, u32, uint);
    impl U {
        #[lanes]
        pub fn bits_uint(self) -> U {
            self
        }
    }
    impl I {
        #[lanes]
        pub fn bits_uint(self) -> U {
            self.to_uint()
        }
    }

    // Vectors against glam's.
    macro_rules! vector {
        ($V:ident, $T:ident, $G:ident, [$($c:ident),+]) => {
            impl $V<$T> {
                #[lanes]
                pub fn splat(a: glam::$G) -> Self {
                    Self { $($c: $T::splat(a.$c)),+ }
                }
                #[lanes]
                pub fn get(self, k: usize) -> glam::$G {
                    glam::$G::new($(self.$c.get(k)),+)
                }
                #[lanes]
                pub fn select(m: M, accept: Self, reject: Self) -> Self {
                    Self { $($c: $T::select(m, accept.$c, reject.$c)),+ }
                }
            }
        };
    }
    macro_rules! gather {
        ($V:ident, $T:ident, $G:ident, [$($c:ident),+]) => {
            impl $V<$T> {
                #[lanes]
                pub fn gather(f: impl Fn(usize) -> glam::$G) -> Self {
                    Self { $($c: $T::gather(|k| f(k).$c)),+ }
                }
            }
        };
        ($V:ident, $T:ident, $G:ident, $four:ident) => {
            impl $V<$T> {
                #[lanes]
                pub fn gather(f: impl Fn(usize) -> glam::$G) -> Self {
                    $four(f)
                }
            }
        };
    }
    vector!(V2, F, Vec2, [x, y]);
    vector!(V3, F, Vec3, [x, y, z]);
    vector!(V4, F, Vec4, [x, y, z, w]);
    vector!(V2, I, IVec2, [x, y]);
    vector!(V3, I, IVec3, [x, y, z]);
    vector!(V4, I, IVec4, [x, y, z, w]);
    vector!(V2, U, UVec2, [x, y]);
    vector!(V3, U, UVec3, [x, y, z]);
    vector!(V4, U, UVec4, [x, y, z, w]);
    vector!(V2, M, BVec2, [x, y]);
    vector!(V3, M, BVec3, [x, y, z]);
    vector!(V4, M, BVec4, [x, y, z, w]);
    gather!(V2, F, Vec2, [x, y]);
    gather!(V3, F, Vec3, [x, y, z]);
    gather!(V4, F, Vec4, four_floats);
    gather!(V2, I, IVec2, [x, y]);
    gather!(V3, I, IVec3, [x, y, z]);
    gather!(V4, I, IVec4, four_ints);
    gather!(V2, U, UVec2, [x, y]);
    gather!(V3, U, UVec3, [x, y, z]);
    gather!(V4, U, UVec4, four_uints);
    gather!(V2, M, BVec2, [x, y]);
    gather!(V3, M, BVec3, [x, y, z]);
    gather!(V4, M, BVec4, [x, y, z, w]);

    // Geometry.
    macro_rules! geometry {
        ($V:ident, [$c0:ident $(, $c:ident)+]) => {
            impl $V<F> {
                #[lanes]
                pub fn dot(self, b: Self) -> F {
                    self.$c0.mul(b.$c0)$(.add(self.$c.mul(b.$c)))+
                }
                #[lanes]
                pub fn length(self) -> F {
                    self.dot(self).sqrt()
                }
                #[lanes]
                fn minus(self, b: Self) -> Self {
                    Self { $c0: self.$c0.sub(b.$c0) $(, $c: self.$c.sub(b.$c))+ }
                }
                #[lanes]
                fn times(self, b: F) -> Self {
                    Self { $c0: self.$c0.mul(b) $(, $c: self.$c.mul(b))+ }
                }
                #[lanes]
                pub fn distance(self, b: Self) -> F {
                    self.minus(b).length()
                }
                #[lanes]
                pub fn normalize(self) -> Self {
                    self.times(F::splat(1.0).div(self.length()))
                }
                #[lanes]
                pub fn reflect(self, normal: Self) -> Self {
                    self.minus(normal.times(F::splat(2.0).mul(normal.dot(self))))
                }
                #[lanes]
                pub fn refract(self, normal: Self, eta: F) -> Self {
                    let cosine = normal.dot(self);
                    let one = F::splat(1.0);
                    let k = one.sub(eta.mul(eta).mul(one.sub(cosine.mul(cosine))));
                    let bent = self.times(eta).minus(normal.times(eta.mul(cosine).add(k.sqrt())));
                    Self::select(k.lt(F::splat(0.0)), Self::splat(Default::default()), bent)
                }
                #[lanes]
                pub fn face_forward(self, b: Self, normal: Self) -> Self {
                    let turned = Self { $c0: self.$c0.neg() $(, $c: self.$c.neg())+ };
                    Self::select(b.dot(normal).lt(F::splat(0.0)), self, turned)
                }
            }
            impl $V<I> {
                #[lanes]
                pub fn dot(self, b: Self) -> I {
                    self.$c0.mul(b.$c0)$(.add(self.$c.mul(b.$c)))+
                }
            }
            impl $V<U> {
                #[lanes]
                pub fn dot(self, b: Self) -> U {
                    self.$c0.mul(b.$c0)$(.add(self.$c.mul(b.$c)))+
                }
            }
        };
    }
    geometry!(V2, [x, y]);
    geometry!(V3, [x, y, z]);
    geometry!(V4, [x, y, z, w]);
    impl V3<F> {
        #[lanes]
        pub fn cross(self, b: Self) -> Self {
            V3 {
                x: self.y.mul(b.z).sub(self.z.mul(b.y)),
                y: self.z.mul(b.x).sub(self.x.mul(b.z)),
                z: self.x.mul(b.y).sub(self.y.mul(b.x)),
            }
        }
    }

    // Matrices as columns.
    macro_rules! matrix {
        ($V:ident, $G:ident, $module:ident, [$c0:ident $a0:ident $(, $c:ident $a:ident)+]) => {
            impl $V<$V<F>> {
                #[lanes]
                pub fn splat(a: glam::$G) -> Self {
                    Self { $c0: $V::<F>::splat(a.$a0) $(, $c: $V::<F>::splat(a.$a))+ }
                }
                #[lanes]
                pub fn get(self, k: usize) -> glam::$G {
                    glam::$G::from_cols(self.$c0.get(k) $(, self.$c.get(k))+)
                }
                #[lanes]
                pub fn gather(f: impl Fn(usize) -> glam::$G) -> Self {
                    Self { $c0: $V::<F>::gather(|k| f(k).$a0) $(, $c: $V::<F>::gather(|k| f(k).$a))+ }
                }
                #[lanes]
                pub fn select(m: M, accept: Self, reject: Self) -> Self {
                    Self {
                        $c0: $V::<F>::select(m, accept.$c0, reject.$c0)
                        $(, $c: $V::<F>::select(m, accept.$c, reject.$c))+
                    }
                }
                #[lanes]
                pub fn mul_vector(self, v: $V<F>) -> $V<F> {
                    let first = self.$c0.times(v.$c0);
                    $(let first = first.plus(self.$c.times(v.$c));)+
                    first
                }
                #[lanes]
                pub fn vector_mul(self, v: $V<F>) -> $V<F> {
                    $V { $c0: v.dot(self.$c0) $(, $c: v.dot(self.$c))+ }
                }
                #[lanes]
                pub fn mul(self, n: Self) -> Self {
                    Self { $c0: self.mul_vector(n.$c0) $(, $c: self.mul_vector(n.$c))+ }
                }
                #[lanes]
                pub fn scale(self, s: F) -> Self {
                    Self { $c0: self.$c0.times(s) $(, $c: self.$c.times(s))+ }
                }
                #[lanes]
                pub fn add(self, n: Self) -> Self {
                    Self { $c0: self.$c0.plus(n.$c0) $(, $c: self.$c.plus(n.$c))+ }
                }
                #[lanes]
                pub fn sub(self, n: Self) -> Self {
                    Self { $c0: self.$c0.minus(n.$c0) $(, $c: self.$c.minus(n.$c))+ }
                }
                #[lanes]
                pub fn transpose(self) -> Self {
                    Self::gather(|k| self.get(k).transpose())
                }
                #[lanes]
                pub fn determinant(self) -> F {
                    F::gather(|k| wgsl::$module::determinant(self.get(k)))
                }
            }
            impl $V<F> {
                #[lanes]
                fn plus(self, b: Self) -> Self {
                    Self { $c0: self.$c0.add(b.$c0) $(, $c: self.$c.add(b.$c))+ }
                }
            }
        };
    }
    matrix!(V2, Mat2, mat2, [x x_axis, y y_axis]);
    matrix!(V3, Mat3, mat3, [x x_axis, y y_axis, z z_axis]);
    matrix!(V4, Mat4, mat4, [x x_axis, y y_axis, z z_axis, w w_axis]);

    // Packing, one lane after the other but where shading asks for it.
    macro_rules! pack {
        ($($name:ident $V:ident)*) => {
            $(#[lanes]
            pub fn $name(a: $V<F>) -> U {
                U::gather(|k| wgsl::pack::$name(a.get(k)))
            })*
        };
    }
    pack!(pack_4x8_unorm V4 pack_4x8_snorm V4 pack_2x16_unorm V2 pack_2x16_snorm V2 pack_2x16_float V2);
    macro_rules! unpack {
        ($($name:ident $V:ident)*) => {
            $(#[lanes]
            pub fn $name(a: U) -> $V<F> {
                let a = a.to_array();
                $V::<F>::gather(|k| wgsl::pack::$name(a[k]))
            })*
        };
    }
    unpack!(unpack_4x8_snorm V4 unpack_2x16_float V2);
    #[lanes]
    pub fn unpack_2x16_snorm(a: U) -> V2<F> {
        let sixteen = U::splat(16);
        let lane = |a: I| a.to_float().div(F::splat(32767.0)).max(F::splat(-1.0));
        V2 { x: lane(a.shl(sixteen).to_int().shr(sixteen)), y: lane(a.to_int().shr(sixteen)) }
    }
    #[lanes]
    pub fn unpack_2x16_unorm(a: U) -> V2<F> {
        let lane = |a: U| a.to_int().to_float().div(F::splat(65535.0));
        V2 { x: lane(a.and(U::splat(0xffff))), y: lane(a.shr(U::splat(16))) }
    }
    #[lanes]
    pub fn unpack_4x8_unorm(a: U) -> V4<F> {
        let lane = |shift| a.shr(U::splat(shift)).and(U::splat(0xff)).to_int().to_float().div(F::splat(255.0));
        V4 { x: lane(0), y: lane(8), z: lane(16), w: lane(24) }
    }
}
