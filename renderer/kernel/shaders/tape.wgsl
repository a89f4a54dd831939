// Tapes: textures that are computed at a point, step by step, from where it is. A step reads three places and writes
// one; the scene's values are data among `words`, so that a change of them compiles nothing.

/// Of a texture's first word: where it is in the shape's own space is read.
const TAPE_READS_LOCAL: u32 = 0x100u;
/// After the first word: how many steps, the places of red, green and blue in the end (six bits each), the steps.
const TAPE_STEPS: u32 = 3u;
/// Words of a step: what is done, then from bit 8 on the place that it writes and the three that it reads, six bits each;
/// and its number.
const TAPE_STEP: u32 = 2u;
/// The most steps.
const TAPE_LONGEST: u32 = 1024u;

/// Places below this are the tape's own; here is the step's number, then the point in the world and in the shape's own
/// space, its coordinates and its normal.
const TAPE_NUMBER: u32 = 52u;
const TAPE_WORLD: u32 = 53u;
const TAPE_LOCAL: u32 = 56u;
const TAPE_UV: u32 = 59u;
const TAPE_NORMAL: u32 = 61u;
const TAPE_PLACES: u32 = 64u;

/// What a step does with one number.
const TAPE_NEG: u32 = 0u;
const TAPE_NOT: u32 = 1u;
const TAPE_ABS: u32 = 2u;
const TAPE_SIGN: u32 = 3u;
const TAPE_FLOOR: u32 = 4u;
const TAPE_CEIL: u32 = 5u;
const TAPE_ROUND: u32 = 6u;
const TAPE_SQRT: u32 = 7u;
const TAPE_EXP: u32 = 8u;
const TAPE_LOG: u32 = 9u;
const TAPE_SIN: u32 = 10u;
const TAPE_COS: u32 = 11u;
const TAPE_TAN: u32 = 12u;
const TAPE_ASIN: u32 = 13u;
const TAPE_ACOS: u32 = 14u;
const TAPE_ATAN: u32 = 15u;
const TAPE_COPY: u32 = 16u;
/// With two.
const TAPE_BINARY: u32 = 32u;
const TAPE_ADD: u32 = 32u;
const TAPE_SUB: u32 = 33u;
const TAPE_MUL: u32 = 34u;
const TAPE_DIV: u32 = 35u;
const TAPE_MOD: u32 = 36u;
const TAPE_POW: u32 = 37u;
const TAPE_ATAN2: u32 = 38u;
const TAPE_MIN: u32 = 39u;
const TAPE_MAX: u32 = 40u;
const TAPE_LESS: u32 = 41u;
const TAPE_LESS_EQUAL: u32 = 42u;
const TAPE_EQUAL: u32 = 43u;
const TAPE_AND: u32 = 44u;
const TAPE_OR: u32 = 45u;
/// With three.
const TAPE_TERNARY: u32 = 64u;
const TAPE_SELECT: u32 = 64u;
const TAPE_NOISE: u32 = 65u;
/// The distance to the nearest point of a cell, over so many coordinates, or its number.
const TAPE_CELL_1: u32 = 66u;
const TAPE_CELL_2: u32 = 67u;
const TAPE_CELL_3: u32 = 68u;
const TAPE_CELL_ID_1: u32 = 69u;
const TAPE_CELL_ID_2: u32 = 70u;
const TAPE_CELL_ID_3: u32 = 71u;

// (cos x, sin x), however large x is; where the number itself says no more, still within -1..1.
fn any_cos_sin(x: f32) -> vec2<f32> {
    let turned = x - TWO_PI * floor(x * 0.15915494309189535);
    return cos_sin(clamp(select(x, turned, abs(x) > 1000.0), -1000.0, 1000.0));
}

fn tape_unary(operation: u32, a: f32) -> f32 {
    var value = a;
    switch operation {
        case TAPE_NEG: {
            value = -a;
        }
        case TAPE_NOT: {
            value = select(0.0, 1.0, a == 0.0);
        }
        case TAPE_ABS: {
            value = abs(a);
        }
        case TAPE_SIGN: {
            value = sign(a);
        }
        case TAPE_FLOOR: {
            value = floor(a);
        }
        case TAPE_CEIL: {
            value = -floor(-a);
        }
        case TAPE_ROUND: {
            value = sign(a) * floor(abs(a) + 0.5);
        }
        case TAPE_SQRT: {
            value = sqrt(a);
        }
        case TAPE_EXP: {
            value = exp_(a);
        }
        case TAPE_LOG: {
            value = log_(a);
        }
        case TAPE_SIN: {
            value = any_cos_sin(a).y;
        }
        case TAPE_COS: {
            value = any_cos_sin(a).x;
        }
        case TAPE_TAN: {
            let c = any_cos_sin(a);
            value = c.y / c.x;
        }
        case TAPE_ASIN: {
            value = HALF_PI - acos_(a);
        }
        case TAPE_ACOS: {
            value = acos_(a);
        }
        case TAPE_ATAN: {
            value = atan_(a);
        }
        default: {}
    }
    return value;
}

