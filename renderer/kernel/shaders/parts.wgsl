// The light of a path in parts, by what it did where the camera's ray was scattered first. The steps are those of
// path.wgsl; whoever wants no parts pays nothing for them.

struct Parts {
    /// As `path_light`: of the whole path, the sum of the three parts up to rounding.
    light: vec4<f32>,
    /// From emitters and the sky that the camera's ray meets itself.
    emission: vec3<f32>,
    /// What was scattered first by a diffuse lobe.
    diffuse: vec3<f32>,
    /// By any other: metals, glass both ways, coats and sheen.
    specular: vec3<f32>,
    /// The diffuse share of what still arrives.
    ahead: vec3<f32>,
    /// And of what the shadow ray asks for.
    shadow: vec3<f32>,
}

fn parts_add(parts: ptr<function, Parts>, light: vec3<f32>, diffuse: vec3<f32>) {
    (*parts).diffuse += light * diffuse;
    (*parts).specular += light * (vec3<f32>(1.0) - diffuse);
}

/// `path_shade`, with a look at what the surface does that scatters first.
fn parts_shade(parts: ptr<function, Parts>, path: ptr<function, Path>, hit: Hit) {
    let first = (*path).bounce == 0u;
    var v: Vertex;
    var b: Bsdf;
    if first && hit.id != NONE {
        let s = surface_at(hit, (*path).o, (*path).d);
        let material = shapes[s.shape].index.x;
        v = vertex_at(s, (*path).d);
        b = bsdf_on(material, s, &v, material_choice(path, material).x);
    }
    let before = (*path).light;
    (*path).light = vec3<f32>(0.0);
    path_shade(path, hit);
    let light = (*path).light;
    (*path).light = before + light;
    if !first {
        parts_add(parts, light, (*parts).ahead);
        (*parts).shadow = (*parts).ahead;
        return;
    }
    (*parts).emission += light;
    if (*path).shadow_t > 0.0 {
        (*parts).shadow = bsdf_diffuse(b, v.wo, to_local(v.frame, (*path).shadow_d));
    }
    if (*path).bounce > 0u && (*path).pdf != DELTA_PDF {
        (*parts).ahead = bsdf_diffuse(b, v.wo, to_local(v.frame, (*path).d));
    }
}

/// `path_shadow`.
fn parts_shadow(parts: ptr<function, Parts>, path: ptr<function, Path>, share: f32) {
    parts_add(parts, (*path).shadow_light * share, (*parts).shadow);
    path_shadow(path, share);
}

/// The parts of a path that has ended.
fn parts_end(parts: Parts, path: Path) -> Parts {
    if !is_light(path.light) {
        var none: Parts;
        none.light = path_light(path);
        return none;
    }
    var whole = parts;
    whole.light = path_light(path);
    return whole;
}

/// One sample of the light that a pixel receives, in parts.
fn radiance_parts(pixel: vec2<u32>, sample: u32) -> Parts {
    var parts: Parts;
    var path = path_start(pixel, sample);
    while path.alive {
        let hit = closest_hit(path.o, path.d, path.start);
        parts_shade(&parts, &path, hit);
        if path.shadow_t > 0.0 {
            parts_shadow(&parts, &path, shadow_share(path.shadow_o, path.shadow_d, path.shadow_t, path.start));
        }
    }
    return parts_end(parts, path);
}

/// Sums over several samples of a pixel.
struct PartsSum {
    /// w: rays.
    light: vec4<f32>,
    /// Of the light: squared distances from its mean; w: how many samples there are.
    squares: vec4<f32>,
    /// w of these: unused.
    emission: vec4<f32>,
    diffuse: vec4<f32>,
    specular: vec4<f32>,
}

/// `sum` and one sample more.
fn parts_sum(sum: PartsSum, sample: Parts) -> PartsSum {
    // Welford's recurrence: what does not vary has no variance at all.
    let count = sum.squares.w;
    let off = sample.light.xyz - sum.light.xyz / max(count, 1.0);
    return PartsSum(
        sum.light + sample.light,
        sum.squares + vec4<f32>(off * off * (count / (count + 1.0)), 1.0),
        sum.emission + vec4<f32>(sample.emission, 0.0),
        sum.diffuse + vec4<f32>(sample.diffuse, 0.0),
        sum.specular + vec4<f32>(sample.specular, 0.0),
    );
}
