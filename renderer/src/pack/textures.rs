//! Textures among the kernel's `words`: tables, texels, headers, and what each material's maps are. A texture that is used
//! twice is stored once, and so are texels.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock};

use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use kinora_kernel::albedo;
use kinora_kernel::generated::{
    FEATURE_NORMAL_MAP, FEATURE_TAPE, FEATURE_TEXTURE, FORMAT_FLOAT, FORMAT_LINEAR_8, FORMAT_LINEAR_16, FORMAT_SRGB_8,
    FORMAT_SRGB_16, MAPS_SIZE, MAX_TEXTURES, METAL_ROUGHNESSES, STRETCHED_ANISOTROPIES, STRETCHED_ROUGHNESSES,
    TEXTURE_CHANNEL, TEXTURE_CHECKER, TEXTURE_CONSTANT, TEXTURE_FORMAT, TEXTURE_IMAGE, TEXTURE_NEAREST,
    TEXTURE_SECOND_UV, TEXTURE_VERTEX_COLOR, TEXTURE_WRAP_U, TEXTURE_WRAP_V, WORDS_END, WORDS_LOST,
    WORDS_LOST_STRETCHED, WORDS_SRGB, WRAP_CLAMP, WRAP_MIRROR, WRAP_REPEAT,
};
use kinora_scene::{Channel, ColorSpace, Image, ImageTexture, Mesh, Paint, TexelFilter, Texels, Texture, UvSet, Wrap};
use rayon::prelude::*;

use super::geometry::encode_normal;
use super::{PackError, tapes};

/// The words of a material's maps, as `MAPS_…` count them.
pub type Maps = [u32; MAPS_SIZE as usize];

/// Digest, width, height and format of an image's texels.
type ImageKey = (u64, u32, u32, u32);

/// What is collected for `words`.
pub struct Textures {
    /// Begins with a 0, since place 0 stands for nothing.
    words: Vec<u32>,
    images: HashMap<ImageKey, Vec<(Arc<Image>, u32)>>,
    textures: HashMap<*const Texture, (Arc<Texture>, u32)>,
    averages: HashMap<*const Texture, Vec4>,
    /// Of whole pictures, also of the world before.
    pub means: Means,
    /// One of each of the materials' records that have any.
    maps: Vec<Maps>,
    /// The places of the rows that lead to the own spaces of shapes, by shape.
    locals: Vec<u32>,
    /// `FEATURE_…` bits.
    pub features: u32,
}

impl Default for Textures {
    fn default() -> Self {
        Self {
            words: vec![0],
            images: HashMap::new(),
            textures: HashMap::new(),
            averages: HashMap::new(),
            means: Means::default(),
            maps: Vec::new(),
            locals: Vec::new(),
            features: 0,
        }
    }
}

/// The means of pictures, which are found once as long as they are used.
#[derive(Default)]
pub struct Means(Vec<Mean>);

struct Mean {
    image: Arc<Image>,
    space: ColorSpace,
    value: Vec4,
    used: bool,
}

impl Means {
    /// Another world: what the one before did not use goes.
    pub fn begin(&mut self) {
        self.0.retain_mut(|mean| std::mem::take(&mut mean.used));
    }

    fn of(&mut self, image: &Arc<Image>, space: ColorSpace) -> Vec4 {
        let known = self.0.iter_mut().find(|mean| Arc::ptr_eq(&mean.image, image) && mean.space == space);
        if let Some(mean) = known {
            mean.used = true;
            return mean.value;
        }
        let value = average_texel(image, space);
        self.0.push(Mean { image: image.clone(), space, value, used: true });
        value
    }
}

/// Of all words, since places are counted in 32 bits.
const MAX_WORDS: usize = u32::MAX as usize;

impl Textures {
    /// From here on there are textures: the tables that the kernel reads for them.
    pub fn begin(&mut self) {
        if self.features & FEATURE_TEXTURE != 0 {
            return;
        }
        self.features |= FEATURE_TEXTURE;
        self.words.resize(WORDS_END as usize, 0);
        for (word, value) in self.words[WORDS_SRGB as usize..].iter_mut().zip(0..256) {
            *word = (srgb_decode(f64::from(value) / 255.0) as f32).to_bits();
        }
    }

