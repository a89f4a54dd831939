// One function for each construct that the translator knows, `t_NAME(x) -> y`, bits in and bits out. The line before a
// function says what its inputs are and how well the CPU and the GPU have to agree:
//
//   bits     any 32 bits, and the integers where something turns over
//   floats   finite floats of any sign from 2^-30 to 2^30, the zeros, halves, and the ends of the exact integers
//   near     floats from 1/16 to 16
//   unit     floats from -1.25 to 1.25
//
//   exact    the same bits
//   value    the same float, where -0 is 0
//   ulps N   floats at most N representable steps apart
//   within E floats that differ by at most E

struct Item {
    a: vec3<f32>,
    id: u32,
    m: mat4x4<f32>,
    list: array<u32, 4>,
    v: vec4<u32>,
}

struct Params {
    m: mat4x4<f32>,
    v: vec4<u32>,
    k: vec2<f32>,
    count: u32,
    pad: u32,
}

struct Pair {
    left: vec4<u32>,
    right: array<u32, 5>,
    flag: bool,
    v: vec3<f32>,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> items: array<Item>;
@group(0) @binding(2) var<storage, read> words: array<u32>;

const SCALAR: f32 = 0.1;
const LARGEST: f32 = 3.4028234e38;
const SMALLEST: f32 = 1.17549435e-38;
const UNTYPED = 7;
const LOWEST: i32 = -2147483648;
const WORDS = array<u32, 8>(3u, 1u, 4u, 1u, 5u, 9u, 2u, 0xffffffffu);
const AXES = array<vec3<f32>, 3>(vec3<f32>(1.0, 0.5, 0.25), vec3<f32>(vec2<f32>(2.0), -1.0), vec3<f32>());
const GRID = array<array<u32, 2>, 3>(array<u32, 2>(1u, 2u), array<u32, 2>(3u, 4u), array<u32, 2>(5u, 6u));
const PAIR = Pair(vec4<u32>(1u), array<u32, 5>(5u, 4u, 3u, 2u, 1u), true, vec3<f32>(1.5));
const TURN = mat2x2<f32>(0.0, 1.0, -1.0, 0.0);

fn f(x: vec4<u32>) -> vec4<f32> {
    return bitcast<vec4<f32>>(x);
}

fn i(x: vec4<u32>) -> vec4<i32> {
    return bitcast<vec4<i32>>(x);
}

fn u(x: vec4<f32>) -> vec4<u32> {
    return bitcast<vec4<u32>>(x);
}

fn one(x: f32) -> vec4<u32> {
    return vec4(bitcast<u32>(x), 0u, 0u, 0u);
}

fn flags(b: vec4<bool>) -> vec4<u32> {
    return select(vec4(0u), vec4(1u), b);
}

// ---- integers

// bits exact
fn t_uint_add_sub_mul(x: vec4<u32>) -> vec4<u32> {
    return vec4(x.x + x.y, x.x - x.y, x.x * x.y, x.z * 2654435769u);
}

// bits exact
fn t_int_add_sub_mul(x: vec4<u32>) -> vec4<u32> {
    let a = i(x);
    return bitcast<vec4<u32>>(vec4(a.x + a.y, a.x - a.y, a.x * a.y, -a.z));
}

// bits exact
fn t_uint_div_rem(x: vec4<u32>) -> vec4<u32> {
    return vec4(x.x / x.y, x.x % x.y, x.z / 7u, x.w % 10u);
}

// bits exact
fn t_int_div_rem(x: vec4<u32>) -> vec4<u32> {
    let a = i(x);
    return bitcast<vec4<u32>>(vec4(a.x / a.y, a.x % a.y, a.z / -7, a.w % 10));
}

// bits exact
fn t_div_by_zero(x: vec4<u32>) -> vec4<u32> {
    let zero = x.x & 0u;
    let lowest = i32(x.y | 0x80000000u) & LOWEST;
    return vec4(x.z / zero, x.z % zero, u32(lowest / (i32(zero) - 1)), u32(lowest % (i32(zero) - 1)));
}

// bits exact
fn t_uint_vector(x: vec4<u32>) -> vec4<u32> {
    return ((x + x.yzwx) * x.zwxy - x.wxyz) / (x | vec4(1u)) + x % vec4(17u);
}

// bits exact
fn t_int_vector(x: vec4<u32>) -> vec4<u32> {
    let a = i(x);
    return bitcast<vec4<u32>>(-((a + a.yzwx) * a.zwxy - a.wxyz) / a.zwxy + a % a.yzwx);
}

// bits exact
fn t_int_vector_and_scalar(x: vec4<u32>) -> vec4<u32> {
    return (x.xyz * 3u + 5u - x.w).xyzz + (7u * x) % 11u + vec4(x.x / 3u) + x / 5u;
}

// bits exact
fn t_vector_two_and_three(x: vec4<u32>) -> vec4<u32> {
    let a = x.xy * x.zw + x.yx;
    let b = i(x).xyz * i(x).yzw - i(x).zwx;
    return vec4(a, bitcast<vec3<u32>>(b).xy) ^ bitcast<vec3<u32>>(b).zzzz;
}

// bits exact
fn t_bitwise(x: vec4<u32>) -> vec4<u32> {
    return vec4(x.x & x.y, x.x | x.y, x.x ^ x.y, ~x.z);
}

// bits exact
fn t_bitwise_vector(x: vec4<u32>) -> vec4<u32> {
    return ((x & x.yzwx) | (~x ^ x.zwxy)) ^ bitcast<vec4<u32>>(~i(x) & i(x).wzyx);
}

// bits exact
fn t_shift(x: vec4<u32>) -> vec4<u32> {
    let a = i(x);
    let by = x.y & 31u;
    return vec4(x.x << by, x.x >> by, u32(a.x << by), u32(a.x >> by));
}

// bits exact
fn t_shift_vector(x: vec4<u32>) -> vec4<u32> {
    let by = x.wzyx & vec4(31u);
    return (x << by) ^ (x >> by.yxwz) ^ bitcast<vec4<u32>>((i(x) >> by) + (i(x).zyxw << by));
}

// bits exact
fn t_compare_int(x: vec4<u32>) -> vec4<u32> {
    let a = i(x);
    return vec4(u32(x.x < x.y) | (u32(x.x <= x.y) << 1u), u32(x.x > x.y) | (u32(x.x >= x.y) << 1u),
        u32(a.x < a.y) | (u32(a.x <= a.y) << 1u), u32(a.x == a.y) | (u32(a.x != a.y) << 1u));
}

// bits exact
fn t_compare_vector(x: vec4<u32>) -> vec4<u32> {
    let a = i(x);
    let y = x.yzwx;
    return flags(x < y) | (flags(x <= y) << vec4(1u)) | (flags(a > a.yzwx) << vec4(2u))
        | (flags(a >= a.zwxy) << vec4(3u)) | (flags(x == y) << vec4(4u)) | (flags(a.xxzz != a) << vec4(5u));
}

// bits exact
fn t_min_max_clamp_int(x: vec4<u32>) -> vec4<u32> {
    let a = i(x);
    return vec4(min(x.x, x.y), u32(max(a.x, a.y)), clamp(x.z, 10u, 1000u), u32(clamp(a.w, -5, 5)));
}

// bits exact
fn t_min_max_clamp_int_vector(x: vec4<u32>) -> vec4<u32> {
    let a = i(x);
    return min(x, x.yzwx) + max(x, x.zwxy) + clamp(x, vec4(3u), vec4(70000u))
        + bitcast<vec4<u32>>(min(a, a.yzwx) ^ max(a, a.zwxy) ^ clamp(a, vec4(-9), vec4(9)));
}

// bits exact
fn t_abs_sign_int(x: vec4<u32>) -> vec4<u32> {
    let a = i(x);
    return vec4(u32(abs(a.x)), u32(sign(a.y)), abs(x.z), bitcast<u32>(sign(a.ww).x) + u32(abs(a.wz).y));
}

// bits exact
fn t_dot_int(x: vec4<u32>) -> vec4<u32> {
    let a = i(x);
    return vec4(dot(x, x.yzwx), dot(x.xyz, x.yzw), u32(dot(a, a.zwxy)), u32(dot(a.xy, a.zw)));
}

// bits exact
fn t_count_bits(x: vec4<u32>) -> vec4<u32> {
    return vec4(countOneBits(x.x), countLeadingZeros(x.x), countTrailingZeros(x.x), reverseBits(x.x));
}

// bits exact
fn t_count_bits_vector(x: vec4<u32>) -> vec4<u32> {
    let a = i(x);
    return countOneBits(x) + (countLeadingZeros(x) << vec4(8u)) + (countTrailingZeros(x) << vec4(16u)) + reverseBits(x)
        + bitcast<vec4<u32>>(countOneBits(a) + countLeadingZeros(a) + countTrailingZeros(a) + reverseBits(a));
}

// bits exact
fn t_first_bit(x: vec4<u32>) -> vec4<u32> {
    let a = i(x);
    return vec4(firstLeadingBit(x.x), firstTrailingBit(x.x), u32(firstLeadingBit(a.x)), u32(firstTrailingBit(a.x)));
}

// bits exact
fn t_first_bit_vector(x: vec4<u32>) -> vec4<u32> {
    let a = i(x);
    return firstLeadingBit(x) ^ firstTrailingBit(x.yxwz)
        ^ bitcast<vec4<u32>>(firstLeadingBit(a.zwxy) + firstTrailingBit(a.wzyx));
}

// bits exact
fn t_extract_bits(x: vec4<u32>) -> vec4<u32> {
    let a = i(x);
    let offset = x.y & 63u;
    let count = x.z & 63u;
    return vec4(extractBits(x.x, offset, count), u32(extractBits(a.x, offset, count)), extractBits(x.x, 8u, 8u),
        extractBits(x, offset, count).w);
}

// bits exact
fn t_insert_bits(x: vec4<u32>) -> vec4<u32> {
    let a = i(x);
    let offset = x.y & 63u;
    let count = x.z & 63u;
    return vec4(insertBits(x.x, x.w, offset, count), u32(insertBits(a.x, a.w, offset, count)),
        insertBits(x.x, x.w, 4u, 12u), insertBits(x, x.wzyx, offset, count).y);
}

// ---- conversions

// bits exact
fn t_bitcast(x: vec4<u32>) -> vec4<u32> {
    let s = bitcast<i32>(x.x);
    return vec4(bitcast<u32>(s), bitcast<u32>(bitcast<vec2<i32>>(x.yz)).x, bitcast<vec3<u32>>(i(x).yzw).yz);
}

// floats exact
fn t_bitcast_float(x: vec4<u32>) -> vec4<u32> {
    let a = bitcast<f32>(x.x);
    let b = bitcast<f32>(bitcast<i32>(x.y));
    let c = bitcast<vec2<f32>>(bitcast<vec2<i32>>(x.zw));
    return vec4(bitcast<u32>(a), u32(bitcast<i32>(b)), bitcast<vec2<u32>>(bitcast<vec2<i32>>(c)));
}

// bits exact
fn t_int_to_float(x: vec4<u32>) -> vec4<u32> {
    let a = i(x);
    return u(vec4(f32(x.x), f32(a.y), vec2<f32>(x.zw).x, vec3<f32>(a.xyw).z));
}

// floats exact
fn t_float_to_int(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return vec4(u32(a.x), u32(i32(a.y)), vec2<u32>(a.zw).x, u32(vec3<i32>(a.yzw).z));
}

// bits exact
fn t_bool_conversions(x: vec4<u32>) -> vec4<u32> {
    let a = bool(x.x & 1u);
    let b = vec3<bool>(x.yzw & vec3(1u));
    let c = vec2<bool>(vec2<f32>(x.xy & vec2(1u)));
    return vec4(u32(a) + u32(i32(a)) + u32(f32(a)), vec3<u32>(b) + bitcast<vec3<u32>>(vec3<i32>(b)) + vec3<u32>(vec3<f32>(b)))
        + vec4(vec2<u32>(c), u32(bool(bitcast<i32>(x.z) & 1)), u32(bool(f32(x.w & 1u))));
}

// bits exact
fn t_bool_logic(x: vec4<u32>) -> vec4<u32> {
    let a = x.x < x.y;
    let b = x.z < x.w;
    let v = x < x.yzwx;
    let w = x < x.zwxy;
    return vec4(u32(a && b), u32(a || b), u32(!a) + 2u * u32(a & b) + 4u * u32(a | b) + 8u * u32(a == b) + 16u * u32(a != b), 0u)
        + flags(v & w) + flags(v | w) * 2u + flags(!v) * 4u + flags(v == w) * 8u + flags(v != w) * 16u;
}

// bits exact
fn t_short_circuit(x: vec4<u32>) -> vec4<u32> {
    var calls = 0u;
    let a = (x.x & 1u) == 0u && counted(&calls, x.y);
    let b = (x.z & 1u) == 0u || counted(&calls, x.w);
    return vec4(u32(a), u32(b), calls, 0u);
}

fn counted(calls: ptr<function, u32>, x: u32) -> bool {
    *calls += 1u;
    return (x & 2u) == 0u;
}

// bits exact
fn t_all_any(x: vec4<u32>) -> vec4<u32> {
    let v = x < x.yzwx;
    return vec4(u32(all(v)), u32(any(v)), u32(all(v.xy)) + 2u * u32(any(v.yzw)), u32(all(v.x)) + 2u * u32(any(v.w)));
}

// bits exact
fn t_select(x: vec4<u32>) -> vec4<u32> {
    let scalar = select(x.x, x.y, x.z < x.w);
    let whole = select(x, x.wzyx, x.x < x.y);
    let lanes = select(f(whole), f(x.yyzz), x < x.yzwx);
    return select(u(lanes) + scalar, whole, vec4(true, false, x.x > 5u, false));
}

// bits exact
fn t_select_bool(x: vec4<u32>) -> vec4<u32> {
    let a = x < x.yzwx;
    return flags(select(a, a.wzyx, x > x.zwxy)) + vec4(u32(select(a.x, a.y, a.z)));
}

// ---- vectors, matrices, arrays, structs

// bits exact
fn t_swizzle(x: vec4<u32>) -> vec4<u32> {
    let b = (x < x.yzwx).wzyx;
    return x.xxyy + x.xyz.zyxz + x.xy.yxyx + vec4(x.zw.yx, x.yzw.xz) + flags(b) + flags(b.xy.xyyx) + vec4(x.bgr, x.a);
}

// bits exact
fn t_compose(x: vec4<u32>) -> vec4<u32> {
    let a = vec4(x.xy, x.zw);
    let b = vec4(x.x, x.yz, x.w);
    let c = vec4(x.x, x.yzw);
    let d = vec4(x.xyz, x.w);
    let e = vec3(x.x, x.yz);
    let g = vec3(x.xy, x.w);
    let h = vec4((x < x.yzwx).xy, (x < x.wxyz).z, true);
    return a + b * 3u + c * 5u + d * 7u + vec4(e, 0u) * 11u + vec4(g, 1u) * 13u + flags(h);
}

// bits exact
fn t_vector_index(x: vec4<u32>) -> vec4<u32> {
    var v = x;
    let n = x.x & 3u;
    v[n] = x[(n + 1u) & 3u];
    v[3] += v[x.y & 3u];
    var w = i(x).xyz;
    w[x.z % 3u] = -1;
    let b = x < x.yzwx;
    return v + vec4(bitcast<vec3<u32>>(w), u32(b[x.w & 3u])) + vec4(x.xy[x.y & 1u]);
}

// unit value
fn t_matrix_index(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    var m = mat3x3<f32>(a.xyz, a.yzw, a.zwx);
    let n = x.x % 3u;
    m[n] = m[(n + 1u) % 3u];
    m[1].y = a.x;
    m[n].z = a.y;
    m[(n + 2u) % 3u][x.y % 3u] = a.w;
    m[2][0] = a.z;
    let by_value = mat2x2<f32>(a.x, a.y, a.z, a.w);
    return u(vec4(m[n], by_value[n & 1u].y)) ^ u(vec4(m[1], m[x.z % 3u][x.w % 3u]));
}

// near ulps 4
fn t_matrix_vector(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    let m = mat3x3<f32>(a.xyz, a.yzw, a.zwx);
    let n = mat2x2<f32>(a.xy, a.zw);
    let p = mat4x4<f32>(a, a.yzwx, a.zwxy, a.wxyz);
    return u(vec4((m * a.wxy).xy, (a.zyx * m).z, (n * a.yw).y) + p * a + a * p);
}

// near ulps 6
fn t_matrix_matrix(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    let m = mat3x3<f32>(a.xyz, a.yzw, a.zwx);
    let p = mat4x4<f32>(a, a.yzwx, a.zwxy, a.wxyz);
    let q = (p * transpose(p) + p * 2.0 + 3.0 * p) * a;
    return u(vec4((m * m)[1], (m + m)[2].x) + q);
}

// unit exact
fn t_matrix_sub_neg_transpose(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    let p = mat4x4<f32>(a, a.yzwx, a.zwxy, a.wxyz);
    let n = mat2x2<f32>(a.xy, a.zw);
    return u((transpose(p) - p)[1]) ^ u(vec4(transpose(n)[0], transpose(n)[1])) ^ u((p * -1.0)[2]);
}

// near ulps 64
fn t_determinant(x: vec4<u32>) -> vec4<u32> {
    // Strong diagonals, so that nothing cancels.
    let a = f(x) + vec4(64.0);
    let n = mat2x2<f32>(a.x, 1.0, 2.0, a.y);
    let m = mat3x3<f32>(a.x, 1.0, 2.0, 3.0, a.y, 1.0, -1.0, 2.0, a.z);
    let p = mat4x4<f32>(a.x, 1.0, 2.0, 3.0, 4.0, a.y, -1.0, 2.0, 1.0, 3.0, a.z, 5.0, 1.0, -2.0, 3.0, a.w);
    return u(vec4(determinant(n), determinant(m), determinant(p), 0.0));
}

// bits exact
fn t_array_index(x: vec4<u32>) -> vec4<u32> {
    var a = array<u32, 6>(x.x, x.y, x.z, x.w, 1u, 2u);
    let n = x.x % 6u;
    a[n] = a[(n + 3u) % 6u] + 1u;
    a[2] ^= a[x.y % 6u];
    var zero: array<vec2<u32>, 3>;
    zero[x.z % 3u].y = x.w;
    zero[x.w % 3u][x.y & 1u] += x.z;
    var nested = array<array<u32, 2>, 2>();
    nested[x.x & 1u][x.y & 1u] = x.z;
    let copy = a;
    a[0] = 0u;
    return vec4(copy[x.z % 6u], a[0] + a[n], zero[0].x + zero[1].y + zero[2].x, nested[1][0] + nested[0][1]);
}

// bits exact
fn t_array_index_past_the_end(x: vec4<u32>) -> vec4<u32> {
    // What is read there is not said; that the function returns is.
    var a = array<u32, 4>(x.x, x.y, x.z, x.w);
    a[x.x | 4u] = 0u;
    let read = a[x.y | 0x80000000u] + words[x.z | 0x40000000u] + WORDS[x.w | 8u];
    return vec4(x.x & read & 0u);
}

// bits exact
fn t_constant_array(x: vec4<u32>) -> vec4<u32> {
    let local = array<u32, 4>(10u, 20u, 30u, 40u);
    const inner = array<f32, 3>(0.5, 1.5, 2.5);
    return vec4(WORDS[x.x & 7u], u32(AXES[x.y % 3u].y * 4.0), local[x.z & 3u] + GRID[x.w % 3u][x.x & 1u],
        bitcast<u32>(inner[x.w % 3u]) + PAIR.right[x.y % 5u] + u32(AXES[1].z * 8.0 + 8.0));
}

// bits exact
fn t_constants(x: vec4<u32>) -> vec4<u32> {
    let w = u32(PAIR.flag) + PAIR.left.y + u32(UNTYPED);
    return vec4(bitcast<u32>(SCALAR) + x.x, bitcast<u32>(LARGEST) - x.y, bitcast<u32>(SMALLEST) ^ x.z, u32(LOWEST) + w);
}

// bits exact
fn t_literals(x: vec4<u32>) -> vec4<u32> {
    return x + u(vec4(0.1, 1e-7, 16777217.0, -3.4028234e38)) + u(vec4(1.0 / 3.0, 0x1.8p-3, 1e10, 6.02e23))
        + vec4(0xffffffffu, 4294967295u, u32(-1i), u32(LOWEST + 1));
}

// unit value
fn t_constant_matrix(x: vec4<u32>) -> vec4<u32> {
    return u(vec4(TURN * f(x).xy, -f(x).zw));
}

// bits exact
fn t_struct(x: vec4<u32>) -> vec4<u32> {
    var p = Pair(x, array<u32, 5>(1u, 2u, 3u, 4u, x.x), x.x < x.y, vec3(1.0, 2.0, 3.0));
    p.left.y = p.right[x.y % 5u];
    p.right[x.z % 5u] = p.left.w;
    p.v[x.w % 3u] = 4.0;
    let q = p;
    p = Pair();
    p.flag = !q.flag;
    let r = widened(q);
    return q.left + vec4(q.right[4], u32(q.flag) + u32(p.flag) * 2u, u32(q.v.x + q.v.y + q.v.z), p.left.x) + r.left;
}

fn widened(p: Pair) -> Pair {
    var q = p;
    q.left += vec4(p.right[0]);
    return q;
}

// bits exact
fn t_pointer(x: vec4<u32>) -> vec4<u32> {
    var v = x;
    var p: Pair;
    var a = array<u32, 4>(1u, 2u, 3u, 4u);
    swap_halves(&v);
    fill(&p, x.x);
    bump(&a, x.y & 3u);
    let whole = &a;
    let element = &a[x.z & 3u];
    *element += 100u;
    (*whole)[0] *= 2u;
    var grid = array<array<u32, 4>, 2>();
    let row = &grid[x.x & 1u];
    (*row)[x.y & 3u] = x.z;
    v.x += grid[1][x.z & 3u] + (*row)[3];
    return v + p.left + vec4(a[0], a[1], a[2], a[3]) + vec4(p.right[x.w % 5u]);
}

fn swap_halves(v: ptr<function, vec4<u32>>) {
    let old = *v;
    *v = old.zwxy;
    (*v).x += 1u;
    (*v)[old.y & 3u] ^= 5u;
}

fn fill(p: ptr<function, Pair>, seed: u32) {
    (*p).left = vec4(seed);
    for (var k = 0u; k < 5u; k++) {
        (*p).right[k] = seed + k;
    }
    again(p);
}

fn again(p: ptr<function, Pair>) {
    (*p).left.z += (*p).right[3];
}

fn bump(a: ptr<function, array<u32, 4>>, at: u32) {
    (*a)[at] += 10u;
    (*a)[3] += 1u;
}

// ---- bindings

// bits exact
fn t_storage(x: vec4<u32>) -> vec4<u32> {
    let n = x.x % arrayLength(&items);
    let item = items[(n + 1u) % arrayLength(&items)];
    return u(vec4(items[n].a, item.a.y)) + vec4(items[n].id, items[n].list[x.y & 3u], item.list[x.z & 3u], item.v[x.w & 3u])
        + u(items[n].m[x.y & 3u]) + u(vec4(items[n].m[1].z)) + items[n].v.wzyx;
}

// bits exact
fn t_uniform(x: vec4<u32>) -> vec4<u32> {
    let all = params;
    return params.v + u(params.m[x.x & 3u]) + vec4(params.v[x.y & 3u], params.count, u(params.k.xyxy).zw)
        + u(vec4(params.m[2][1])) + all.v.yyyy;
}

// bits exact
fn t_storage_words(x: vec4<u32>) -> vec4<u32> {
    let n = arrayLength(&words);
    return vec4(words[x.x % n], words[3], n, arrayLength(&items));
}

// ---- statements

// bits exact
fn t_if(x: vec4<u32>) -> vec4<u32> {
    var y = x;
    if x.x < x.y {
        y.x += 1u;
    }
    if x.y < x.z {
        y.y += 2u;
    } else {
        y.y += 3u;
    }
    if x.z < 5u {
        y.z = 0u;
    } else if x.z < x.w {
        y.z = 1u;
        if (x.x & 1u) == 1u {
            return y.wzyx;
        }
    } else {
    }
    return y;
}

// bits exact
fn t_for(x: vec4<u32>) -> vec4<u32> {
    var y = vec4(0u);
    for (var k = 0u; k < (x.x & 15u); k++) {
        if (k & 3u) == (x.y & 3u) {
            continue;
        }
        if k > (x.z & 31u) {
            break;
        }
        for (var m = i32(k); m > -3; m -= 2) {
            if m == 4 {
                continue;
            }
            y.y += u32(m);
            if m == i32(x.w & 7u) {
                break;
            }
        }
        y.x = y.x * 31u + k;
    }
    return y;
}

// bits exact
fn t_while(x: vec4<u32>) -> vec4<u32> {
    var n = x.x & 1023u;
    var steps = 0u;
    while n != 0u && steps < 40u {
        steps++;
        if (n & 1u) == 1u {
            n -= 1u;
            continue;
        }
        n >>= 1u;
    }
    return vec4(n, steps, 0u, 0u);
}

// bits exact
fn t_loop(x: vec4<u32>) -> vec4<u32> {
    var k = 0u;
    var sum = 0u;
    loop {
        let odd = (k & 1u) == 1u;
        let weight = (x.x >> (k & 31u)) & 7u;
        if odd && weight == 3u {
            continue;
        }
        if weight == 6u && k > 20u {
            break;
        }
        sum += weight;

        continuing {
            k += 1u;
            sum += select(0u, 1u, odd);
            break if k > 40u || sum > (x.y & 127u);
        }
    }
    return vec4(k, sum, 0u, 0u);
}

// bits exact
fn t_loop_that_returns(x: vec4<u32>) -> vec4<u32> {
    var k = x.x & 7u;
    loop {
        k += 3u;
        if k % 5u == 0u {
            return vec4(k);
        }
        if k > 1000u {
            break;
        }
    }
    return x;
}

// bits exact
fn t_switch(x: vec4<u32>) -> vec4<u32> {
    var y = 0u;
    switch x.x & 7u {
        case 0u: {
            y = 1u;
        }
        case 1u, 2u: {
            y = 2u;
            if (x.y & 1u) == 0u {
                break;
            }
            y = 3u;
        }
        case 3u, default: {
            y = 4u;
        }
        case 4u: {
            return vec4(9u);
        }
    }
    switch i32(x.z & 3u) - 1 {
        case -1: {
            y += 10u;
            break;
        }
        case 0, 1: {
            y += 20u;
        }
        default: {
        }
    }
    return vec4(y);
}

// bits exact
fn t_switch_returns(x: vec4<u32>) -> vec4<u32> {
    switch x.x & 1u {
        case 0u: {
            return x.wzyx;
        }
        default: {
            return x;
        }
    }
}

// bits exact
fn t_switch_in_loop(x: vec4<u32>) -> vec4<u32> {
    var y = 0u;
    for (var k = 0u; k < 12u; k++) {
        switch (x.x >> k) & 3u {
            case 0u: {
                continue;
            }
            case 1u: {
                if y > 5u {
                    break;
                }
                y += 1u;
            }
            case 2u: {
                for (var m = 0u; m < 3u; m++) {
                    if m == (x.y & 3u) {
                        break;
                    }
                    y += 2u;
                }
            }
            default: {
                y ^= 8u;
            }
        }
        y += 16u;
    }
    return vec4(y);
}

// bits exact
fn t_shadowing(x: vec4<u32>) -> vec4<u32> {
    var y = x;
    let WORDS = x.x;
    {
        let y = x.y + WORDS;
        {
            let x = y;
            let items = x + 1u;
            if items > 3u {
                return vec4(x, y, items, WORDS);
            }
        }
    }
    y.x = 7u;
    return y;
}

// bits exact
fn t_load_before_store(x: vec4<u32>) -> vec4<u32> {
    var a = x.x;
    let old = a;
    a = a * 3u;
    let sum = a + old;
    a = sum;
    var v = x;
    let t = v.x;
    v.x = v.y;
    v.y = t;
    // Operands from left to right: what a call writes is not seen to its left.
    let around = a + tripled(&a) * 7u + a * 31u;
    return v + vec4(a, old, sum, around);
}

fn tripled(p: ptr<function, u32>) -> u32 {
    let was = *p;
    *p *= 3u;
    return was;
}

// bits exact
fn t_discarded_call(x: vec4<u32>) -> vec4<u32> {
    var calls = 0u;
    _ = counted(&calls, x.x);
    let box = counted(&calls, x.y);
    return vec4(calls, u32(box), 0u, 0u);
}

// ---- floats

// floats value
fn t_float_add_sub_mul(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(a.x + a.y, a.x - a.y, a.x * a.y, -a.z));
}

