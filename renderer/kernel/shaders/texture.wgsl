// Textures: what scales a property of a material from point to point. All of it lies among `words`: a table of what each
// material's maps are (`Params::textures`), lists of maps, textures as headers, texels, and what a mesh's vertices
// have besides their positions. Place 0 stands for nothing.

/// What stands at the beginning of `words` where there are textures. 256 numbers: what sRGB's 8-bit codes mean.
const WORDS_SRGB: u32 = 1u;
/// What metals lose on average without scattering more than once: by roughness, then by roughness and anisotropy, at the
/// nodes of the tables of albedos.
const WORDS_LOST: u32 = 257u;
const WORDS_LOST_STRETCHED: u32 = WORDS_LOST + METAL_ROUGHNESSES;
const WORDS_END: u32 = WORDS_LOST_STRETCHED + STRETCHED_ROUGHNESSES * STRETCHED_ANISOTROPIES;

/// The first word of a texture: its kind.
const TEXTURE_KIND: u32 = 15u;
/// Then red, green, blue and alpha.
const TEXTURE_CONSTANT: u32 = 0u;
/// Then the two textures, and squares a unit of u and of v.
const TEXTURE_CHECKER: u32 = 1u;
/// Nothing else.
const TEXTURE_VERTEX_COLOR: u32 = 2u;
/// Then width, height, the place of the texels, and the rows of the affine map from uv to the picture.
const TEXTURE_IMAGE: u32 = 3u;
/// See tape.wgsl.
const TEXTURE_TAPE: u32 = 4u;
/// Bits of the first word: all of the colour, or one channel in all of it.
const TEXTURE_CHANNEL: u32 = 4u;
const TEXTURE_CHANNEL_MASK: u32 = 7u;
/// Coordinates are a mesh's second ones.
const TEXTURE_SECOND_UV: u32 = 0x80u;
/// An image's wrap along u, then along v: 0 repeats, 1 mirrors, 2 holds the edge.
const TEXTURE_WRAP_U: u32 = 8u;
const TEXTURE_WRAP_V: u32 = 10u;
const WRAP_REPEAT: u32 = 0u;
const WRAP_MIRROR: u32 = 1u;
const WRAP_CLAMP: u32 = 2u;
const TEXTURE_NEAREST: u32 = 0x1000u;
/// How its texels are stored: a byte a channel, 16 bits, or floats.
const TEXTURE_FORMAT: u32 = 16u;
const FORMAT_SRGB_8: u32 = 0u;
const FORMAT_LINEAR_8: u32 = 1u;
const FORMAT_SRGB_16: u32 = 2u;
const FORMAT_LINEAR_16: u32 = 3u;
const FORMAT_FLOAT: u32 = 4u;
/// Textures inside one another; deeper ones are refused when the scene is packed.
const MAX_TEXTURES: u32 = 16u;

/// What a map scales: the first word of each of a list's pairs, whose second is the texture.
const SLOT_COLOR: u32 = 0u;
const SLOT_EDGE_TINT: u32 = 1u;
const SLOT_ROUGHNESS: u32 = 2u;
const SLOT_ANISOTROPY: u32 = 3u;
const SLOT_METALNESS: u32 = 4u;
const SLOT_AMOUNT: u32 = 5u;
/// Which way a metal is stretched, and how far.
const SLOT_STRETCH: u32 = 6u;

/// The four words of a material at `Params::textures`: the list of its maps, the terms of its opacity, its normal
/// map (the texture, then the strength), and flags.
const MAPS_LIST: u32 = 0u;
const MAPS_OPACITY: u32 = 1u;
const MAPS_NORMAL: u32 = 2u;
const MAPS_FLAGS: u32 = 3u;
const MAPS_SIZE: u32 = 4u;
/// mix: the opacities of its parts are not the same everywhere, and its share is the amount itself.
const MAPS_OPEN: u32 = 1u;
/// glossy: something under the coat has a normal of its own.
const MAPS_SPLIT: u32 = 2u;