    /// The tables of what metals lose are read.
    pub fn needs_losses(&mut self, stretched: bool) {
        let mut copy = |first: u32, table: &[f32]| {
            for (word, value) in self.words[first as usize..].iter_mut().zip(table) {
                *word = value.to_bits();
            }
        };
        copy(WORDS_LOST, &LOST);
        if stretched {
            copy(WORDS_LOST_STRETCHED, &LOST_STRETCHED);
        }
    }

    /// Says what the maps of record `material` are.
    pub fn set_maps(&mut self, material: usize, maps: Maps) {
        if maps == Maps::default() {
            return;
        }
        self.begin();
        if self.maps.len() <= material {
            self.maps.resize(material + 1, Maps::default());
        }
        self.maps[material] = maps;
    }

    /// What the maps of record `material` are.
    pub fn maps_of(&self, material: usize) -> Maps {
        self.maps.get(material).copied().unwrap_or_default()
    }

    /// Appends `words`; gives their place.
    pub fn push(&mut self, words: impl IntoIterator<Item = u32>) -> u32 {
        let place = self.words.len().min(MAX_WORDS) as u32;
        self.words.extend(words);
        place
    }

    /// The place of a normal map.
    pub fn normal_map(&mut self, texture: &Arc<Texture>, strength: f64) -> Result<u32, PackError> {
        let texture = self.place(texture)?;
        self.features |= FEATURE_NORMAL_MAP;
        Ok(self.push([texture, (strength as f32).to_bits()]))
    }

    /// The place of a texture's header.
    ///
    /// # Errors
    /// Textures are too deep inside one another, or too large.
    pub fn place(&mut self, texture: &Arc<Texture>) -> Result<u32, PackError> {
        self.begin();
        self.place_at(texture, 1)
    }

    fn place_at(&mut self, texture: &Arc<Texture>, depth: u32) -> Result<u32, PackError> {
        if depth > MAX_TEXTURES {
            return Err(PackError::Textures { limit: MAX_TEXTURES as usize });
        }
        if let Some((_, place)) = self.textures.get(&Arc::as_ptr(texture)) {
            return Ok(*place);
        }
        let place = match &**texture {
            Texture::Image(image) => {
                let texels = self.texels(&image.image, image.space)?;
                self.push(image_header(image, texels))
            }
            Texture::Checker { a, b, scale, uv_set } => {
                let a = self.paint(a, depth)?;
                let b = self.paint(b, depth)?;
                let scale = scale.to_array().map(f32::to_bits);
                self.push([TEXTURE_CHECKER | second(*uv_set), a, b, scale[0], scale[1]])
            }
            Texture::Tape(tape) => {
                self.features |= FEATURE_TAPE;
                self.push(tapes::words(tape)?)
            }
            Texture::VertexColor { channel } => {
                self.push([TEXTURE_VERTEX_COLOR | channel_code(*channel) << TEXTURE_CHANNEL])
            }
        };
        self.textures.insert(Arc::as_ptr(texture), (texture.clone(), place));
        Ok(place)
    }

    fn paint(&mut self, paint: &Paint, depth: u32) -> Result<u32, PackError> {
        match paint {
            Paint::Color(color) => Ok(self.constant(*color)),
            Paint::Texture(texture) => self.place_at(texture, depth + 1),
        }
    }

    fn constant(&mut self, color: Vec4) -> u32 {
        self.push([TEXTURE_CONSTANT].into_iter().chain(color.to_array().map(f32::to_bits)))
    }

