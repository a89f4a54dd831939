//! `pack`: a [`World`] becomes the flat arrays that the kernel reads.
//!
//! Flat shapes become parallelograms and triangles in world space, spheres and all that curves stay exact, infinite planes stand beside the tree. All
//! placing is done in f64 and rounded once.

mod copies;
mod eye;
mod filter;
mod geometry;
mod lights;
mod materials;
mod opacity;
mod other;
mod sky;
mod spectra;
mod tapes;
mod textures;
mod tree;

use std::f64::consts::TAU;

use glam::{UVec4, Vec4};
use kinora_kernel::albedo;
use kinora_kernel::generated::{
    EMITTER_BEAM, EMITTER_GLOW, FEATURE_BEAM, FEATURE_BLADES, FEATURE_CUTOUT, FEATURE_DELTA, FEATURE_DISTANT,
    FEATURE_FISHEYE, FEATURE_GLOW, FEATURE_INSTANCE, FEATURE_LIGHT_TREE, FEATURE_MATERIAL, FEATURE_ORTHOGRAPHIC,
    FEATURE_OTHER, FEATURE_PANORAMA, FEATURE_SKY_MAP, LIGHT_POINT, LIGHT_SPOT, LIGHT_SUN, MATERIAL_EMITTER, NONE,
    OTHER_INSTANCE, PRIMITIVE_KIND, PRIMITIVE_OTHER, SAMPLER_RANDOM, SAMPLER_SOBOL, TABLE_ALBEDO,
};
use kinora_kernel::packed::TooDeep;
use kinora_kernel::query::build;
use kinora_kernel::{Packed, Params};
use kinora_scene::{Background, LightKind, Mis, Projection, Sampler, SkyLight, World};

use crate::motion::Moved;
use geometry::Geometry;
use materials::Materials;
use textures::Textures;

/// Why a world cannot be traced.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PackError {
    /// A shape lies so far away, or is so large, that single precision cannot hold it.
    Coordinates {
        /// Index into the scene's nodes.
        node: usize,
    },
    /// The camera lies so far away, or sees so much, that single precision cannot hold it.
    Camera,
    /// There are more primitives than the kernel can count.
    TooMany {
        /// How many there are.
        primitives: usize,
        /// How many there may be.
        limit: usize,
    },
    /// Materials are mixed of mixed ones, or coated, to too many levels.
    Materials {
        /// How many levels there may be.
        limit: usize,
    },
    /// Too many parts of one material shine.
    Emitters {
        /// How many there may be.
        limit: usize,
    },
    /// What cuts holes into one material is mixed of too many parts.
    CutOuts {
        /// How many there may be.
        limit: usize,
    },
    /// Textures are too many levels inside one another.
    Textures {
        /// How many levels there may be.
        limit: usize,
    },
    /// A texture is computed in too many steps.
    Tape {
        /// How many steps there may be.
        limit: usize,
    },
    /// Textures, and what meshes have for them, are too large to be counted.
    Texels {
        /// How large they are.
        bytes: u64,
        /// How large they may be.
        limit: u64,
    },
    /// Texels and tables of lights are more than the kernel can count.
    Words {
        /// How many words of 4 bytes they take.
        words: usize,
        /// How many there may be.
        limit: usize,
    },
    /// Copies of copies are more than can be traced.
    Copies {
        /// How many there may be.
        limit: usize,
    },
    /// The geometry lies so that its tree is too deep, for example many shapes in the same place.
    TooDeep {
        /// Levels of the tree.
        depth: u32,
    },
}

impl std::fmt::Display for PackError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            PackError::Coordinates { .. } => write!(f, "a shape lies outside of what single precision can hold"),
            PackError::Camera => write!(f, "the camera lies outside of what single precision can hold"),
            PackError::TooMany { primitives, limit } => {
                write!(f, "there are {primitives} triangles, the limit is {limit}")
            }
            PackError::Materials { limit } => {
                write!(f, "a material is mixed or coated to more than {limit} levels")
            }
            PackError::Emitters { limit } => {
                write!(f, "more than {limit} parts of a material shine, each in its own way")
            }
            PackError::CutOuts { limit } => {
                write!(f, "the opacity of a mixed material depends on more than {limit} values")
            }
            PackError::Textures { limit } => write!(f, "textures are more than {limit} levels inside one another"),
            PackError::Tape { limit } => write!(f, "a texture is computed in more than {limit} steps"),
            PackError::Texels { bytes, limit } => {
                write!(f, "the textures take {} MiB, the limit is {} MiB", bytes >> 20, limit >> 20)
            }
            PackError::Words { words, limit } => {
                write!(f, "pictures and lights take {} MiB, the limit is {} MiB", words >> 18, limit >> 18)
            }
            PackError::Copies { limit } => write!(f, "there are more than {limit} copies"),
            PackError::TooDeep { depth } => write!(f, "the tree over the shapes is {depth} levels deep"),
        }
    }
}

