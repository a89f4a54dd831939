// The scene as both backends read it: layouts, and the only bindings outside entry/. The Rust twins of these structures
// are generated from here, so a layout is written once.

/// What a primitive of the BVH is: the high bits of `Primitive::shade.w`, whose other bits are its shape.
const PRIMITIVE_TRIANGLE: u32 = 0x00000000u;
const PRIMITIVE_PARALLELOGRAM: u32 = 0x40000000u;
const PRIMITIVE_SPHERE: u32 = 0x80000000u;
/// One of OTHER_…: see shapes.wgsl.
const PRIMITIVE_OTHER: u32 = 0xc0000000u;
const PRIMITIVE_KIND: u32 = 0xc0000000u;

/// `Material::kind.x`.
const MATERIAL_DIFFUSE: u32 = 0u;
const MATERIAL_METAL: u32 = 1u;
const MATERIAL_DIELECTRIC: u32 = 2u;
const MATERIAL_EMITTER: u32 = 3u;
const MATERIAL_GLOSSY: u32 = 4u;
const MATERIAL_MIX: u32 = 5u;
const MATERIAL_SHEEN: u32 = 6u;

/// Flags of `Material::kind.y`; the low bits of a diffuse one are its model.
const DIFFUSE_EON: u32 = 0u;
const DIFFUSE_FON: u32 = 1u;
const DIFFUSE_QON: u32 = 2u;
const DIFFUSE_MODEL: u32 = 3u;
/// Reflectance by refractive index and extinction instead of F82-tint.
const METAL_SPECTRUM: u32 = 1u;
/// Light scattered more than once between microfacets is added.
const COMPENSATE: u32 = 2u;
/// Stretched as a texture says: see SLOT_STRETCH.
const METAL_STRETCHED: u32 = 4u;
/// A sheet without thickness.
const DIELECTRIC_THIN: u32 = 4u;
/// What passes has a colour from a texture.
const DIELECTRIC_TINTED: u32 = 16u;

/// Both sides shine.
const EMITTER_TWO_SIDED: u32 = 16u;
/// Shines in a cone.
const EMITTER_BEAM: u32 = 32u;
/// Varies over the surface: see `glow_eval`.
const EMITTER_GLOW: u32 = 64u;
/// A random number decides between its parts.
const CHOICE: u32 = 8u;

/// `Params::features`: what occurs in the scene.
const FEATURE_CUTOUT: u32 = 1u;
const FEATURE_TEXTURE: u32 = 4u;
const FEATURE_NORMAL_MAP: u32 = 8u;
/// Textures that are computed: see `tape_value`.
const FEATURE_TAPE: u32 = 32u;
/// A sky that is not the same everywhere.
const FEATURE_SKY_MAP: u32 = 0x00100000u;
/// Lights from infinitely far away that are sampled: that sky, and suns.
const FEATURE_DISTANT: u32 = 0x00200000u;
/// Lights that only light samples can find: points, spots, and suns without a disc.
const FEATURE_DELTA: u32 = 0x00400000u;
/// The lights are chosen by a tree.
const FEATURE_LIGHT_TREE: u32 = 0x00800000u;
/// Emitters that shine in a cone.
const FEATURE_BEAM: u32 = 0x01000000u;
/// Emitters whose light varies over their surface.
const FEATURE_GLOW: u32 = 0x08000000u;
/// The camera is no perspective but this; at most one of them.
const FEATURE_ORTHOGRAPHIC: u32 = 0x20000000u;
const FEATURE_PANORAMA: u32 = 0x40000000u;
const FEATURE_FISHEYE: u32 = 0x80000000u;
/// Its lens has corners.
const FEATURE_BLADES: u32 = 0x10000000u;
/// A shape of shapes.wgsl.
const FEATURE_OTHER: u32 = 2u;
/// Copies of parts: OTHER_INSTANCE.
const FEATURE_INSTANCE: u32 = 16u;
/// Shifted by a MATERIAL_…: that kind. A GPU compiles the shaders anew for each set of features, and leaves out the rest.
const FEATURE_MATERIAL: u32 = 256u;

/// `Light::kind.x`.
const LIGHT_TRIANGLE: u32 = 0u;
const LIGHT_PARALLELOGRAM: u32 = 1u;
const LIGHT_SPHERE: u32 = 2u;
const LIGHT_ELLIPSOID: u32 = 3u;
const LIGHT_RECTANGLE: u32 = 4u;
/// A shape of shapes.wgsl.
const LIGHT_OTHER: u32 = 5u;
const LIGHT_POINT: u32 = 6u;
const LIGHT_SPOT: u32 = 7u;
/// From here on they are infinitely far away.
const LIGHT_SUN: u32 = 8u;
const LIGHT_SKY: u32 = 9u;