    // The place of an image's texels.
    fn texels(&mut self, image: &Arc<Image>, space: ColorSpace) -> Result<u32, PackError> {
        let (format, size) = format_of(image, space);
        let key = (image.digest(), image.width, image.height, format);
        let same = |other: &Arc<Image>| Arc::ptr_eq(other, image) || other.texels() == image.texels();
        if let Some((_, place)) = self.images.get(&key).and_then(|known| known.iter().find(|(other, _)| same(other))) {
            return Ok(*place);
        }
        let place = self.words.len();
        if place as u64 + image.texels().len() as u64 * size > MAX_WORDS as u64 {
            let bytes = (place as u64 + image.texels().len() as u64 * size) * 4;
            return Err(PackError::Texels { bytes, limit: MAX_WORDS as u64 * 4 });
        }
        let half = |low: u16, high: u16| u32::from(low) | u32::from(high) << 16;
        match image.texels() {
            Texels::Rgba8(texels) => self.words.extend(texels.iter().map(|t| u32::from_le_bytes(*t))),
            Texels::Rgba16(texels) => {
                self.words.extend(texels.iter().flat_map(|&[r, g, b, a]| [half(r, g), half(b, a)]));
            }
            Texels::Rgba32F(texels) => {
                let color = |c: f32| match space {
                    ColorSpace::Linear => c,
                    ColorSpace::Srgb => srgb_decode(f64::from(c.max(0.0))) as f32,
                };
                let words = |&[r, g, b, a]: &[f32; 4]| [color(r), color(g), color(b), a].map(f32::to_bits);
                self.words.extend(texels.iter().flat_map(words));
            }
        }
        self.images.entry(key).or_default().push((image.clone(), place as u32));
        Ok(place as u32)
    }

    /// The mean of a texture over 0..1, each texel once.
    pub fn average(&mut self, texture: &Arc<Texture>) -> Vec4 {
        self.average_at(texture, 1)
    }

    fn average_at(&mut self, texture: &Arc<Texture>, depth: u32) -> Vec4 {
        if let Some(average) = self.averages.get(&Arc::as_ptr(texture)) {
            return *average;
        }
        let average = match &**texture {
            _ if depth > MAX_TEXTURES => Vec4::ONE,
            Texture::Image(image) => with_channel(self.means.of(&image.image, image.space), image.channel),
            Texture::Checker { a, b, .. } => {
                let mut of = |paint: &Paint| match paint {
                    Paint::Color(color) => *color,
                    Paint::Texture(texture) => self.average_at(texture, depth + 1),
                };
                (of(a) + of(b)) * 0.5
            }
            Texture::Tape(tape) => tapes::average(tape),
            Texture::VertexColor { .. } => Vec4::ONE,
        };
        self.averages.insert(Arc::as_ptr(texture), average);
        average
    }

    /// The place of what the vertices of `mesh` have, of whose triangles' corners `corners` says the order; tangents are
    /// placed in the world by `place`.
    pub fn mesh(
        &mut self,
        mesh: &Mesh,
        place: DAffine3,
        corners: impl Fn(&[u32; 3]) -> [usize; 3] + Sync,
        tangents: bool,
    ) -> u32 {
        self.begin();
        let corner_words = self.words.len() as u32;
        self.words.par_extend(mesh.triangles.par_iter().flat_map_iter(|t| corners(t).map(|corner| corner as u32)));
        let pairs = |this: &mut Self, uvs: &[Vec2]| match uvs {
            [] => 0,
            uvs => this.push(uvs.iter().flat_map(|uv| uv.to_array()).map(f32::to_bits)),
        };
        let uvs = pairs(self, &mesh.uvs);
        let more = pairs(self, &mesh.more_uvs);
        let colors = match mesh.colors.as_slice() {
            [] => 0,
            colors => self.push(colors.iter().flat_map(|color| color.to_array()).map(f32::to_bits)),
        };
        let tangents = match (tangents && !mesh.uvs.is_empty(), mesh.tangents.is_empty()) {
            (false, _) => 0,
            (true, false) => self.push(pack_tangents(&mesh.tangents, place)),
            (true, true) => self.push(pack_tangents(&tangents_of(mesh), place)),
        };
        self.push([corner_words, uvs, more, colors, tangents])
    }

    /// Says how `shape`, which lies at `place`, is reached from the world or its part.
    pub fn local(&mut self, shape: usize, place: DAffine3) {
        let inverse = place.inverse();
        let row = |i: usize| inverse.matrix3.row(i).extend(inverse.translation[i]).as_vec4().to_array();
        let rows = self.push([0, 1, 2].into_iter().flat_map(row).map(f32::to_bits));
        if self.locals.len() <= shape {
            self.locals.resize(shape + 1, 0);
        }
        self.locals[shape] = rows;
    }

