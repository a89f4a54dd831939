//! "Did you mean": names close to a name that is not known.

use strsim::damerau_levenshtein;

use crate::diagnostic::Applicability;

/// What the same thing is called elsewhere, and what it is called here.
const FOREIGN: &[(&str, &str)] = &[
    ("albedo", "color"),
    ("base_color", "color"),
    ("basecolor", "color"),
    ("kd", "color"),
    ("rgb", "color"),
    ("colour", "color"),
    ("tint", "edge_tint"),
    ("emission", "emitter"),
    ("emissive", "emitter"),
    ("light", "point_light"),
    ("lamp", "point_light"),
    ("area_light", "emitter"),
    ("lambert", "diffuse"),
    ("matte", "diffuse"),
    ("phong", "glossy"),
    ("plastic", "glossy"),
    ("conductor", "metal"),
    ("glass", "dielectric"),
    ("coat", "glossy"),
    ("silver", "Ag"),
    ("aluminium", "Al"),
    ("aluminum", "Al"),
    ("gold", "Au"),
    ("cobalt", "Co"),
    ("chrome", "Cr"),
    ("chromium", "Cr"),
    ("copper", "Cu"),
    ("iron", "Fe"),
    ("steel", "Fe"),
    ("nickel", "Ni"),
    ("palladium", "Pd"),
    ("platinum", "Pt"),
    ("titanium", "Ti"),
    ("vanadium", "V"),
    ("tungsten", "W"),
    ("cube", "box"),
    ("cuboid", "box"),
    ("ball", "sphere"),
    ("rectangle", "quad"),
    ("rect", "quad"),
    ("ground", "plane"),
    ("environment", "sky"),
    ("background", "sky"),
    ("envmap", "sky"),
    ("directional_light", "sun"),
    ("settings", "render"),
    ("translate", "position"),
    ("translation", "position"),
    ("location", "position"),
    ("origin", "position"),
    ("center", "position"),
    ("centre", "position"),
    ("at", "position"),
    ("from", "position"),
    ("eye", "position"),
    ("rotate", "rotation"),
    ("orientation", "rotation"),
    ("quaternion", "rotation"),
    ("target", "look_at"),
    ("lookat", "look_at"),
    ("to", "look_at"),
    ("fovy", "fov"),
    ("field_of_view", "fov"),
    ("yfov", "fov"),
    ("index_of_refraction", "ior"),
    ("eta", "ior"),
    ("r", "radius"),
    ("diameter", "radius"),
    ("extent", "size"),
    ("dimensions", "size"),
    ("path", "file"),
    ("filename", "file"),
    ("src", "file"),
    ("spp", "samples"),
    ("max_depth", "max_bounces"),
    ("depth", "max_bounces"),
    ("depth", "size"),
    ("bounces", "max_bounces"),
    ("width", "resolution"),
    ("width", "size"),
    ("height", "resolution"),
    ("height", "size"),
    ("length", "height"),
    ("length", "size"),
    ("image_size", "resolution"),
    ("size", "resolution"),
    ("tone_mapping", "tonemap"),
    ("tone_map", "tonemap"),
    ("frame_rate", "fps"),
    ("framerate", "fps"),
    ("pos", "position"),
    ("rot", "rotation"),
    ("n", "ior"),
    ("mat", "material"),
    ("shader", "material"),
    ("texture", "material"),
    ("major_radius", "radius"),
    ("minor_radius", "tube"),
    ("tube_radius", "tube"),
    ("metallic", "metalness"),
    ("alpha", "opacity"),
    ("transparency", "opacity"),
    ("bump", "normal"),
    ("normals", "normal"),
    ("brightness", "strength"),
    ("brightness", "radiance"),
    ("intensity", "radiance"),
    ("intensity", "power"),
    ("energy", "power"),
    ("watts", "power"),
    ("weight", "mass"),
    ("bounce", "restitution"),
    ("bounciness", "restitution"),
    ("elasticity", "restitution"),
    ("intensity", "strength"),
    ("focal_distance", "focus"),
    ("focus_distance", "focus"),
    ("lens_radius", "aperture"),
    ("hidden", "visible"),
    ("lerp", "mix"),
    ("fract", "mod"),
    ("len", "count"),
    ("magnitude", "length"),
    ("random", "rand"),
    ("perlin", "noise"),
    ("rgba", "srgb"),
    ("hsl", "hsv"),
    ("radians", "turn"),
    ("ease", "smooth"),
    ("kelvin", "K"),
    ("degrees", "deg"),
    ("degree", "deg"),
    ("radian", "rad"),
    ("meters", "m"),
    ("meter", "m"),
    ("metres", "m"),
    ("seconds", "s"),
    ("sec", "s"),
    ("frames", "f"),
];