/// No hit, no light.
const NONE: u32 = 0xffffffffu;
/// Set in `Hit::id` where an infinite plane was hit; the rest is the shape's index.
const PLANE_BIT: u32 = 0x80000000u;

/// Intervals of the filter's inverse distribution function in `tables`, which has one entry more.
const FILTER_CELLS: u32 = 256u;
/// Where the tables of albedos begin in `tables`, after the filter.
const TABLE_ALBEDO: u32 = 260u;

/// What holds for the whole picture.
struct Params {
    /// Columns of the camera's rotation. In their w: how many corners the lens has, the angle of the first, and a fisheye's
    /// angle from the axis to its edge, both angles in turns.
    camera_x: vec4<f32>,
    camera_y: vec4<f32>,
    camera_z: vec4<f32>,
    /// The eye in the world; w: lens radius in metres.
    camera_eye: vec4<f32>,
    /// Half extents of the image, then the distance to the plane in focus. Perspective: at distance 1; orthographic:
    /// metres; fisheye: radii of its circle; panorama: 1.
    camera_film: vec4<f32>,
    /// Radiance, or the factor of the sky's map; w: 1 if the camera sees the sky and suns, else 0.
    sky: vec4<f32>,
    /// The sky's map: first word of its texels, width, height, and the index of its light.
    sky_map: vec4<u32>,
    /// The cells by which it is sampled: first word of their sums, columns and rows (both powers of 2); w unused.
    sky_cells: vec4<u32>,
    /// The part of the picture that is wanted: left, top, width and height in pixels.
    window: vec4<u32>,
    /// Width and height of the whole picture in pixels.
    resolution: vec2<u32>,
    seed: u32,
    sampler: u32,
    max_bounces: u32,
    roulette_from: u32,
    light_count: u32,
    /// Planes are the first so many of `shapes`.
    plane_count: u32,
    primitive_count: u32,
    features: u32,
    /// Chance of a light sample where only one of two techniques is tried; below 0 both are, always.
    light_chance: f32,
    /// The most that throughput · MIS weight may be where light is added.
    clamp: f32,
    /// Lights from infinitely far away: those that follow the first `light_count`.
    distant_count: u32,
    /// Chance that one of them is sampled instead of the others.
    distant_chance: f32,
    /// How far the sky's map is turned about +y, in turns.
    sky_turn: f32,
    /// First word of the tree of lights.
    light_tree: u32,
    /// The media around the eye, as `Path::media`.
    media: vec4<u32>,
    /// Where the maps of materials begin among `words`, and the places of rows that lead from the world, or a part, to each
    /// shape's own space (0: nobody reads them); z is unused, and w is 0, always: see `rounded`.
    textures: vec4<u32>,
}

/// A primitive of the BVH, in its leaf order: the coordinates of its corners, a lane each, so that all edges are tested
/// at once. A triangle's fourth corner is its first. A sphere is its shape's unit sphere and has no corners; of another
/// shape, x.x is its size.
struct Primitive {
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
    /// Octahedral normals of a triangle's corners, or 0s where it is flat; w: kind and shape.
    shade: vec4<u32>,
    /// Index in its shape; of a rectangle, 1 if u grows along the last edge instead of the first; of a triangle, where
    /// what its mesh's vertices have is among `words`, or 0; OTHER_…; the rest is unused. Of an instance: its part, and the
    /// part's first node.
    index: vec4<u32>,
}

/// One instance of a shape.
struct Shape {
    /// Rows of the affine map from the world, or from the part that it belongs to, to the shape's unit sphere or plane
    /// z = 0; of an instance, to its part; unused by meshes.
    object_from_world_x: vec4<f32>,
    object_from_world_y: vec4<f32>,
    object_from_world_z: vec4<f32>,
    /// Rows of the inverse.
    world_from_object_x: vec4<f32>,
    world_from_object_y: vec4<f32>,
    world_from_object_z: vec4<f32>,
    /// Material, first light or NONE, first of the emitters among `materials` or NONE, node.
    index: vec4<u32>,
}