// floats value
fn t_float_vector_add_sub(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4((a + a.yzwx).xy, (a.xyz - a.yzw).z, (a + 1.0).w));
}

// floats value
fn t_float_vector_mul(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4((a * a.yzwx).x, (a.xyz * 3.0).y, (a.w * a.zw).x, -a.w));
}

// near ulps 3
fn t_float_div(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(a.x / a.y, (a.yz / a.zw).x, (a.xyz / a.w).z, (1.0 / a).w));
}

// floats exact
fn t_compare_float(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    let b = a.yxwz;
    return flags(a < b) + flags(a <= b) * 2u + flags(a > b) * 4u + flags(a >= b) * 8u + flags(a == b) * 16u + flags(a != b) * 32u
        + vec4(u32(a.x < a.z), u32(a.x >= a.z), u32(a.x == a.z), u32(a.y != a.w));
}

// floats value
fn t_min_max_float(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(min(a.x, a.y), max(a.x, a.y), min(a.yz, a.zw).x, max(a.xyz, a.yzw).z));
}

// floats value
fn t_clamp_float(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(clamp(a.x, -2.0, 3.0), saturate(a.y), clamp(a.zw, vec2(-1.0), vec2(1.0)).x, saturate(a.yzw).z));
}

// floats exact
fn t_abs_float(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(abs(a.x), abs(a.yzw)));
}

