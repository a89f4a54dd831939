// Control flow for the lanes' test, beside constructs.wgsl, whose bindings and helpers these functions use: what lanes
// that part have to get right, and what they have to know to be the same in all of them.

fn collatz_steps(start: u32, limit: u32) -> u32 {
    var n = start;
    for (var steps = 0u; steps < limit; steps++) {
        if n == 1u {
            return steps;
        }
        if n % 2u == 0u {
            n /= 2u;
            continue;
        }
        n = 3u * n + 1u;
    }
    return limit;
}

// bits exact
fn t_lanes_return_in_a_loop(x: vec4<u32>) -> vec4<u32> {
    return vec4<u32>(collatz_steps(x.x % 100u, 60u), collatz_steps(x.y % 9u, x.z % 20u), collatz_steps(7u, 50u), x.w);
}

// bits exact
fn t_lanes_nested_loops(x: vec4<u32>) -> vec4<u32> {
    var sum = 0u;
    var turns = vec2<u32>(0u);
    for (var i = 0u; i < x.x % 7u; i++) {
        turns.x++;
        for (var j = 0u; ; j++) {
            if j > x.y % 5u {
                break;
            }
            if (i + j) % 3u == x.z % 3u {
                continue;
            }
            if i * j == 8u {
                return vec4<u32>(sum, turns, 1u);
            }
            sum = sum * 31u + i * 8u + j;
            turns.y++;
        }
        if sum % 11u == 5u {
            break;
        }
    }
    return vec4<u32>(sum, turns, 0u);
}

// bits exact
fn t_lanes_switch(x: vec4<u32>) -> vec4<u32> {
    var y = x;
    switch x.x % 6u {
        case 0u, 3u: {
            y.x = 10u;
        }
        case 1u: {
            if x.y % 2u == 0u {
                break;
            }
            y.x = 20u;
            y.y += 1u;
        }
        case 2u: {
            return vec4<u32>(2u, y.yzw);
        }
        case 4u: {
        }
        default: {
            y.x = 30u;
        }
    }
    y.z = y.z ^ y.x;
    return y;
}

// bits exact
fn t_lanes_switch_in_a_loop(x: vec4<u32>) -> vec4<u32> {
    var y = vec4<u32>(0u);
    for (var i = 0u; i < 12u; i++) {
        switch (x.x >> i) & 3u {
            case 0u: {
                continue;
            }
            case 1u: {
                y.x += i;
                break;
            }
            case 2u: {
                if y.x > x.y % 16u {
                    return y;
                }
                y.y += 1u;
            }
            default: {
                y.z = y.z * 3u + y.x;
            }
        }
        y.w = y.w * 5u + i;
        if y.w % 7u == 6u {
            break;
        }
    }
    return y;
}

// bits exact
fn t_lanes_same_for_all(x: vec4<u32>) -> vec4<u32> {
    // The loops' bounds and the branches hold for all lanes; what they compute does not.
    var y = x;
    var joint = 1u;
    for (var i = 0u; i < params.count; i++) {
        if i == 3u {
            continue;
        }
        joint = joint * 7u + words[i];
        y.x = y.x * 5u + words[i + 1u];
        if (params.v.x & (1u << i)) != 0u {
            y.y ^= joint;
        } else {
            for (var j = 0u; j < i; j++) {
                y.z += j + joint;
            }
        }
        if joint > 4000000000u {
            break;
        }
    }
    switch params.v.y {
        case 1u: {
            y.w += joint;
            if params.v.z == 4u {
                break;
            }
            joint = 0u;
        }
        default: {
            joint = 9u;
        }
    }
    return y + vec4<u32>(joint);
}

// bits exact
fn t_lanes_shared_until_they_part(x: vec4<u32>) -> vec4<u32> {
    var a = 1u;
    var b = 2u;
    var c = 3u;
    if x.x % 2u == 0u {
        a = 5u;
        var within = 7u;
        if params.count == 5u {
            within = 8u;
        }
        b += within;
    }
    for (var i = 0u; i < 6u; i++) {
        var here = i;
        if i == x.y % 8u {
            break;
        }
        here += 2u;
        c = here;
    }
    switch params.v.x {
        case 3u: {
            if x.z % 3u == 0u {
                break;
            }
            c += 100u;
        }
        default: {
        }
    }
    return vec4<u32>(a, b, c, x.w);
}

// bits exact
fn t_lanes_carry_from_turn_to_turn(x: vec4<u32>) -> vec4<u32> {
    var carried: u32;
    var y = vec4<u32>(0u);
    for (var i = 0u; i < 8u; i++) {
        if (x.x >> i) % 2u == 1u {
            y.x = y.x * 10u + carried;
            carried = 3u;
            continue;
        }
        if (x.y >> i) % 2u == 1u {
            var fresh: u32;
            y.y = y.y * 10u + fresh;
            fresh = 5u;
            y.z += fresh;
        }
        carried = 1u;
    }
    return y;
}

fn swap_if(a: ptr<function, u32>, b: ptr<function, u32>, wanted: bool) -> bool {
    if !wanted {
        return false;
    }
    let t = *a;
    *a = *b;
    *b = t;
    return true;
}

struct Walker {
    at: vec3<u32>,
    left: u32,
    going: bool,
}

fn advance(w: ptr<function, Walker>, by: u32) {
    (*w).at.x += by;
    if (*w).left == 0u {
        (*w).going = false;
        return;
    }
    (*w).left--;
    if by % 2u == 1u {
        return;
    }
    (*w).at.z = (*w).at.x * 3u;
}