/// The places of what a mesh's vertices have: `mesh` of a surface. Three vertices a triangle; two numbers each for the
/// coordinates, four for a colour, one packed direction for a tangent.
const MESH_CORNERS: u32 = 0u;
const MESH_UVS: u32 = 1u;
const MESH_MORE_UVS: u32 = 2u;
const MESH_COLORS: u32 = 3u;
const MESH_TANGENTS: u32 = 4u;
const MESH_SIZE: u32 = 5u;

fn has_textures() -> bool {
    return (params.features & FEATURE_TEXTURE) != 0u;
}

fn has_normal_maps() -> bool {
    return (params.features & FEATURE_NORMAL_MAP) != 0u;
}

// Word `which` of a material's maps.
fn maps_of(material: u32, which: u32) -> u32 {
    return words[params.textures.x + material * MAPS_SIZE + which];
}

fn word_pair(i: u32) -> vec2<f32> {
    return vec2<f32>(word_float(i), word_float(i + 1u));
}

fn word_color(i: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(words_from(i));
}

// The vertices of a triangle of a mesh.
fn mesh_corners(mesh: u32, triangle: u32) -> vec3<u32> {
    let at = words[mesh + MESH_CORNERS] + 3u * triangle;
    return vec3<u32>(words[at], words[at + 1u], words[at + 2u]);
}

fn mesh_pair(at: u32, corners: vec3<u32>, uv: vec2<f32>) -> vec2<f32> {
    return (1.0 - uv.x - uv.y) * word_pair(at + 2u * corners.x) + uv.x * word_pair(at + 2u * corners.y)
        + uv.y * word_pair(at + 2u * corners.z);
}

// The coordinates of a point.
fn surface_uv(s: Surface, second: bool) -> vec2<f32> {
    if second && s.mesh != 0u {
        let more = words[s.mesh + MESH_MORE_UVS];
        if more != 0u {
            return mesh_pair(more, mesh_corners(s.mesh, s.primitive), s.at);
        }
    }
    return s.uv;
}

fn vertex_color(s: Surface) -> vec4<f32> {
    if s.mesh == 0u {
        return vec4<f32>(1.0);
    }
    let colors = words[s.mesh + MESH_COLORS];
    if colors == 0u {
        return vec4<f32>(1.0);
    }
    let c = mesh_corners(s.mesh, s.primitive);
    return (1.0 - s.at.x - s.at.y) * word_color(colors + 4u * c.x) + s.at.x * word_color(colors + 4u * c.y)
        + s.at.y * word_color(colors + 4u * c.z);
}

fn srgb_decode(x: f32) -> f32 {
    if x <= 0.04045 {
        return x * 0.07739938080495357;
    }
    return pow_((x + 0.055) * 0.9478672985781991, 2.4);
}

// Texel `i` of an image.
fn texel(format: u32, at: u32, i: u32) -> vec4<f32> {
    if format <= FORMAT_LINEAR_8 {
        let w = words[at + i];
        let a = f32(w >> 24u) * 0.00392156862745098;
        let bytes = vec3<u32>(w & 255u, (w >> 8u) & 255u, (w >> 16u) & 255u);
        if format == FORMAT_SRGB_8 {
            return vec4<f32>(
                word_float(WORDS_SRGB + bytes.x),
                word_float(WORDS_SRGB + bytes.y),
                word_float(WORDS_SRGB + bytes.z),
                a,
            );
        }
        return vec4<f32>(vec3<f32>(bytes) * 0.00392156862745098, a);
    }
    if format <= FORMAT_LINEAR_16 {
        let low = words[at + 2u * i];
        let high = words[at + 2u * i + 1u];
        let c = vec4<f32>(vec4<u32>(low & 65535u, low >> 16u, high & 65535u, high >> 16u)) * 1.52590218966964e-5;
        if format == FORMAT_SRGB_16 {
            return vec4<f32>(srgb_decode(c.x), srgb_decode(c.y), srgb_decode(c.z), c.w);
        }
        return c;
    }
    return word_color(at + 4u * i);
}