// floats value
fn t_sign_float(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(sign(a.x), sign(a.yzw)));
}

// floats value
fn t_floor_ceil_trunc_round(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(floor(a.x), ceil(a.y), trunc(a.z), round(a.w)));
}

// floats value
fn t_floor_ceil_trunc_round_vector(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(floor(a).x, ceil(a.xyz).y, trunc(a.zw).x, round(a.yzw).z));
}

// floats value
fn t_fract(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(fract(a.x), fract(a.yzw)));
}

// floats value
fn t_step(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(step(a.x, a.y), step(a.yzw, a.zwx)));
}

// near ulps 4
fn t_smoothstep(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(smoothstep(0.0, 16.0, a.x), smoothstep(vec3(0.0), vec3(8.0, 16.0, 32.0), a.yzw)));
}

// near ulps 4
fn t_mix(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    let t = a.x / 16.0;
    return u(vec4(mix(a.y, a.z, t), mix(a.yz, a.zw, t).x, mix(a.yzw, a.zwy, a.xyz / 16.0).yz));
}

// near ulps 2
fn t_fma(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(fma(a.x, a.y, a.z), fma(a.xyz, a.yzw, a.zwx)));
}

// near ulps 3
fn t_sqrt(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(sqrt(a.x), sqrt(a.yzw)));
}