/// Names of [`FOREIGN`] that mean another quantity or take another type there than here: a fix leaves the value to do.
const UNLIKE: &[&str] = &[
    "rotate",
    "rot",
    "orientation",
    "diameter",
    "hidden",
    "lens_radius",
    "width",
    "height",
    "depth",
    "length",
    "size",
    "texture",
    "shader",
    "transparency",
    "bump",
    "intensity",
    "brightness",
    "max_depth",
    "tint",
    "n",
];

/// Words that other programs have for values, and what to write here: pi and what is true, and the colours of the web.
const VALUES: &[(&str, &str)] = &[
    ("yes", "true"),
    ("on", "true"),
    ("True", "true"),
    ("TRUE", "true"),
    ("no", "false"),
    ("off", "false"),
    ("False", "false"),
    ("FALSE", "false"),
    ("red", "#ff0000"),
    ("green", "#008000"),
    ("lime", "#00ff00"),
    ("blue", "#0000ff"),
    ("white", "#ffffff"),
    ("black", "#000000"),
    ("gray", "#808080"),
    ("grey", "#808080"),
    ("silver", "#c0c0c0"),
    ("yellow", "#ffff00"),
    ("orange", "#ffa500"),
    ("cyan", "#00ffff"),
    ("magenta", "#ff00ff"),
    ("purple", "#800080"),
    ("pink", "#ffc0cb"),
    ("brown", "#a52a2a"),
    ("navy", "#000080"),
    ("teal", "#008080"),
];

/// What other programs have a word for that this one writes as a value of its own.
///
/// ```
/// use kinora_lang::suggest::value_for;
/// assert_eq!(value_for("yes"), Some("true"));
/// assert_eq!(value_for("Red"), Some("#ff0000"));
/// ```
pub fn value_for(word: &str) -> Option<&'static str> {
    let same = |(name, _): &&(&str, &str)| *name == word || name.eq_ignore_ascii_case(word);
    VALUES.iter().find(same).map(|(_, value)| *value)
}

/// What other programs have a kind of node for and this one has not, with what comes nearest.
const NEAREST: &[(&[&str], &str)] = &[
    (&["union", "merge", "blob"], "shapes may overlap as they are: put them into a `group`"),
    (
        &["difference", "intersection", "subtract", "csg", "clipped_by", "bounded_by"],
        "solids are not cut: make the shape in a modeller and read it as a `mesh`, or make it of parts",
    ),
    (
        &["fog", "media", "volume", "medium", "smoke", "atmosphere"],
        "there are no clouds and fogs: a `dielectric` with `attenuation_color` absorbs, and `sky { model: nishita }` \
            is the air",
    ),
    (
        &[
            "isosurface",
            "sor",
            "lathe",
            "prism",
            "superellipsoid",
            "sphere_sweep",
            "bicubic_patch",
            "poly",
            "quadric",
            "text",
            "sdf",
        ],
        "make it as a `mesh`, of a file or of `positions` and `indices` that are computed",
    ),
    (&["height_field", "heightfield", "terrain"], "compute the `positions` and `indices` of a `mesh` in a list"),
    (&["triangle", "polygon", "mesh2", "smooth_triangle"], "write `mesh { positions: [..], indices: [..] }`"),
    (&["object", "transform", "node", "shape"], "name the shape itself, such as `sphere`; several are a `group`"),
    (
        &["material", "bsdf", "texture", "pigment", "finish"],
        "name what it is made of: `diffuse`, `metal`, `dielectric`, `glossy`",
    ),
    (&["scene", "world", "global_settings"], "nodes stand at the top level of the file; settings are in `render { }`"),
];

/// What comes nearest to a kind of node of other programs that has no counterpart.
pub fn nearest_kind(name: &str) -> Option<&'static str> {
    NEAREST.iter().find(|(names, _)| names.contains(&name)).map(|(_, help)| *help)
}

