//! Materials of OBJ files as trees of ours; docs/models.md says which becomes what.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Vec2, Vec3};
use kinora_scene::{
    Animated, Bsdf, Channel, Color, ColorSpace, DiffuseModel, Image, ImageTexture, Map, Material, Slot, Texels,
    Texture, UvSet, Wrap,
};

use super::cache::made;
use super::gltf::Warnings;
use super::picture;
use crate::files::{Files, resolve};

/// The materials of one OBJ file.
pub struct Library<'a> {
    /// Pictures are read from here.
    pub files: &'a dyn Files,
    /// The path of the OBJ file, beside which they are.
    pub path: &'a str,
    /// Whether vertices have colours.
    pub colored: bool,
    /// What one is made of stands before it.
    pub made: Vec<Material<Animated>>,
    /// What is left out.
    pub warnings: Warnings,
    images: HashMap<String, Option<Arc<Image>>>,
}

/// How a picture is read, as the line that names it says.
#[derive(Debug, Clone, PartialEq)]
struct Line {
    file: String,
    scale: [f64; 2],
    offset: [f64; 2],
    clamp: bool,
    strength: f64,
    channel: Option<Channel>,
}

/// What makes a surface reflect 4 %.
const USUAL_INDEX: f64 = 1.5;

impl<'a> Library<'a> {
    /// None yet.
    pub fn new(files: &'a dyn Files, path: &'a str, colored: bool) -> Self {
        Library { files, path, colored, made: Vec::new(), warnings: Warnings::default(), images: HashMap::new() }
    }

    fn push(&mut self, bsdf: Bsdf<Animated>, maps: Vec<Map>) -> usize {
        self.made.push(Material { maps, ..bsdf.into() });
        self.made.len() - 1
    }

    // What triangles without a material are made of: matt, of the colours of their vertices.
    fn plain(&mut self) -> usize {
        if self.colored {
            let matt = Bsdf::Diffuse { color: Color::ONE.into(), roughness: 0.0.into(), model: DiffuseModel::Eon };
            return self.push(matt, vec![vertex_color()]);
        }
        self.made.push(Material::default_diffuse());
        self.made.len() - 1
    }

    /// The root of a material's tree; of none, matt in the colours of the vertices.
    pub fn build(&mut self, said: Option<&tobj::Material>) -> usize {
        let Some(said) = said else { return self.plain() };
        let number = |name: &str| said.unknown_param.get(name)?.split_whitespace().next()?.parse::<f64>().ok();
        let ratio = |x: f64| if x.is_finite() { x.clamp(0.0, 1.0) } else { 0.0 };
        let color = |color: Option<[f32; 3]>, default: f32| {
            let color = Vec3::from_array(color.unwrap_or([default; 3]));
            if color.is_finite() { color.max(Vec3::ZERO) } else { Vec3::splat(default) }
        };
        let line = |name: &str| said.unknown_param.get(name).cloned();

        let mut colors = Vec::new();
        if let Some(map) = self.map(said.diffuse_texture.as_ref(), Slot::Color) {
            colors.push(map);
        }
        // A picture without a colour is shown as it is; so are the colours of vertices.
        let grey = if colors.is_empty() && !self.colored { 0.8 } else { 1.0 };
        let base = color(said.diffuse, grey).min(Vec3::ONE);
        if self.colored {
            colors.push(vertex_color());
        }
        let matt = Bsdf::Diffuse { color: base.into(), roughness: 0.0.into(), model: DiffuseModel::Eon };
        let mut root = self.push(matt, colors);

        // A coat: by the extension for physically based materials where it is used, else by the highlight.
        let illum = said.illumination_model;
        let index = said.optical_density.map(f64::from).filter(|n| *n > 1.01 && n.is_finite());
        let (pr, pm) = (number("Pr"), number("Pm"));
        let (map_pr, map_pm) = (line("map_Pr"), line("map_Pm"));
        let physical = pr.is_some() || pm.is_some() || map_pr.is_some() || map_pm.is_some();
        let specular = color(said.specular, 0.0);
        let bright = f64::from(specular.dot(Vec3::new(0.2126, 0.7152, 0.0722)));
        let shines = bright > 0.0 && illum.is_none_or(|model| model >= 2);
        let phong = said.shininess.map_or(0.0, f64::from).max(0.0);
        let highlight = (2.0 / (phong + 2.0)).powf(0.25).clamp(0.0, 1.0);
        let roughness =
            if physical { ratio(pr.unwrap_or(if map_pr.is_some() { 1.0 } else { 0.5 })) } else { highlight };
        if physical || shines {
            let n = index.unwrap_or(USUAL_INDEX);
            let mut ior = n;
            if !physical {
                let f0 = (((n - 1.0) / (n + 1.0)).powi(2) * 2.0 * bright).clamp(0.0, 0.95).sqrt();
                ior = (1.0 + f0) / (1.0 - f0);
            }
            let mut maps = Vec::new();
            maps.extend(self.map(map_pr.as_ref(), Slot::Roughness));
            maps.extend(self.map(map_pm.as_ref(), Slot::Metalness));
            let metalness = ratio(pm.unwrap_or(if map_pm.is_some() { 1.0 } else { 0.0 }));
            let coat = Bsdf::Glossy {
                base: root,
                ior,
                tint: Color::ONE.into(),
                roughness: roughness.into(),
                metalness: metalness.into(),
            };
            root = self.push(coat, maps);
        }
        for (name, what) in [("Ps", "sheen (Ps)"), ("Pc", "a clear coat (Pc)"), ("aniso", "anisotropy (aniso)")] {
            if number(name).is_some_and(|x| x > 0.0) {
                self.warnings.add(format!("{what} of a material"), "it is left out");
            }
        }

        // Refraction, or a share of the rays that pass.
        let through = number("Tr").map(|t| 1.0 - t);
        let dissolve = ratio(said.dissolve.map(f64::from).or(through).unwrap_or(1.0));
        let refracts = matches!(illum, Some(6 | 7));
        if refracts {
            let share = if dissolve < 1.0 { 1.0 - dissolve } else { 1.0 };
            let glass = Bsdf::Dielectric {
                ior: index.unwrap_or(USUAL_INDEX).into(),
                roughness: (if physical { roughness } else { 0.0 }).into(),
                energy_compensation: true,
                attenuation_color: Color::ONE,
                attenuation_distance_m: f64::INFINITY,
                thin: false,
                priority: 0,
            };
            let glass = self.push(glass, Vec::new());
            root = match share {
                1.0 => glass,
                share => self.push(Bsdf::Mix { a: root, b: glass, amount: share.into() }, Vec::new()),
            };
        }

        let glow_map = self.map(line("map_Ke").as_ref(), Slot::Emission);
        let glow = color(said.emissive, if glow_map.is_some() && said.emissive.is_none() { 1.0 } else { 0.0 });
        // Light is added over the coat, not under it.
        if glow.max_element() > 0.0 && matches!(self.made[root].bsdf, Bsdf::Glossy { .. }) {
            root = self.push(Bsdf::Mix { a: root, b: root, amount: 0.0.into() }, Vec::new());
        }
        let mut maps: Vec<Map> = glow_map.into_iter().filter(|_| glow.max_element() > 0.0).collect();
        maps.extend(self.map(said.dissolve_texture.as_ref(), Slot::Opacity));
        let normal = Slot::Normal { strength: 1.0 };
        let bump = line("norm").or_else(|| said.normal_texture.clone()).or_else(|| line("map_Norm"));
        maps.extend(self.map(bump.as_ref(), normal));
        if said.unknown_param.contains_key("disp") {
            self.warnings.add("a displacement map (disp)", "the surface stays as it is");
        }
        let top = &mut self.made[root];
        top.emission = glow;
        top.opacity = if refracts { 1.0 } else { dissolve }.into();
        top.maps.extend(maps);
        root
    }