impl std::error::Error for PackError {}

/// Primitives of one picture: their indices must fit into the kernel's 30 bits, with room to spare.
const MAX_PRIMITIVES: usize = 1 << 28;

/// Words of texels and tables: their places must fit into the 30 bits that a tree of lights has for them.
const MAX_WORDS: usize = 1 << 29;

/// Makes the arrays of `world`.
///
/// # Errors
/// Geometry beyond the limits that [`PackError`] names.
pub fn pack(world: &World) -> Result<Packed, PackError> {
    pack_moving(world).map(|(packed, _)| packed)
}

/// As [`pack`], with where each shape goes until the next frame, if the world tells of it.
pub(crate) fn pack_moving(world: &World) -> Result<(Packed, Option<Vec<Moved>>), PackError> {
    let mut textures = Textures::default();
    let Materials { records, reads, shines } = materials::pack(&world.materials, &mut textures)?;
    let moved = world.next.as_ref().map(|_| Vec::new());
    let mut geometry = Geometry { materials: records, reads, shines, textures, moved, ..Geometry::default() };
    // Planes come first: the kernel tests the first `plane_count` shapes one by one.
    let again = copies::unfold(world, &geometry.shines)?;
    let (planes, others): (Vec<_>, Vec<_>) = world
        .instances
        .iter()
        .chain(&again.instances)
        .partition(|i| matches!(i.shape, kinora_scene::Shape::Plane { .. }));
    let plane_count = planes.len() as u32;
    for instance in planes.into_iter().chain(others) {
        geometry.add(instance, world)?;
    }
    let parts = copies::add(&mut geometry, world, again.copies)?;
    if geometry.primitives.len() > MAX_PRIMITIVES {
        return Err(PackError::TooMany { primitives: geometry.primitives.len(), limit: MAX_PRIMITIVES });
    }
    for lamp in world.lights.iter().chain(&again.lights) {
        match &lamp.light.kind {
            LightKind::Point { radius_m, .. } | LightKind::Spot { radius_m, .. } if *radius_m > 0.0 => {
                geometry.add_lamp(lamp)?;
            }
            kind => geometry.lights.extend(lights::point(lamp.light.color, kind)),
        }
    }
    let near_count = lights::choose_by_power(&mut geometry.lights);
    // What textures read stands first, since place 0 stands for nothing and their tables have fixed places.
    let texture_features = geometry.textures.features;
    let (counts, textures) =
        ((geometry.materials.len(), geometry.shapes.len()), std::mem::take(&mut geometry.textures));
    let (mut words, places) = textures.finish(counts.0, counts.1)?;
    let needed = words.len() + geometry.lights.len() * tree::PAIR;
    let many = geometry.lights.len() >= tree::TREE_FROM;
    if many && needed > MAX_WORDS {
        return Err(PackError::Words { words: needed, limit: MAX_WORDS });
    }
    let light_tree = match many {
        true => tree::build(&mut geometry.lights, &mut words),
        false => None,
    };
    let mut above = above(world, near_count, &mut words)?;
    // Lights without power stand before those from infinitely far away.
    let light_count = if above.lights.is_empty() { near_count } else { geometry.lights.len() as u32 };
    let primitive_count = geometry.primitives.len() as u32;
    geometry.pad_bounds();
    let mut tree = build(&mut geometry.primitives, &geometry.bounds, &geometry.shapes);
    for (part, mut primitives) in parts {
        let (first, count) = (geometry.primitives.len() as u32, primitives.len() as u32);
        tree.add_part(part, first, count);
        geometry.primitives.append(&mut primitives);
    }
    let mut params = Params { plane_count, primitive_count, light_count, ..params(world) };
    above.write(&mut params);
    params.light_tree = light_tree.unwrap_or(0);
    if light_tree.is_some() {
        params.features |= FEATURE_LIGHT_TREE;
    }
    let all_lights: Vec<_> = geometry
        .lights
        .into_iter()
        .map(|light| light.packed)
        .chain(above.lights.into_iter().map(|light| light.packed))
        .collect();
    let delta = |light: &kinora_kernel::Light| match light.kind.x {
        LIGHT_SUN => light.edge_v.x <= 0.0,
        kind => kind == LIGHT_POINT || kind == LIGHT_SPOT,
    };
    if all_lights.iter().any(delta) {
        params.features |= FEATURE_DELTA;
    }
    let cut_out = |material: usize| geometry.materials.get(material).is_some_and(|m| m.more.w < 1.0);
    let mut shapes = world.instances.iter().chain(world.parts.iter().flat_map(|part| &part.instances));
    let mut copies = world.copies.iter().chain(world.parts.iter().flat_map(|part| &part.copies));
    if shapes.any(|instance| cut_out(instance.material)) || copies.any(|copied| copied.material.is_some_and(cut_out)) {
        params.features |= FEATURE_CUTOUT;
    }
    for primitive in geometry.primitives.iter().filter(|p| p.shade.w & PRIMITIVE_KIND == PRIMITIVE_OTHER) {
        let instance = primitive.index.z == OTHER_INSTANCE;
        params.features |= if instance { FEATURE_INSTANCE } else { FEATURE_OTHER };
    }
    for material in &geometry.materials {
        params.features |= FEATURE_MATERIAL << material.kind.x;
        if material.kind.x == MATERIAL_EMITTER && material.kind.y & EMITTER_BEAM != 0 {
            params.features |= FEATURE_BEAM;
        }
        if material.kind.x == MATERIAL_EMITTER && material.kind.y & EMITTER_GLOW != 0 {
            params.features |= FEATURE_GLOW;
        }
    }
    params.features |= texture_features;
    [params.textures.x, params.textures.y] = places;
    let mut tables = filter::inverse_distribution(world.render.filter, world.render.filter_width);
    tables.resize(TABLE_ALBEDO as usize, 0.0);
    tables.extend_from_slice(albedo::tables());
    let mut packed = Packed {
        params,
        tree,
        primitives: not_empty(geometry.primitives),
        shapes: not_empty(geometry.shapes),
        materials: not_empty(geometry.materials),
        lights: not_empty(all_lights),
        tables,
        words,
    };
    packed.check_depth().map_err(|TooDeep { depth }| PackError::TooDeep { depth })?;
    place_eye(&mut packed)?;
    Ok((packed, geometry.moved))
}