/// A node of a material's tree. What is stated for some kinds is unused by the others.
struct Material {
    /// diffuse: reflectance, then roughness; sheen: the fibres' colour; metal: reflectance at normal incidence or refractive index, then the
    /// cosine of the tangent's turn; emitter: radiance.
    color: vec4<f32>,
    /// metal: the Lazányi term a of F82-tint or extinction, then the sine of the tangent's turn; dielectric: absorption
    /// a metre, then ior.
    extra: vec4<f32>,
    /// metal: tint of light scattered more than once; all: opacity; emitter in a cone: see `beam_share`.
    more: vec4<f32>,
    /// GGX: α along the tangent, α across it, roughness, anisotropy; glossy: α, ior, roughness, metalness; mix: the
    /// share of the second; sheen: roughness in z.
    lobe: vec4<f32>,
    /// MATERIAL_…, flags, then: dielectric: priority (a signed number); sheen: the material beneath; glossy: it too, the metal mixed
    /// in (of one that is an emitter's: the next coat over it) or NONE; mix: the two; emitter: the nearest coat over it or NONE, the shape's next emitter or NONE.
    kind: vec4<u32>,
}

struct Light {
    /// A corner, the centre, or the unit vector to a sun; w: sum of the chances of all lights before it that it is chosen
    /// among (2 for those after the last with any).
    origin: vec4<f32>,
    /// An edge; sphere: radius in x; ellipsoid and other: the determinant of its transform in x; other: its size in y;
    /// point, spot: W/sr; sun: radiance, or irradiance of one without a disc; w: chance to be chosen.
    edge_u: vec4<f32>,
    /// The other edge; other: the chances of its parts; of all that have a shape: its first emitter in w, a whole number; spot: the unit vector in which it shines, then 1 - cos of the cone's
    /// half angle; sun: the same of its disc in x, 0 without one.
    edge_v: vec4<f32>,
    /// Of a flat light: its outward unit normal; w: 1 / area in m²; spot: x: 1 - cos of the half angle within which it is
    /// brightest.
    normal: vec4<f32>,
    /// LIGHT_…, shape, OTHER_… (of a triangle: where what its mesh's vertices have is among `words`, or 0; of another flat
    /// light, 1 if u grows along the last edge instead of the first), way down the tree of lights (from the lowest bit, 1 for the second child).
    kind: vec4<u32>,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> nodes: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> primitives: array<Primitive>;
@group(0) @binding(3) var<storage, read> shapes: array<Shape>;
@group(0) @binding(4) var<storage, read> materials: array<Material>;
@group(0) @binding(5) var<storage, read> lights: array<Light>;
@group(0) @binding(6) var<storage, read> tables: array<f32>;
/// Everything whose length depends on the scene and that is no array of its own: texels, and tables of the lights. What
/// needs it keeps the place of its first word.
@group(0) @binding(7) var<storage, read> words: array<u32>;

/// Four words that lie side by side, read at once.
fn words_from(i: u32) -> vec4<u32> {
    return vec4<u32>(words[i], words[i + 1u], words[i + 2u], words[i + 3u]);
}

/// A number among `words`.
fn word_float(i: u32) -> f32 {
    return bitcast<f32>(words[i]);
}

fn has_material(kind: u32) -> bool {
    return (params.features & (FEATURE_MATERIAL << kind)) != 0u;
}

fn object_point(shape: u32, p: vec3<f32>) -> vec3<f32> {
    let q = vec4<f32>(p, 1.0);
    return vec3<f32>(
        dot(shapes[shape].object_from_world_x, q),
        dot(shapes[shape].object_from_world_y, q),
        dot(shapes[shape].object_from_world_z, q),
    );
}

fn object_vector(shape: u32, v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(
        dot(shapes[shape].object_from_world_x.xyz, v),
        dot(shapes[shape].object_from_world_y.xyz, v),
        dot(shapes[shape].object_from_world_z.xyz, v),
    );
}

fn world_point(shape: u32, p: vec3<f32>) -> vec3<f32> {
    let q = vec4<f32>(p, 1.0);
    return vec3<f32>(
        dot(shapes[shape].world_from_object_x, q),
        dot(shapes[shape].world_from_object_y, q),
        dot(shapes[shape].world_from_object_z, q),
    );
}

fn world_vector(shape: u32, v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(
        dot(shapes[shape].world_from_object_x.xyz, v),
        dot(shapes[shape].world_from_object_y.xyz, v),
        dot(shapes[shape].world_from_object_z.xyz, v),
    );
}

/// A normal of the object in the world: by the inverse transposed. Not normalised.
fn world_normal(shape: u32, n: vec3<f32>) -> vec3<f32> {
    return n.x * shapes[shape].object_from_world_x.xyz
        + n.y * shapes[shape].object_from_world_y.xyz
        + n.z * shapes[shape].object_from_world_z.xyz;
}