// x wrapped into one or two pictures, in texels of `size`; NaN and infinities are somewhere.
fn wrap_coordinate(x: f32, wrap: u32, size: f32) -> f32 {
    if wrap == WRAP_REPEAT {
        return clamp((x - floor(x)) * size, 0.0, size);
    }
    if wrap == WRAP_MIRROR {
        let half = 0.5 * x;
        return clamp((half - floor(half)) * (2.0 * size), 0.0, 2.0 * size);
    }
    return clamp(x * size, 0.0, size);
}

// Texel number i, which is at most one beyond what `wrap_coordinate` gives, in 0 .. size - 1.
fn wrap_index(i: i32, wrap: u32, size: i32) -> u32 {
    var j = i;
    if wrap == WRAP_REPEAT {
        j = select(j, j + size, j < 0);
        j = select(j, j - size, j >= size);
    } else if wrap == WRAP_MIRROR {
        j = select(j, -1 - j, j < 0);
        j = select(j, j - 2 * size, j >= 2 * size);
        j = select(j, 2 * size - 1 - j, j >= size);
    }
    return u32(clamp(j, 0, size - 1));
}

// An image at a point of uv.
fn image_value(at: u32, uv: vec2<f32>) -> vec4<f32> {
    let head = words[at];
    let width = words[at + 1u];
    let height = words[at + 2u];
    let texels = words[at + 3u];
    let format = (head >> TEXTURE_FORMAT) & 7u;
    let wrap_u = (head >> TEXTURE_WRAP_U) & 3u;
    let wrap_v = (head >> TEXTURE_WRAP_V) & 3u;
    let st = vec2<f32>(
        word_float(at + 4u) * uv.x + word_float(at + 5u) * uv.y + word_float(at + 6u),
        word_float(at + 7u) * uv.x + word_float(at + 8u) * uv.y + word_float(at + 9u),
    );
    let x = wrap_coordinate(st.x, wrap_u, f32(width));
    let y = wrap_coordinate(st.y, wrap_v, f32(height));
    if (head & TEXTURE_NEAREST) != 0u {
        let column = wrap_index(i32(x), wrap_u, i32(width));
        let row = wrap_index(i32(y), wrap_v, i32(height));
        return texel(format, texels, (height - 1u - row) * width + column);
    }
    let left = floor(x - 0.5);
    let low = floor(y - 0.5);
    let f = vec2<f32>(x - 0.5 - left, y - 0.5 - low);
    let x0 = wrap_index(i32(left), wrap_u, i32(width));
    let x1 = wrap_index(i32(left) + 1, wrap_u, i32(width));
    // The top row comes first.
    let y0 = (height - 1u - wrap_index(i32(low), wrap_v, i32(height))) * width;
    let y1 = (height - 1u - wrap_index(i32(low) + 1, wrap_v, i32(height))) * width;
    let below = mix(texel(format, texels, y0 + x0), texel(format, texels, y0 + x1), f.x);
    let above = mix(texel(format, texels, y1 + x0), texel(format, texels, y1 + x1), f.x);
    return mix(below, above, f.y);
}

/// The texture at a point.
fn texture_value(texture: u32, s: Surface) -> vec4<f32> {
    var at = texture;
    var value = vec4<f32>(1.0);
    for (var depth = 0u; depth < MAX_TEXTURES; depth++) {
        let head = words[at];
        let kind = head & TEXTURE_KIND;
        if kind == TEXTURE_CHECKER {
            let square = surface_uv(s, (head & TEXTURE_SECOND_UV) != 0u) * word_pair(at + 3u);
            let half = floor(square) * 0.5;
            // The index is odd along u, along v.
            let odd = half != floor(half);
            at = words[at + select(1u, 2u, odd.x != odd.y)];
            continue;
        }
        if kind == TEXTURE_CONSTANT {
            value = word_color(at + 1u);
        } else if kind == TEXTURE_VERTEX_COLOR {
            value = vertex_color(s);
        } else if (params.features & FEATURE_TAPE) != 0u && kind == TEXTURE_TAPE {
            value = tape_value(at, s);
        } else {
            value = image_value(at, surface_uv(s, (head & TEXTURE_SECOND_UV) != 0u));
        }
        switch (head >> TEXTURE_CHANNEL) & TEXTURE_CHANNEL_MASK {
            case 1u: {
                value = value.xxxx;
            }
            case 2u: {
                value = value.yyyy;
            }
            case 3u: {
                value = value.zzzz;
            }
            case 4u: {
                value = value.wwww;
            }
            default: {}
        }
        break;
    }
    return value;
}