// The last step of all: a look at what is around the eye.
fn place_eye(packed: &mut Packed) -> Result<(), PackError> {
    let camera = [packed.params.camera_eye, packed.params.camera_film];
    if camera.iter().any(|v| !v.is_finite()) {
        return Err(PackError::Camera);
    }
    packed.params.media = eye::media_around(packed, packed.params.camera_eye.truncate());
    Ok(())
}

/// Makes the arrays of another world those of `world`, from which nothing but the view differs.
///
/// # Errors
/// [`PackError::Camera`].
pub(crate) fn aim(packed: &mut Packed, world: &World) -> Result<(), PackError> {
    const CAMERA: u32 = FEATURE_ORTHOGRAPHIC | FEATURE_PANORAMA | FEATURE_FISHEYE | FEATURE_BLADES;
    let seen = params(world);
    let params = &mut packed.params;
    params.camera_x = seen.camera_x;
    params.camera_y = seen.camera_y;
    params.camera_z = seen.camera_z;
    params.camera_eye = seen.camera_eye;
    params.camera_film = seen.camera_film;
    params.features = params.features & !CAMERA | seen.features & CAMERA;
    place_eye(packed)
}

/// What comes from infinitely far away.
#[derive(Default)]
struct Above {
    lights: Vec<lights::Distant>,
    map: Option<sky::Placed>,
    turn: f32,
    /// Index of the map's light among `lights`.
    map_light: Option<u32>,
    near_count: u32,
}

/// Chance that a light from infinitely far away is sampled where there are others too.
const DISTANT_CHANCE: f32 = 0.5;