// Of a number below 0 there is a power where the exponent is whole.
fn any_pow(a: f32, b: f32) -> f32 {
    let power = pow_(abs(a), b);
    let half = 0.5 * b;
    return select(power, -power, a < 0.0 && half != floor(half));
}

fn tape_binary(operation: u32, a: f32, b: f32) -> f32 {
    var value = 0.0;
    switch operation {
        case TAPE_ADD: {
            value = a + b;
        }
        case TAPE_SUB: {
            value = a - b;
        }
        case TAPE_MUL: {
            value = a * b;
        }
        case TAPE_DIV: {
            value = a / b;
        }
        case TAPE_MOD: {
            value = a - b * floor(a / b);
        }
        case TAPE_POW: {
            value = any_pow(a, b);
        }
        case TAPE_ATAN2: {
            value = TWO_PI * turn_of(b, a);
        }
        case TAPE_MIN: {
            value = min(a, b);
        }
        case TAPE_MAX: {
            value = max(a, b);
        }
        case TAPE_LESS: {
            value = select(0.0, 1.0, a < b);
        }
        case TAPE_LESS_EQUAL: {
            value = select(0.0, 1.0, a <= b);
        }
        case TAPE_EQUAL: {
            value = select(0.0, 1.0, a == b);
        }
        case TAPE_AND: {
            value = select(0.0, 1.0, a != 0.0 && b != 0.0);
        }
        case TAPE_OR: {
            value = select(0.0, 1.0, a != 0.0 || b != 0.0);
        }
        default: {}
    }
    return value;
}

fn tape_ternary(operation: u32, a: f32, b: f32, c: f32) -> f32 {
    if operation == TAPE_SELECT {
        return select(c, b, a != 0.0);
    }
    if operation == TAPE_NOISE {
        return gradient_noise(vec3<f32>(a, b, c));
    }
    let number = operation >= TAPE_CELL_ID_1;
    let axes = operation - select(TAPE_CELL_1, TAPE_CELL_ID_1, number) + 1u;
    let cell = cellular_noise(vec3<f32>(a, b, c), axes);
    return select(cell.x, cell.y, number);
}

// Where the point is in its shape's own space, before it is placed.
fn local_point(s: Surface) -> vec3<f32> {
    if params.textures.y == 0u {
        return s.p;
    }
    let rows = words[params.textures.y + s.shape];
    var p = s.p;
    if rows == 0u {
        return p;
    }
    if s.copy != 0u {
        p = object_point(s.copy - 1u, p);
    }
    let q = vec4<f32>(p, 1.0);
    return vec3<f32>(dot(word_color(rows), q), dot(word_color(rows + 4u), q), dot(word_color(rows + 8u), q));
}

/// The value of the tape at `at` at a point.
fn tape_value(at: u32, s: Surface) -> vec4<f32> {
    var places: array<f32, TAPE_PLACES>;
    places[TAPE_WORLD] = s.p.x;
    places[TAPE_WORLD + 1u] = s.p.y;
    places[TAPE_WORLD + 2u] = s.p.z;
    places[TAPE_UV] = s.uv.x;
    places[TAPE_UV + 1u] = s.uv.y;
    places[TAPE_NORMAL] = s.ns.x;
    places[TAPE_NORMAL + 1u] = s.ns.y;
    places[TAPE_NORMAL + 2u] = s.ns.z;
    if (words[at] & TAPE_READS_LOCAL) != 0u {
        let p = local_point(s);
        places[TAPE_LOCAL] = p.x;
        places[TAPE_LOCAL + 1u] = p.y;
        places[TAPE_LOCAL + 2u] = p.z;
    }
    let begin = at + TAPE_STEPS;
    let end = begin + TAPE_STEP * words[at + 1u];
    for (var step = begin; step < end; step += TAPE_STEP) {
        let code = words[step];
        places[TAPE_NUMBER] = word_float(step + 1u);
        let operation = code & 255u;
        let a = places[(code >> 14u) & 63u];
        var value = 0.0;
        if operation < TAPE_BINARY {
            value = tape_unary(operation, a);
        } else {
            let b = places[(code >> 20u) & 63u];
            if operation < TAPE_TERNARY {
                value = tape_binary(operation, a, b);
            } else {
                value = tape_ternary(operation, a, b, places[code >> 26u]);
            }
        }
        places[(code >> 8u) & 63u] = value;
    }
    let outputs = words[at + 2u];
    let color = vec3<f32>(places[outputs & 63u], places[(outputs >> 6u) & 63u], places[(outputs >> 12u) & 63u]);
    // What is no number is in no order.
    return vec4<f32>(select(vec3<f32>(0.0), color, abs(color) <= vec3<f32>(FAR)), 1.0);
}