// near ulps 4
fn t_inverse_sqrt(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(inverseSqrt(a.x), inverseSqrt(a.yzw)));
}

// near ulps 4
fn t_float_rem(x: vec4<u32>) -> vec4<u32> {
    // Quotients away from the integers: a step of the quotient over one of them is a whole divisor.
    let b = f(x);
    let a = b * (floor(b.yzwx) + 0.5);
    return u(vec4(a.x % b.x, -a.y % b.y, (a.zw % b.zw)));
}

// near ulps 2
fn t_radians_degrees(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(radians(a.x), degrees(a.y), radians(a.zw).x, degrees(a.zw).y));
}

// near ulps 4
fn t_dot(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(dot(a, a.yzwx), dot(a.xyz, a.yzw), dot(a.xy, a.zw), 0.0));
}

// near ulps 4
fn t_cross(x: vec4<u32>) -> vec4<u32> {
    // Signs such that the products add up.
    let a = f(x) * vec4(1.0, -1.0, 1.0, 1.0);
    return u(vec4(cross(vec3(a.x, 0.0, 0.0), a.yzw) + cross(vec3(0.0, a.z, a.w), vec3(0.0, a.y, a.x)), 0.0));
}

// near ulps 4
fn t_length_distance(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(length(a), length(a.xy) + length(-a.z), distance(a.xyz, -a.yzw), distance(-a.x, a.y)));
}