    /// A texture as a map; none where there is none, or its picture is missing.
    fn map(&mut self, written: Option<&String>, slot: Slot) -> Option<Map> {
        let line = parse(written?);
        let image = self.image(&line.file)?;
        let encoded = matches!(slot, Slot::Color | Slot::Emission) && !matches!(image.texels(), Texels::Rgba32F(_));
        let (slot, image) = match slot {
            Slot::Normal { .. } if is_grey(&image) => {
                (Slot::Normal { strength: 1.0 }, Arc::new(normals_of(&image, line.strength)?))
            }
            Slot::Normal { .. } => (Slot::Normal { strength: line.strength }, image),
            _ => (slot, image),
        };
        let channel = match slot {
            Slot::Color | Slot::Emission | Slot::Normal { .. } => Channel::Color,
            Slot::Opacity if line.channel.is_none() && has_alpha(&image) => Channel::A,
            _ => line.channel.unwrap_or(Channel::R),
        };
        let space = if encoded { ColorSpace::Srgb } else { ColorSpace::Linear };
        let texture = ImageTexture {
            wrap: [if line.clamp { Wrap::Clamp } else { Wrap::Repeat }; 2],
            scale: Vec2::from_array(line.scale.map(|x| x as f32)),
            offset: Vec2::from_array(line.offset.map(|x| x as f32)),
            channel,
            uv_set: UvSet::First,
            ..ImageTexture::new(image, space)
        };
        Some(Map { slot, texture: Arc::new(Texture::Image(texture)) })
    }

    fn image(&mut self, written: &str) -> Option<Arc<Image>> {
        if let Some(known) = self.images.get(written) {
            return known.clone();
        }
        let read = || {
            let path = resolve(self.path, written).map_err(|error| error.message())?;
            made(
                self.files,
                || format!("picture {path}"),
                |files| {
                    let bytes = files.read(&path).map_err(|error| error.message())?;
                    picture::read(&path, &bytes).map_err(|error| format!("`{path}` {}", error.message))
                },
            )
        };
        let image = match read() {
            Ok(image) => Some(image),
            Err(reason) => {
                self.warnings.add(format!("a texture that cannot be used ({reason})"), "its material is without it");
                None
            }
        };
        self.images.insert(written.to_string(), image.clone());
        image
    }
}