// One factor at `at`, which is moved behind it: a number, or 1 − it, times textures; 0 or 1 where there is a cutoff.
fn factor_value(at: ptr<function, u32>, s: Surface) -> f32 {
    var x = word_float(*at);
    let cutoff = word_float(*at + 1u);
    let count = words[*at + 2u];
    *at += 3u;
    for (var i = 0u; i < (count >> 1u); i++) {
        x *= texture_value(words[*at], s).x;
        *at += 1u;
    }
    x = clamp(x, 0.0, 1.0);
    if cutoff >= 0.0 {
        x = select(0.0, 1.0, x >= cutoff);
    }
    return select(x, 1.0 - x, (count & 1u) != 0u);
}

// A sum of products at `place`: how many, and of each how many factors, then these.
fn terms_value(place: u32, s: Surface) -> f32 {
    var at = place + 1u;
    var sum = 0.0;
    for (var term = 0u; term < words[place]; term++) {
        let count = words[at];
        at += 1u;
        var product = 1.0;
        for (var i = 0u; i < count; i++) {
            product *= factor_value(&at, s);
        }
        sum += product;
    }
    return sum;
}

/// The share of rays that the material meets at a point.
fn opacity_on(material: u32, s: Surface) -> f32 {
    if has_textures() {
        let terms = maps_of(material, MAPS_OPACITY);
        if terms != 0u {
            return terms_value(terms, s);
        }
    }
    return materials[material].more.w;
}

// GGX α along and across the tangent (OpenPBR 1.1); smooth only as a whole.
fn ggx_widths(roughness: f32, anisotropy: f32) -> vec2<f32> {
    let across = 1.0 - anisotropy;
    let along = square(roughness) * sqrt(2.0 / (1.0 + across * across));
    let widths = vec2<f32>(along, across * along);
    return max(widths, vec2<f32>(select(MIRROR_ALPHA, 0.0, along < MIRROR_ALPHA)));
}

// What a metal loses on average without scattering more than once.
fn average_lost(roughness: f32, anisotropy: f32) -> f32 {
    if anisotropy == 0.0 {
        let r = cell_of(roughness, METAL_ROUGHNESSES);
        return mix(word_float(WORDS_LOST + r.i), word_float(WORDS_LOST + r.i + 1u), r.f);
    }
    let r = cell_of(roughness, STRETCHED_ROUGHNESSES);
    let a = cell_of(anisotropy, STRETCHED_ANISOTROPIES);
    let at = WORDS_LOST_STRETCHED + a.i * STRETCHED_ROUGHNESSES + r.i;
    let next = at + STRETCHED_ROUGHNESSES;
    return mix(
        mix(word_float(at), word_float(at + 1u), r.f),
        mix(word_float(next), word_float(next + 1u), r.f),
        a.f,
    );
}

// Roughness and anisotropy where α is widened along the tangent to mix(α, 1, strength²) and kept across it
// (KHR_materials_anisotropy), as `ggx_widths` takes them.
fn stretched(roughness: f32, strength: f32) -> vec2<f32> {
    if strength == 0.0 {
        return vec2<f32>(roughness, 0.0);
    }
    let across = max(square(roughness), MIRROR_ALPHA);
    let along = mix(across, 1.0, square(strength));
    let ratio = across / along;
    return vec2<f32>(min(sqrt(along / sqrt(2.0 / (1.0 + square(ratio)))), 1.0), 1.0 - ratio);
}