    /// All words, and the two places of `Params::textures`, for so many materials and shapes.
    pub fn finish(mut self, materials: usize, shapes: usize) -> Result<(Vec<u32>, [u32; 2]), PackError> {
        let mut places = [0; 2];
        if self.features & FEATURE_TEXTURE != 0 {
            self.maps.resize(materials, Maps::default());
            let maps = std::mem::take(&mut self.maps);
            places[0] = self.push(maps.into_iter().flatten());
        }
        if !self.locals.is_empty() {
            self.locals.resize(shapes, 0);
            let locals = std::mem::take(&mut self.locals);
            places[1] = self.push(locals);
        }
        if self.words.len() > MAX_WORDS {
            return Err(PackError::Texels { bytes: self.words.len() as u64 * 4, limit: MAX_WORDS as u64 * 4 });
        }
        Ok((self.words, places))
    }
}

// Of an image, and words a texel.
fn format_of(image: &Image, space: ColorSpace) -> (u32, u64) {
    match (image.texels(), space) {
        (Texels::Rgba8(_), ColorSpace::Srgb) => (FORMAT_SRGB_8, 1),
        (Texels::Rgba8(_), ColorSpace::Linear) => (FORMAT_LINEAR_8, 1),
        (Texels::Rgba16(_), ColorSpace::Srgb) => (FORMAT_SRGB_16, 2),
        (Texels::Rgba16(_), ColorSpace::Linear) => (FORMAT_LINEAR_16, 2),
        // Decoded where it is stored, so that both are told apart by their texels.
        (Texels::Rgba32F(_), ColorSpace::Srgb) => (FORMAT_FLOAT | 1 << 8, 4),
        (Texels::Rgba32F(_), ColorSpace::Linear) => (FORMAT_FLOAT, 4),
    }
}

fn image_header(texture: &ImageTexture, texels: u32) -> [u32; 10] {
    let wrap = |wrap| match wrap {
        Wrap::Repeat => WRAP_REPEAT,
        Wrap::Mirror => WRAP_MIRROR,
        Wrap::Clamp => WRAP_CLAMP,
    };
    let nearest = if texture.filter == TexelFilter::Nearest { TEXTURE_NEAREST } else { 0 };
    let head = TEXTURE_IMAGE
        | channel_code(texture.channel) << TEXTURE_CHANNEL
        | second(texture.uv_set)
        | wrap(texture.wrap[0]) << TEXTURE_WRAP_U
        | wrap(texture.wrap[1]) << TEXTURE_WRAP_V
        | nearest
        | (format_of(&texture.image, texture.space).0 & 0xff) << TEXTURE_FORMAT;
    let (sin, cos) = texture.rotation.sin_cos();
    let (scale, offset) = (texture.scale.as_dvec2(), texture.offset);
    let row = |u: f64, v: f64, offset: f32| [u as f32, v as f32, offset].map(f32::to_bits);
    let u = row(cos * scale.x, -sin * scale.y, offset.x);
    let v = row(sin * scale.x, cos * scale.y, offset.y);
    [head, texture.image.width, texture.image.height, texels, u[0], u[1], u[2], v[0], v[1], v[2]]
}

fn channel_code(channel: Channel) -> u32 {
    match channel {
        Channel::Color => 0,
        Channel::R => 1,
        Channel::G => 2,
        Channel::B => 3,
        Channel::A => 4,
    }
}

fn with_channel(color: Vec4, channel: Channel) -> Vec4 {
    match channel {
        Channel::Color => color,
        Channel::R => Vec4::splat(color.x),
        Channel::G => Vec4::splat(color.y),
        Channel::B => Vec4::splat(color.z),
        Channel::A => Vec4::splat(color.w),
    }
}

fn second(uv_set: UvSet) -> u32 {
    match uv_set {
        UvSet::First => 0,
        UvSet::Second => TEXTURE_SECOND_UV,
    }
}

/// IEC 61966-2-1.
pub fn srgb_decode(x: f64) -> f64 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