// bits exact
fn t_lanes_pointers(x: vec4<u32>) -> vec4<u32> {
    var a = x.x;
    var b = x.y;
    var swapped = false;
    if x.z % 3u != 0u {
        swapped = swap_if(&a, &b, x.w % 2u == 0u);
    }
    var w: Walker;
    w.left = x.z % 5u;
    w.going = true;
    while w.going {
        advance(&w, x.w % 7u + w.left);
    }
    return vec4<u32>(a, b, w.at.x + u32(swapped), w.at.z);
}

// bits exact
fn t_lanes_arrays(x: vec4<u32>) -> vec4<u32> {
    var list = array<u32, 5>(1u, 2u, 3u, 4u, 5u);
    var pairs: array<vec2<u32>, 3>;
    list[x.x % 9u] = x.y;
    if x.z % 2u == 0u {
        list[2] += 7u;
        pairs[x.w % 3u].y = list[x.y % 5u];
        pairs[x.y % 4u] += vec2<u32>(1u, x.x);
    }
    for (var i = 0u; i < 5u; i++) {
        list[i] = list[i] * 3u + i;
    }
    var v = x;
    v[x.x % 4u] = list[x.z % 8u];
    return vec4<u32>(v.x ^ v.y ^ v.z ^ v.w, list[x.w], pairs[x.x % 3u].x, pairs[params.v.x % 3u].y);
}

// bits exact
fn t_lanes_long_arrays(x: vec4<u32>) -> vec4<u32> {
    var list: array<f32, 24>;
    for (var i = 0u; i < 24u; i++) {
        list[i] = f32(i * 3u);
    }
    // The same index in all lanes, and in those that come here.
    list[params.v.x % 7u] = f32(x.x % 1000u);
    if x.y % 3u == 0u {
        list[x.y % 3u + 5u] = f32(x.z % 100u);
        list[x.z % 29u] += 0.5 + list[x.w % 31u];
    }
    let same = list[params.v.y % 11u];
    return bitcast<vec4<u32>>(vec4<f32>(list[x.z % 29u], list[x.w], same, list[x.y % 24u]));
}

// bits exact
fn t_lanes_memory(x: vec4<u32>) -> vec4<u32> {
    let i = x.x;
    var sum = items[i].id + words[x.y % 40u] + words[items[x.z % 5u].list[x.w]];
    if x.y % 3u == 1u {
        sum += items[i].v[x.z] + u32(items[i].a.x);
    }
    let whole = items[x.w % 6u];
    return vec4<u32>(sum, whole.list[x.x % 4u], bitcast<u32>(whole.m[x.y % 4u][x.z % 4u]), whole.v.w);
}

// Four neighbours are read at once; some reach past the end.
fn t_lanes_neighbours(x: vec4<u32>) -> vec4<u32> {
    let at = x.x % 40u;
    let four = vec4<u32>(words[at], words[at + 1u], words[at + 2u], words[at + 3u]);
    let turned = vec4<u32>(words[at + 1u], words[at], words[at + 2u], words[at + 3u]);
    let others = vec4<u32>(words[x.y], words[x.y + 1u], words[x.y + 1u], words[x.y + 3u]);
    return four + 3u * turned + 5u * others;
}


// bits exact
fn t_lanes_conditions(x: vec4<u32>) -> vec4<u32> {
    var count = 0u;
    if x.x > 5u && (x.y < 1000000000u || x.z % 2u == 0u) && words[x.w % 37u] > 100u {
        count = 1u;
    } else if x.y == 0u || x.z == 0u {
        count = 2u;
    } else if !(x.x < x.y) {
        if x.z > x.w {
            count = 3u;
        } else {
            return vec4<u32>(99u, count, x.xy);
        }
    }
    return vec4<u32>(count, select(x.x, x.y, count > 1u), x.zw);
}

// bits exact
fn t_lanes_conversions(x: vec4<u32>) -> vec4<u32> {
    // Any bits: infinities and what is no number too.
    let v = bitcast<vec4<f32>>(x);
    let whole = vec2<u32>(u32(v.x), bitcast<u32>(i32(v.y)));
    let back = vec2<f32>(f32(x.z), f32(bitcast<i32>(x.w)));
    return vec4<u32>(whole, bitcast<vec2<u32>>(back));
}

// bits exact
fn t_lanes_order(x: vec4<u32>) -> vec4<u32> {
    let v = bitcast<vec4<f32>>(x);
    let least = vec2<f32>(min(v.x, v.y), max(v.z, v.w));
    var answers = 0u;
    if v.x < v.y { answers |= 1u; }
    if v.x <= v.y { answers |= 2u; }
    if v.x == v.y { answers |= 4u; }
    if v.x != v.y { answers |= 8u; }
    if v.x > v.y { answers |= 16u; }
    if v.x >= v.y { answers |= 32u; }
    return vec4<u32>(bitcast<vec2<u32>>(least), answers, bitcast<u32>(-v.w));
}

// bits exact
fn t_lanes_empty_handed(x: vec4<u32>) -> vec4<u32> {
    if x.x == 0xdeadbeefu {
        // No lane comes here.
        for (var i = 0u; i < 1000u; i++) {
            if i == x.y {
                return vec4<u32>(i);
            }
        }
    }
    return x;
}