// near ulps 5
fn t_normalize(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(normalize(a).xy, normalize(a.xyz).z, normalize(a.zw).x));
}

// unit within 0.000002
fn t_reflect(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(reflect(a.xyz, vec3(0.6, -0.64, 0.48)), reflect(a.xy, vec2(0.8, 0.6)).x));
}

// near ulps 16
fn t_refract(x: vec4<u32>) -> vec4<u32> {
    let a = normalize(f(x).xyz);
    let bent = refract(-a, vec3(0.0, 1.0, 0.0), 0.5);
    let back = refract(vec3(0.9, -0.435889894, 0.0), vec3(0.0, 1.0, 0.0), 1.5 + f(x).w);
    return u(vec4(bent, back.x));
}

// unit value
fn t_face_forward(x: vec4<u32>) -> vec4<u32> {
    let a = f(x);
    return u(vec4(faceForward(a.xyz, vec3(0.0, 1.0, 0.0), vec3(0.0, a.w, 0.0)), faceForward(a.xy, vec2(1.0, 0.0), a.zz).x));
}

// ---- packing

// unit exact
fn t_pack_norm(x: vec4<u32>) -> vec4<u32> {
    // On multiples of a step: where a value lies halfway the formats leave the rounding open.
    let a = round(f(x) * 127.0) / 127.0;
    let b = round(saturate(f(x)) * 255.0) / 255.0;
    let c = round(f(x).xy * 32767.0) / 32767.0;
    let d = round(saturate(f(x)).zw * 65535.0) / 65535.0;
    return vec4(pack4x8snorm(a), pack4x8unorm(b), pack2x16snorm(c), pack2x16unorm(d));
}

