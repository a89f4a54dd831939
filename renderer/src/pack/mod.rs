//! `pack`: a [`World`] becomes the flat arrays that the kernel reads.
//!
//! Flat shapes become parallelograms and triangles in world space, spheres and all that curves stay exact, infinite planes stand beside the tree. All
//! placing is done in f64 and rounded once.

mod copies;
mod eye;
mod filter;
mod geometry;
mod grow;
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
use kinora_kernel::packed::{Shared, TooDeep};
use kinora_kernel::{Packed, Params};
use kinora_scene::{Background, Copied, Instance, LightKind, Mis, Projection, Sampler, Shape, SkyLight, World};

use crate::motion::Moved;
use geometry::Geometry;
use grow::{Digest, Grown, Plans, Stand};
use materials::Materials;
use textures::Means;

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
    /// There are more materials than the kernel can count.
    Records {
        /// How many there may be.
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
            PackError::Records { limit } => write!(f, "there are more than {limit} materials"),
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

/// Records of materials: lights have the index of one as a number in single precision.
const MAX_RECORDS: usize = 1 << 24;

/// Primitives of one picture: their indices must fit into the kernel's 30 bits, with room to spare.
const MAX_PRIMITIVES: usize = 1 << 28;

/// Words of texels and tables: their places must fit into the 30 bits that a tree of lights has for them.
const MAX_WORDS: usize = 1 << 29;

/// Makes the arrays of `world`.
///
/// # Errors
/// Geometry beyond the limits that [`PackError`] names.
pub fn pack(world: &World) -> Result<Packed, PackError> {
    Packer::default().prepare(world)?.finish(None).map(|(packed, _)| packed)
}

/// Packs one world after the other.
#[derive(Default)]
pub(crate) struct Packer {
    plans: Plans,
    means: Means,
    grown: Grown,
    /// Where everything is.
    places: Digest,
}

/// A world all but packed: what is left may take what the one before has.
pub(crate) struct Prepared<'a> {
    packer: &'a mut Packer,
    /// Without the trees.
    pub packed: Packed,
    main: Stand,
    parts: Vec<Stand>,
    places: Digest,
    /// Where each shape goes until the next frame, if the world tells of it.
    pub moved: Option<Vec<Moved>>,
}

/// What of a world is not as in the one before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(missing_docs)]
pub struct Changes {
    /// Meshes whose triangles were sorted.
    pub meshes: bool,
    /// The tree over all shapes, or only a branch of it.
    pub tree: bool,
    /// Where shapes are.
    pub transforms: bool,
    /// What else shapes have: their materials and lights.
    pub shapes: bool,
    pub materials: bool,
    /// Also how bright the sky is.
    pub lights: bool,
    /// Texels, what vertices have, and the sky's map.
    pub textures: bool,
    /// The filter.
    pub tables: bool,
    pub camera: bool,
    /// What else holds for the whole picture, such as the depth of paths; its size is free.
    pub settings: bool,
}

impl Changes {
    /// Everything.
    pub const ALL: Changes = Changes {
        meshes: true,
        tree: true,
        transforms: true,
        shapes: true,
        materials: true,
        lights: true,
        textures: true,
        tables: true,
        camera: true,
        settings: true,
    };

    /// What changed, in words.
    pub fn names(&self) -> Vec<&'static str> {
        let Changes { meshes, tree, transforms, shapes, materials, lights, textures, tables, camera, settings } = *self;
        let all = [
            (meshes, "meshes"),
            (tree, "tree"),
            (transforms, "transforms"),
            (shapes && !transforms, "shapes"),
            (materials, "materials"),
            (lights, "lights"),
            (textures, "textures"),
            (tables, "filter"),
            (camera, "camera"),
            (settings, "settings"),
        ];
        all.into_iter().filter(|(changed, _)| *changed).map(|(_, name)| name).collect()
    }

    /// Both.
    #[must_use]
    pub fn and(self, other: Changes) -> Changes {
        Changes {
            meshes: self.meshes | other.meshes,
            tree: self.tree | other.tree,
            transforms: self.transforms | other.transforms,
            shapes: self.shapes | other.shapes,
            materials: self.materials | other.materials,
            lights: self.lights | other.lights,
            textures: self.textures | other.textures,
            tables: self.tables | other.tables,
            camera: self.camera | other.camera,
            settings: self.settings | other.settings,
        }
    }
}

impl Packer {
    /// Does all that may fail.
    ///
    /// # Errors
    /// As [`pack`].
    pub fn prepare(&mut self, world: &World) -> Result<Prepared<'_>, PackError> {
        self.plans.begin();
        let mut geometry = Geometry { plans: std::mem::take(&mut self.plans), ..Geometry::default() };
        self.means.begin();
        geometry.textures.means = std::mem::take(&mut self.means);
        let laid = lay(&mut geometry, world, &mut self.means);
        self.plans = std::mem::take(&mut geometry.plans);
        let (packed, main, parts) = laid?;
        Ok(Prepared { packer: self, packed, main, parts, places: places_of(world), moved: geometry.moved })
    }
}