fn above(world: &World, near_count: u32, words: &mut Vec<u32>) -> Result<Above, PackError> {
    let mut above = Above { near_count, ..Above::default() };
    for lamp in &world.lights {
        if let LightKind::Sun { direction, angle, irradiance } = lamp.light.kind {
            above.lights.push(lights::sun(direction, 0.5 * angle, lamp.light.color * irradiance as f32));
        }
    }
    let Some(sky) = &world.sky else { return Ok(above) };
    if let SkyLight::Map { rotation, .. } = sky.light {
        above.turn = (rotation / TAU).rem_euclid(1.0) as f32;
    }
    let Some(laid) = sky::lay(&sky.light) else { return Ok(above) };
    if let Some((to_sun, half_angle, sun)) = laid.sun
        && sun.max_element() > 0.0
        && sky.strength > 0.0
    {
        above.lights.push(lights::sun(-to_sun, half_angle, sun * sky.strength as f32));
    }
    let needed = laid.len() + words.len();
    if needed > MAX_WORDS {
        return Err(PackError::Words { words: needed, limit: MAX_WORDS });
    }
    let placed = laid.append(words);
    let irradiance = placed.irradiance * sky.strength;
    if irradiance > 0.0 {
        above.map_light = Some(above.lights.len() as u32);
        above.lights.push(lights::sky(irradiance));
    }
    above.map = Some(placed);
    Ok(above)
}

impl Above {
    fn write(&mut self, params: &mut Params) {
        params.distant_count = lights::choose_distant(&mut self.lights);
        if params.distant_count == 0 {
            self.lights.clear();
            self.map_light = None;
        } else {
            params.features |= FEATURE_DISTANT;
            params.distant_chance = if self.near_count == 0 { 1.0 } else { DISTANT_CHANCE };
        }
        if let Some(map) = &self.map {
            params.features |= FEATURE_SKY_MAP;
            params.sky_map = map.map;
            params.sky_map.w = self.map_light.map_or(NONE, |light| light + params.light_count);
            params.sky_cells = map.cells;
            params.sky_turn = self.turn;
        }
    }
}

fn not_empty<T: Default>(mut items: Vec<T>) -> Vec<T> {
    if items.is_empty() {
        items.push(T::default());
    }
    items
}

fn params(world: &World) -> Params {
    let view = &world.view;
    let axes = view.world_from_camera.matrix3;
    let [width, height] = world.render.resolution;
    let aspect = f64::from(width) / f64::from(height);
    let mut features = 0;
    let mut edge = 0.0;
    let [half_width, half_height] = match view.projection {
        Projection::Perspective { fov } => {
            let half_height = (fov * 0.5).tan();
            [half_height * aspect, half_height]
        }
        Projection::Orthographic { height_m } => {
            features = FEATURE_ORTHOGRAPHIC;
            [0.5 * height_m * aspect, 0.5 * height_m]
        }
        Projection::Panorama => {
            features = FEATURE_PANORAMA;
            [1.0, 1.0]
        }
        Projection::Fisheye { fov } => {
            features = FEATURE_FISHEYE;
            edge = (fov * 0.5 / TAU) as f32;
            [aspect, 1.0]
        }
    };
    // Only a perspective has a lens.
    let aperture_m = if features == 0 { view.aperture_m } else { 0.0 };
    let corners = if aperture_m > 0.0 { view.blades.count } else { 0 };
    if corners > 0 {
        features |= FEATURE_BLADES;
    }
    let first_corner = (view.blades.rotation / TAU).rem_euclid(1.0) as f32;
    let sky_seen = world.sky.as_ref().is_none_or(|sky| sky.visible) && world.render.background == Background::Sky;
    Params {
        camera_x: axes.x_axis.as_vec3().extend(corners as f32),
        camera_y: axes.y_axis.as_vec3().extend(if corners > 0 { first_corner } else { 0.0 }),
        camera_z: axes.z_axis.as_vec3().extend(edge),
        camera_eye: view.world_from_camera.translation.as_vec3().extend((aperture_m * 0.5) as f32),
        camera_film: Vec4::new(half_width as f32, half_height as f32, view.focus_m as f32, 0.0),
        sky: world.sky_radiance().extend(if sky_seen { 1.0 } else { 0.0 }),
        window: glam::UVec4::new(0, 0, width, height),
        resolution: glam::UVec2::new(width, height),
        seed: world.render.seed,
        sampler: match world.render.sampler {
            Sampler::Sobol => SAMPLER_SOBOL,
            Sampler::Random => SAMPLER_RANDOM,
        },
        max_bounces: world.render.max_bounces,
        roulette_from: world.render.roulette_from,
        features,
        light_chance: match world.render.mis {
            Mis::Nee => -1.0,
            Mis::OneSample(chance) => chance as f32,
        },
        clamp: world.render.clamp.map_or(f32::MAX, |most| most as f32),
        media: UVec4::splat(NONE),
        ..Params::default()
    }
}

/// The first light of a shape that has none.
const NO_LIGHT: u32 = NONE;

/// A full turn, for integrals over the sphere.
const TURN: f64 = TAU;