// bits ulps 3
fn t_unpack_unorm(x: vec4<u32>) -> vec4<u32> {
    return u(vec4(unpack4x8unorm(x.x).xw, unpack2x16unorm(x.z)) + vec4(unpack4x8unorm(x.y).yz, 0.0, 0.0));
}

// bits ulps 3
fn t_unpack_snorm(x: vec4<u32>) -> vec4<u32> {
    return u(vec4(unpack4x8snorm(x.x).xw, unpack2x16snorm(x.z)));
}

// bits ulps 3
fn t_unpack_snorm_middle(x: vec4<u32>) -> vec4<u32> {
    return u(vec4(unpack4x8snorm(x.x).yz, unpack2x16snorm(x.y)));
}

// bits exact
fn t_unpack_half(x: vec4<u32>) -> vec4<u32> {
    // No infinities, no NaN.
    let bits = x & vec4(0xbbffbbffu);
    return u(vec4(unpack2x16float(bits.x), unpack2x16float(bits.y)));
}

// bits exact
fn t_pack_half(x: vec4<u32>) -> vec4<u32> {
    // There and back, for every half that is neither infinite nor NaN, and for the exact middle of two of them.
    let bits = x & vec4(0xbbffbbffu);
    let a = unpack2x16float(bits.x);
    let b = unpack2x16float(bits.y | 0x04000400u);
    return vec4(pack2x16float(a), pack2x16float(b), pack2x16float(b + b * 0.00048828125), 0u);
}

// unit exact
fn t_quantize(x: vec4<u32>) -> vec4<u32> {
    let a = f(x) + 2.0;
    return u(vec4(quantizeToF16(a.x), quantizeToF16(a.yzw)));
}