fn average_texel(image: &Image, space: ColorSpace) -> Vec4 {
    let decode = |c: f64| if space == ColorSpace::Srgb { srgb_decode(c.max(0.0)) } else { c };
    let count = image.texels().len() as f64;
    let mean = |sum: [f64; 4]| Vec4::from_array(sum.map(|sum| (sum / count) as f32));
    let add = |a: [f64; 4], b: [f64; 4]| std::array::from_fn(|i| a[i] + b[i]);
    let scaled = |t: [f64; 4]| [decode(t[0]), decode(t[1]), decode(t[2]), t[3]];
    // Chunks are summed in their order, so that the sum is the same on any number of threads.
    match image.texels() {
        Texels::Rgba8(texels) => {
            let table: Vec<f64> = (0..256).map(|i| decode(f64::from(i) / 255.0)).collect();
            let of = |&[r, g, b, a]: &[u8; 4]| {
                [table[r as usize], table[g as usize], table[b as usize], f64::from(a) / 255.0]
            };
            mean(chunked(texels, &of, &add))
        }
        Texels::Rgba16(texels) => {
            mean(chunked(texels, &|t: &[u16; 4]| scaled(t.map(|c| f64::from(c) / 65535.0)), &add))
        }
        Texels::Rgba32F(texels) => mean(chunked(texels, &|t: &[f32; 4]| scaled(t.map(f64::from)), &add)),
    }
}

fn chunked<T: Sync>(
    texels: &[T],
    of: &(impl Fn(&T) -> [f64; 4] + Sync),
    add: &(impl Fn([f64; 4], [f64; 4]) -> [f64; 4] + Sync),
) -> [f64; 4] {
    let sums: Vec<[f64; 4]> =
        texels.par_chunks(1 << 14).map(|chunk| chunk.iter().map(of).fold([0.0; 4], add)).collect();
    sums.into_iter().fold([0.0; 4], add)
}

// The direction, and the side in the lowest bit; 0 where there is none.
fn pack_tangents(tangents: &[Vec4], place: DAffine3) -> Vec<u32> {
    let mirrored = place.matrix3.determinant() < 0.0;
    let pack = |t: &Vec4| {
        let along = (place.matrix3 * t.truncate().as_dvec3()).normalize_or_zero().as_vec3();
        match encode_normal(along) & !1 {
            _ if along == Vec3::ZERO => 0,
            code => code.max(2) | u32::from((t.w < 0.0) != mirrored),
        }
    };
    tangents.par_iter().map(pack).collect()
}

// The directions of growing u at the vertices: of the triangles around each, by their angles there. 0 where they cancel,
// or lie on different sides.
fn tangents_of(mesh: &Mesh) -> Vec<Vec4> {
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    let mut sides = vec![0_i8; mesh.positions.len()];
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|v| mesh.positions[v as usize].as_dvec3());
        let [ta, tb, tc] = triangle.map(|v| mesh.uvs[v as usize].as_dvec2());
        let (u, v) = (tb - ta, tc - ta);
        let det = u.x * v.y - u.y * v.x;
        let side = if det < 0.0 { -1 } else { 1 };
        let Some(along) = (((b - a) * v.y - (c - a) * u.y) * f64::from(side)).try_normalize() else { continue };
        if det == 0.0 {
            continue;
        }
        let corners = [a, b, c];
        for i in 0..3 {
            let (to, from) = (corners[(i + 1) % 3] - corners[i], corners[(i + 2) % 3] - corners[i]);
            let vertex = triangle[i] as usize;
            let angle = to.angle_between(from);
            sums[vertex] += along * if angle.is_finite() { angle } else { 0.0 };
            let seen = &mut sides[vertex];
            *seen = if *seen == 0 || *seen == side { side } else { 2 };
        }
    }
    let pack = |(sum, side): (DVec3, i8)| match sum.try_normalize() {
        Some(along) if side != 2 => along.as_vec3().extend(f32::from(side)),
        _ => Vec4::ZERO,
    };
    sums.into_iter().zip(sides).map(pack).collect()
}

static LOST: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let node = |i: u32| f64::from(i) / f64::from(METAL_ROUGHNESSES - 1);
    (0..METAL_ROUGHNESSES).map(|i| albedo::average_lost(node(i), 0.0) as f32).collect()
});

static LOST_STRETCHED: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let entry = |i: u32| {
        let roughness = f64::from(i % STRETCHED_ROUGHNESSES) / f64::from(STRETCHED_ROUGHNESSES - 1);
        let anisotropy = f64::from(i / STRETCHED_ROUGHNESSES) / f64::from(STRETCHED_ANISOTROPIES - 1);
        // Next to none, it is still that table which is read.
        albedo::average_lost(roughness, anisotropy.max(1e-6)) as f32
    };
    (0..STRETCHED_ROUGHNESSES * STRETCHED_ANISOTROPIES).into_par_iter().map(entry).collect()
});