fn vertex_color() -> Map {
    Map { slot: Slot::Color, texture: Arc::new(Texture::VertexColor { channel: Channel::Color }) }
}

/// Options and the file's name, which may have spaces. Options may stand behind it too.
fn parse(written: &str) -> Line {
    let mut line =
        Line { file: String::new(), scale: [1.0; 2], offset: [0.0; 2], clamp: false, strength: 1.0, channel: None };
    let mut words = written.split_whitespace().peekable();
    let mut name: Vec<&str> = Vec::new();
    while let Some(word) = words.next() {
        // One to three numbers.
        let numbers = |words: &mut std::iter::Peekable<std::str::SplitWhitespace<'_>>| {
            let mut found = Vec::new();
            while let Some(x) = words.peek().filter(|_| found.len() < 3).and_then(|word| word.parse::<f64>().ok()) {
                found.push(if x.is_finite() { x } else { 0.0 });
                words.next();
            }
            found
        };
        match word.to_ascii_lowercase().as_str() {
            "-s" => {
                let found = numbers(&mut words);
                line.scale = [found.first().copied().unwrap_or(1.0), found.get(1).copied().unwrap_or(1.0)];
            }
            "-o" => {
                let found = numbers(&mut words);
                line.offset = [found.first().copied().unwrap_or(0.0), found.get(1).copied().unwrap_or(0.0)];
            }
            "-t" | "-mm" => _ = numbers(&mut words),
            "-bm" => line.strength = numbers(&mut words).first().copied().unwrap_or(1.0),
            "-clamp" => line.clamp = words.next() == Some("on"),
            "-imfchan" => {
                line.channel = match words.next() {
                    Some("g") => Some(Channel::G),
                    Some("b") => Some(Channel::B),
                    Some("m" | "a") => Some(Channel::A),
                    _ => Some(Channel::R),
                };
            }
            "-blendu" | "-blendv" | "-boost" | "-texres" | "-type" | "-colorspace" | "-cc" => _ = words.next(),
            _ => name.push(word),
        }
    }
    let file = name.join(" ").replace('\\', "/");
    line.file = file.trim_start_matches("./").to_string();
    line
}

fn rgba(image: &Image, i: usize) -> [f32; 4] {
    match image.texels() {
        Texels::Rgba8(texels) => texels[i].map(|x| f32::from(x) / 255.0),
        Texels::Rgba16(texels) => texels[i].map(|x| f32::from(x) / 65535.0),
        Texels::Rgba32F(texels) => texels[i],
    }
}

fn has_alpha(image: &Image) -> bool {
    (0..image.texels().len()).any(|i| rgba(image, i)[3] < 1.0)
}

/// Whether it shows heights, not normals.
fn is_grey(image: &Image) -> bool {
    let near = |a: f32, b: f32| (a - b).abs() < 0.02;
    (0..image.texels().len()).all(|i| {
        let [r, g, b, _] = rgba(image, i);
        near(r, g) && near(g, b)
    })
}

/// The normals of a picture of heights: white is `strength` texels above black. By central differences, as a picture that
/// is repeated.
fn normals_of(image: &Image, strength: f64) -> Option<Image> {
    let (width, height) = (image.width as usize, image.height as usize);
    let at = |x: usize, y: usize| rgba(image, (y % height) * width + x % width)[0];
    let texels = (0..width * height).map(|i| {
        let (x, y) = (i % width, i / width);
        let slope = 0.5 * strength as f32;
        // Rows run downwards, v upwards.
        let n = Vec3::new(
            slope * (at(x + width - 1, y) - at(x + 1, y)),
            slope * (at(x, y + 1) - at(x, y + height - 1)),
            1.0,
        );
        let [r, g, b] = (n.normalize() * 0.5 + 0.5).to_array();
        [r, g, b, 1.0]
    });
    Image::new(image.name.clone(), image.width, image.height, Texels::Rgba32F(texels.collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_options_before_and_behind() {
        let line = parse("-s 2 3 1 -o 0.5 -clamp on -bm 1.5 .\\my wood.jpg -imfchan g");
        assert_eq!(line.file, "my wood.jpg");
        assert_eq!((line.scale, line.offset), ([2.0, 3.0], [0.5, 0.0]));
        assert_eq!((line.clamp, line.strength, line.channel), (true, 1.5, Some(Channel::G)));
    }

    #[test]
    fn heights_rise_to_the_right_and_upwards() {
        // Brighter to the right, and to the top.
        let texel = |x: u32, y: u32| [(10 * x + 20 * (3 - y)) as u8; 4];
        let texels = (0..16).map(|i| texel(i % 4, i / 4)).collect();
        let image = Image::new("h", 4, 4, Texels::Rgba8(texels)).expect("as many");
        let normals = normals_of(&image, 8.0).expect("as many");
        let [x, y, z, _] = rgba(&normals, 5);
        assert!(x < 0.5 && y < x && z > 0.5, "{x} {y} {z}");
    }
}
