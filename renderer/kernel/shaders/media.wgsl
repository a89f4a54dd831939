// Nested media (Schmidt and Budge, "Simple Nested Dielectrics in Ray Traced Images", JGT 7(2), 2002): the dielectrics
// that a point lies in, by material, the one entered last first, NONE where there are no more. Where several overlap
// the highest priority wins, of equals the one entered last; where the winner is the same on both sides of a boundary,
// there is no boundary.

/// Crossing the boundary of a dielectric.
struct Crossing {
    /// Media beyond the boundary.
    beyond: vec4<u32>,
    /// Refractive index beyond the boundary over that before it.
    eta: f32,
    /// Whether there is nothing to see.
    hidden: bool,
}

fn medium_priority(material: u32) -> i32 {
    return bitcast<i32>(materials[material].kind.z);
}

// The winner of two, of which `a` was entered later.
fn medium_winner(a: u32, b: u32) -> u32 {
    if b != NONE && medium_priority(b) > medium_priority(a) {
        return b;
    }
    return a;
}

/// The medium that holds, or NONE.
fn medium_of(media: vec4<u32>) -> u32 {
    if media.y == NONE {
        return media.x;
    }
    return medium_winner(medium_winner(medium_winner(media.x, media.y), media.z), media.w);
}

fn medium_ior(material: u32) -> f32 {
    if material == NONE {
        return 1.0;
    }
    return materials[material].extra.w;
}

/// Absorption a metre, by channel.
fn media_absorption(media: vec4<u32>) -> vec3<f32> {
    if media.x == NONE {
        return vec3<f32>(0.0);
    }
    return materials[medium_of(media)].extra.xyz;
}

// Of more than four, the one entered first is forgotten.
fn media_enter(media: vec4<u32>, material: u32) -> vec4<u32> {
    return vec4<u32>(material, media.xyz);
}

fn media_leave(media: vec4<u32>, material: u32) -> vec4<u32> {
    if media.x == material {
        return vec4<u32>(media.yzw, NONE);
    }
    if media.y == material {
        return vec4<u32>(media.x, media.zw, NONE);
    }
    if media.z == material {
        return vec4<u32>(media.xy, media.w, NONE);
    }
    if media.w == material {
        return vec4<u32>(media.xyz, NONE);
    }
    return media;
}

/// Through the surface of `material` from its outer side (`front`) or its inner one.
fn media_cross(media: vec4<u32>, material: u32, front: bool) -> Crossing {
    // What is left without having been entered (an open mesh) was there all the time.
    let known = front || any(media == vec4<u32>(material));
    let here = select(media_enter(media, material), media, known);
    let beyond = select(media_leave(here, material), media_enter(here, material), front);
    let a = medium_of(here);
    let b = medium_of(beyond);
    return Crossing(beyond, medium_ior(b) / medium_ior(a), a == b);
}

/// Through the surface `b`, whatever it is, from its outer side (`front`) or its inner one.
fn boundary_at(b: Bsdf, media: vec4<u32>, front: bool) -> Crossing {
    if b.kind == MATERIAL_DIELECTRIC && (b.flags & DIELECTRIC_THIN) == 0u {
        return media_cross(media, b.material, front);
    }
    return Crossing(media, b.eta, false);
}

/// What is left of light after `distance` metres.
fn transmittance(absorption: vec3<f32>, distance: f32) -> vec3<f32> {
    if max_component(absorption) <= 0.0 {
        return vec3<f32>(1.0);
    }
    let depth = absorption * distance;
    return vec3<f32>(exp_(-depth.x), exp_(-depth.y), exp_(-depth.z));
}