impl Prepared<'_> {
    /// The arrays, and what of them is not as in `before`, which must be what was packed last.
    ///
    /// # Errors
    /// The tree is too deep; then nothing is left of `before`.
    pub fn finish(self, before: Option<Packed>) -> Result<(Packed, Changes), PackError> {
        let Prepared { packer, mut packed, main, parts, places, .. } = self;
        let mut changes = Changes { meshes: packer.plans.made > 0, ..Changes::ALL };
        let trees = before.map(|before| {
            let Packed { params, tree, primitives, shapes, materials, lights, tables, words } = before;
            changes = Changes { meshes: changes.meshes, ..of_params(&params, &packed.params) };
            changes.transforms = packer.places != places;
            changes.shapes = !same_bits(&shapes, &packed.shapes);
            changes.materials = !same_bits(&materials, &packed.materials);
            let same_lights = same_bits(&lights, &packed.lights);
            changes.lights |= !same_lights;
            changes.textures = *words != *packed.words;
            changes.tables = *tables != *packed.tables;
            if !changes.shapes {
                packed.shapes = shapes;
            }
            if !changes.materials {
                packed.materials = materials;
            }
            if same_lights {
                packed.lights = lights;
            }
            if !changes.textures {
                packed.words = words;
            }
            if !changes.tables {
                packed.tables = tables;
            }
            (tree, primitives)
        });
        let grown;
        ((packed.tree, packed.primitives), grown) = packer.grown.grow(main, parts, trees, &packed.shapes);
        changes.tree = grown;
        packer.places = places;
        packed.check_depth().map_err(|TooDeep { depth }| PackError::TooDeep { depth })?;
        place_eye(&mut packed);
        Ok((packed, changes))
    }
}

// By their bits, since what is no number is not even itself.
fn same_bits<T: bytemuck::NoUninit>(a: &[T], b: &[T]) -> bool {
    bytemuck::cast_slice::<T, u8>(a) == bytemuck::cast_slice::<T, u8>(b)
}

// Where all shapes and copies are.
fn places_of(world: &World) -> Digest {
    let mut digest = Digest::default();
    let add = |digest: &mut Digest, instances: &[Instance], copies: &[Copied]| {
        let of_copies = copies.iter().flat_map(|copied| &copied.places);
        for place in instances.iter().map(|instance| &instance.world_from_object).chain(of_copies) {
            digest.add(bytemuck::bytes_of(&place.to_cols_array()));
        }
    };
    add(&mut digest, &world.instances, &world.copies);
    for part in &world.parts {
        add(&mut digest, &part.instances, &part.copies);
    }
    digest
}