// What follows from a metal's values: α, the term a of F82-tint from the tint in `extra`, and what is scattered more than
// once, from the average reflectance in `more` where it is measured.
fn finish_metal(m: ptr<function, Material>) {
    let roughness = (*m).lobe.z;
    let anisotropy = (*m).lobe.w;
    (*m).lobe = vec4<f32>(ggx_widths(roughness, anisotropy), roughness, anisotropy);
    let flags = (*m).kind.y;
    var average = (*m).more.xyz;
    if (flags & METAL_SPECTRUM) == 0u {
        let color = (*m).color.xyz;
        let grazing = vec3<f32>(1.0) - color;
        let term = (color + grazing * 0.46266436) * (vec3<f32>(1.0) - (*m).extra.xyz) / 0.05665278;
        (*m).extra = vec4<f32>(term, (*m).extra.w);
        // 2 ∫ F(c) c dc of both of its terms.
        average = clamp(color + grazing / 21.0 - term / 126.0, vec3<f32>(0.0), vec3<f32>(1.0));
    }
    if (flags & COMPENSATE) == 0u {
        return;
    }
    let lost = average_lost(roughness, anisotropy);
    if (*m).lobe.x < MIRROR_ALPHA || lost < 1e-5 {
        (*m).kind.y = flags & ~COMPENSATE;
        return;
    }
    let multiple = average * average * (1.0 - lost) / (vec3<f32>(1.0) - average * lost);
    (*m).more = vec4<f32>(multiple / lost, (*m).more.w);
}

/// A material's record at a point, its maps applied.
fn material_on(material: u32, s: Surface) -> Material {
    var m = materials[material];
    let list = maps_of(material, MAPS_LIST);
    if list != 0u {
        for (var i = 0u; i < words[list]; i++) {
            let value = texture_value(words[list + 2u + 2u * i], s).xyz;
            switch words[list + 1u + 2u * i] {
                case SLOT_COLOR: {
                    m.color = vec4<f32>(m.color.xyz * value, m.color.w);
                }
                case SLOT_EDGE_TINT: {
                    m.extra = vec4<f32>(m.extra.xyz * value, m.extra.w);
                }
                case SLOT_ROUGHNESS: {
                    m.lobe.z *= value.x;
                }
                case SLOT_ANISOTROPY, SLOT_METALNESS: {
                    m.lobe.w *= value.x;
                }
                case SLOT_STRETCH: {
                    m.lobe.w *= value.z;
                    let way = 2.0 * value.xy - vec2<f32>(1.0);
                    let length_2 = dot(way, way);
                    if length_2 > 1e-6 {
                        let turn = way / sqrt(length_2);
                        let cosine = m.color.w * turn.x - m.extra.w * turn.y;
                        m.extra.w = m.extra.w * turn.x + m.color.w * turn.y;
                        m.color.w = cosine;
                    }
                }
                default: {
                    m.lobe.x *= value.x;
                }
            }
        }
        m.lobe.z = clamp(m.lobe.z, 0.0, 1.0);
        m.lobe.w = clamp(m.lobe.w, 0.0, 1.0);
        switch m.kind.x {
            case MATERIAL_DIFFUSE: {
                m.color = clamp(m.color, vec4<f32>(0.0), vec4<f32>(1.0));
            }
            case MATERIAL_METAL: {
                if (m.kind.y & METAL_STRETCHED) != 0u {
                    m.lobe = vec4<f32>(m.lobe.xy, stretched(m.lobe.z, m.lobe.w));
                }
                if (m.kind.y & METAL_SPECTRUM) == 0u {
                    m.color = vec4<f32>(clamp(m.color.xyz, vec3<f32>(0.0), vec3<f32>(1.0)), m.color.w);
                    m.extra = vec4<f32>(clamp(m.extra.xyz, vec3<f32>(0.0), vec3<f32>(1.0)), m.extra.w);
                }
                finish_metal(&m);
            }
            case MATERIAL_DIELECTRIC: {
                m.color = clamp(m.color, vec4<f32>(0.0), vec4<f32>(1.0));
                if (m.kind.y & DIELECTRIC_THIN) == 0u {
                    // Light passes the boundary of a body twice.
                    m.color = sqrt(m.color);
                }
                let widths = ggx_widths(m.lobe.z, 0.0);
                m.lobe = vec4<f32>(widths, m.lobe.zw);
                if widths.x < MIRROR_ALPHA {
                    m.kind.y = m.kind.y & ~COMPENSATE;
                }
            }
            case MATERIAL_GLOSSY: {
                m.color = clamp(m.color, vec4<f32>(0.0), vec4<f32>(1.0));
                m.lobe.x = ggx_widths(m.lobe.z, 0.0).x;
            }
            case MATERIAL_SHEEN: {
                m.color = clamp(m.color, vec4<f32>(0.0), vec4<f32>(1.0));
            }
            default: {
                m.lobe.x = clamp(m.lobe.x, 0.0, 1.0);
            }
        }
    }
    if m.kind.x == MATERIAL_MIX && (maps_of(material, MAPS_FLAGS) & MAPS_OPEN) != 0u {
        // Of the rays that meet it, the share that meets the second.
        let second = m.lobe.x * opacity_on(m.kind.w, s);
        let met = (1.0 - m.lobe.x) * opacity_on(m.kind.z, s) + second;
        m.lobe.x = select(0.0, second / met, met > 0.0);
    }
    return m;
}