/// The names most like `name`, best first, at most three: the same but for case, then with its words in another order,
/// then a few typing mistakes away, then what other programs call so. Never `name` itself.
///
/// ```
/// use kinora_lang::suggest::suggest;
/// assert_eq!(suggest("raduis", ["position", "radius"]), ["radius"]);
/// assert_eq!(suggest("translate", ["position", "radius"]), ["position"]);
/// ```
pub fn suggest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    if name.len() > 64 {
        return Vec::new();
    }
    let lower = name.to_lowercase();
    let (length, lower_length) = (name.chars().count(), lower.chars().count());
    let most = (length / 3).max(1);
    let words = sorted_words(&lower);
    let mut found: Vec<(usize, std::cmp::Reverse<usize>, &str)> = Vec::new();
    for known in known {
        if known == name || known.len() > 64 {
            continue;
        }
        let candidate = known.to_lowercase();
        // As many letters more or less are as many mistakes.
        let distance = match candidate.chars().count().abs_diff(lower_length) > most {
            true => usize::MAX,
            false => damerau_levenshtein(&lower, &candidate),
        };
        // A name of one or two letters is one letter away from every other: nothing can be guessed from that.
        let near = length > 2 && distance <= most && distance < known.chars().count();
        let rank = if candidate == lower {
            0
        } else if words.len() > 1 && sorted_words(&candidate) == words {
            1
        } else if near {
            distance
        } else if FOREIGN.contains(&(lower.as_str(), known)) {
            200
        } else {
            continue;
        };
        // Of two as near, the one that begins more alike.
        let alike = lower.chars().zip(candidate.chars()).take_while(|(a, b)| a == b).count();
        found.push((rank, std::cmp::Reverse(alike), known));
    }
    found.sort();
    found.dedup();
    found.truncate(3);
    found.into_iter().map(|(.., known)| known).collect()
}

/// How far a suggestion may be trusted: what other programs call so is only likely meant.
pub fn trust(name: &str, near: &str) -> Applicability {
    match FOREIGN.contains(&(name.to_lowercase().as_str(), near)) {
        true => Applicability::Maybe,
        false => Applicability::Safe,
    }
}

/// How far a suggestion may be trusted where a value follows: a name of other programs is as good as a misspelt one, if
/// it takes the same value.
pub fn trust_value(name: &str, near: &str) -> Applicability {
    let lower = name.to_lowercase();
    match FOREIGN.contains(&(lower.as_str(), near)) && UNLIKE.contains(&lower.as_str()) {
        true => Applicability::Maybe,
        false => Applicability::Safe,
    }
}

fn sorted_words(name: &str) -> Vec<&str> {
    let mut words: Vec<&str> = name.split('_').collect();
    words.sort_unstable();
    words
}

/// `a`, `a or b`, `a, b or c`, each in backquotes.
pub fn any_of<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    join(names, " or ")
}

/// `a`, `a and b`, `a, b and c`, each in backquotes.
pub fn all_of<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    join(names, " and ")
}

fn join<'a>(names: impl IntoIterator<Item = &'a str>, last: &str) -> String {
    let names: Vec<String> = names.into_iter().map(|name| format!("`{name}`")).collect();
    match names.split_last() {
        None => String::new(),
        Some((only, [])) => only.clone(),
        Some((end, rest)) => format!("{}{last}{end}", rest.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(name: &str, known: &[&str], expected: &[&str]) {
        assert_eq!(suggest(name, known.iter().copied()), expected, "{name}");
    }

    #[test]
    fn rules() {
        check("raduis", &["radius", "position"], &["radius"]);
        check("Radius", &["radius"], &["radius"]);
        check("radius", &["radius"], &[]);
        check("x_size", &["size", "size_x"], &["size_x", "size"]);
        check("albedo", &["color", "roughness"], &["color"]);
        check("fovy", &["fov", "focus"], &["fov"]);
        check("abcd", &["abce", "abcf", "abcg", "abch"], &["abce", "abcf", "abcg"]);
        check("zzzzzz", &["radius"], &[]);
        check("ab", &["xy", "AB"], &["AB"]);
        check("golld", &["gold", "bold"], &["gold"]);
        check("sinn", &["sign", "sin"], &["sin", "sign"]);
        check("", &["a"], &[]);
        check(&"x".repeat(100_000), &["x"], &[]);
    }
}