// All arrays but the trees, and what those are over.
fn lay(geometry: &mut Geometry, world: &World, means: &mut Means) -> Result<(Packed, Stand, Vec<Stand>), PackError> {
    let Materials { records, reads, shines } = materials::pack(&world.materials, &mut geometry.textures)?;
    (geometry.materials, geometry.reads, geometry.shines) = (records, reads, shines);
    geometry.moved = world.next.as_ref().map(|_| Vec::new());
    // Planes come first: the kernel tests the first `plane_count` shapes one by one. What is large follows, so that its
    // shapes keep their numbers while small ones come and go.
    let again = copies::unfold(world, &geometry.shines)?;
    let order = |instance: &&Instance| match &instance.shape {
        Shape::Plane { .. } => 0,
        Shape::Mesh(mesh) if grow::is_large(mesh) => 1,
        _ => 2,
    };
    let mut instances: Vec<&Instance> = world.instances.iter().chain(&again.instances).collect();
    instances.sort_by_key(order);
    let plane_count = instances.iter().filter(|instance| order(instance) == 0).count() as u32;
    for instance in instances {
        geometry.add(instance, world)?;
    }
    let parts = copies::add(geometry, world, again.copies)?;
    for lamp in world.lights.iter().chain(&again.lights) {
        match &lamp.light.kind {
            LightKind::Point { radius_m, .. } | LightKind::Spot { radius_m, .. } if *radius_m > 0.0 => {
                geometry.add_lamp(lamp)?;
            }
            kind => geometry.lights.extend(lights::point(lamp.light.color, kind)),
        }
    }
    let near_count = lights::choose_by_power(&mut geometry.lights);
    if geometry.materials.len() > MAX_RECORDS {
        return Err(PackError::Records { limit: MAX_RECORDS });
    }
    for light in &mut geometry.lights {
        lights::name_emitter(&mut light.packed, &geometry.shapes);
    }
    // What textures read stands first, since place 0 stands for nothing and their tables have fixed places.
    let texture_features = geometry.textures.features;
    let counts = (geometry.materials.len(), geometry.shapes.len());
    let mut textures = std::mem::take(&mut geometry.textures);
    *means = std::mem::take(&mut textures.means);
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
    let (own, bounds) = (std::mem::take(&mut geometry.primitives), std::mem::take(&mut geometry.bounds));
    let main = Stand::new(std::mem::take(&mut geometry.branches), own, bounds, &geometry.shapes);
    let primitives = main.len() + parts.iter().map(Stand::len).sum::<usize>();
    if primitives > MAX_PRIMITIVES {
        return Err(PackError::TooMany { primitives, limit: MAX_PRIMITIVES });
    }
    let mut params = Params { plane_count, primitive_count: main.len() as u32, light_count, ..params(world) };
    above.write(&mut params);
    params.light_tree = light_tree.unwrap_or(0);
    if light_tree.is_some() {
        params.features |= FEATURE_LIGHT_TREE;
    }
    let all_lights: Vec<_> = std::mem::take(&mut geometry.lights)
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
    let small = [&main].into_iter().chain(&parts).flat_map(Stand::primitives);
    for primitive in small.filter(|p| p.shade.w & PRIMITIVE_KIND == PRIMITIVE_OTHER) {
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
    let packed = Packed {
        params,
        shapes: not_empty(std::mem::take(&mut geometry.shapes)).into(),
        materials: not_empty(std::mem::take(&mut geometry.materials)).into(),
        lights: not_empty(all_lights).into(),
        tables: tables(world).into(),
        words: words.into(),
        ..Packed::empty()
    };
    check_camera(&packed.params)?;
    Ok((packed, main, parts))
}

fn tables(world: &World) -> Vec<f32> {
    let mut tables = filter::inverse_distribution(world.render.filter, world.render.filter_width);
    tables.resize(TABLE_ALBEDO as usize, 0.0);
    tables.extend_from_slice(albedo::tables());
    tables
}

fn check_camera(params: &Params) -> Result<(), PackError> {
    let camera = [params.camera_eye, params.camera_film];
    if camera.iter().any(|v| !v.is_finite()) {
        return Err(PackError::Camera);
    }
    Ok(())
}

// The last step of all: a look at what is around the eye.
fn place_eye(packed: &mut Packed) {
    packed.params.media = eye::media_around(packed, packed.params.camera_eye.truncate());
}

/// Makes the arrays of another world those of `world`, from which nothing but the view and the settings of the picture
/// differ. Gives what changed.
///
/// # Errors
/// [`PackError::Camera`]; then nothing is changed.
pub(crate) fn aim(packed: &mut Packed, world: &World) -> Result<Changes, PackError> {
    const CAMERA: u32 = FEATURE_ORTHOGRAPHIC | FEATURE_PANORAMA | FEATURE_FISHEYE | FEATURE_BLADES;
    let before = packed.params;
    let seen = params(world);
    check_camera(&seen)?;
    packed.params = Params {
        camera_x: seen.camera_x,
        camera_y: seen.camera_y,
        camera_z: seen.camera_z,
        camera_eye: seen.camera_eye,
        camera_film: seen.camera_film,
        features: before.features & !CAMERA | seen.features & CAMERA,
        sky: seen.sky,
        window: seen.window,
        resolution: seen.resolution,
        seed: seen.seed,
        sampler: seen.sampler,
        max_bounces: seen.max_bounces,
        roulette_from: seen.roulette_from,
        light_chance: seen.light_chance,
        clamp: seen.clamp,
        ..before
    };
    let tables = keep(tables(world).into(), &packed.tables);
    let changes = Changes { tables: !tables.is(&packed.tables), ..of_params(&before, &packed.params) };
    packed.tables = tables;
    place_eye(packed);
    Ok(changes)
}

// `new`, or what was there before if it is the same.
fn keep<T: PartialEq>(new: Shared<T>, before: &Shared<T>) -> Shared<T> {
    if *new == **before { before.clone() } else { new }
}

fn of_params(before: &Params, after: &Params) -> Changes {
    let camera = |p: &Params| [p.camera_x, p.camera_y, p.camera_z, p.camera_eye, p.camera_film];
    let settings = |p: &Params| {
        let numbers = (p.sampler, p.max_bounces, p.roulette_from, p.features);
        (p.seed, numbers, p.light_chance, p.clamp)
    };
    Changes {
        camera: camera(before) != camera(after),
        lights: before.sky != after.sky,
        settings: settings(before) != settings(after),
        ..Changes::default()
    }
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