/// Where an albedo is read for what is seen from below.
const MIN_COSINE: f32 = 1e-3;
/// How far above the geometric surface a mirrored view stays, at most.
const BENT_REACH: f32 = 0.01;

// Turns the vertex's frame to the material's normal map; whether it has one.
fn turn_normal(material: u32, s: Surface, v: ptr<function, Vertex>) -> bool {
    if !has_normal_maps() {
        return false;
    }
    let map = maps_of(material, MAPS_NORMAL);
    if map == 0u {
        return false;
    }
    let wo = from_local((*v).frame, (*v).wo);
    let color = texture_value(words[map], s).xyz;
    let strength = word_float(map + 1u);
    let n = vec3<f32>((2.0 * color.xy - 1.0) * strength, max(2.0 * color.z - 1.0, 0.0));
    var frame = frame_along(s.ns, s.tangent, vec2<f32>(1.0, 0.0));
    frame.y *= s.side;
    let turned = from_local(frame, n);
    let length_2 = dot(turned, turned);
    if length_2 > 1e-12 {
        let normal = turned / sqrt(length_2);
        (*v).frame = frame_about(select(-normal, normal, (*v).front));
        (*v).wo = to_local((*v).frame, wo);
    }
    return true;
}

// The vertex as it can be shaded: a normal map may turn the normal so far that the eye, or its mirror image, lies below
// it. Matt surfaces are lit by the normal as it is, and the eye is put on their horizon. Everything else is bent towards
// the eye until what it mirrors lies above the geometric surface (Keller et al., "The Iray Light Transport Simulation
// and Rendering System", 2017, §A.3).
fn bend_normal(v: ptr<function, Vertex>, matt: bool) {
    if matt {
        if (*v).wo.z < 1e-3 {
            (*v).wo = normalize(vec3<f32>((*v).wo.xy, 1e-3));
        }
        return;
    }
    let wo = from_local((*v).frame, (*v).wo);
    let mirrored = 2.0 * (*v).wo.z * (*v).frame.z - wo;
    let height = dot(mirrored, (*v).ng);
    let least = min(0.9 * dot(wo, (*v).ng), BENT_REACH);
    if height < least || (*v).wo.z <= 0.0 {
        (*v).frame = frame_about(normalize(wo + normalize(mirrored + (least - height) * (*v).ng)));
        (*v).wo = to_local((*v).frame, wo);
    }
}
