//! Textures of materials: pictures, read once each.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec2, Vec4};
use kinora_scene::{
    Channel, ColorSpace, Image, ImageTexture, Map, Paint, Point, Scene, Shape, Slot, Texels, Texture, UvSet,
};

use super::cache::made;
use super::{AssetError, picture};
use crate::builtin::texture as said;
use crate::diagnostic::{Applicability, Diagnostic};
use crate::files::{Files, diagnose, resolve};
use crate::lower::{Lowered, TextureRequest};
use crate::source::{Span, Texts};
use crate::syntax::words;

/// Reads the pictures and puts the textures into the scene's materials.
pub fn load_textures(lowered: &mut Lowered, files: &dyn Files, source: &Texts, diagnostics: &mut Vec<Diagnostic>) {
    let mut loader = Loader { files, source, diagnostics, images: HashMap::new(), textures: HashMap::new() };
    for request in &lowered.textures {
        loader.data_as_color(request);
        let texture = loader.texture(&request.texture, request.color);
        if let (Some(texture), Some(material)) = (texture, lowered.scene.materials.get_mut(request.material)) {
            material.maps.push(Map { slot: request.slot, texture });
        }
    }
    without_coordinates(lowered, source, diagnostics);
}

struct Loader<'a> {
    files: &'a dyn Files,
    source: &'a Texts,
    diagnostics: &'a mut Vec<Diagnostic>,
    images: HashMap<String, Option<Arc<Image>>>,
    /// By what the scene says, and whether it is a colour.
    textures: HashMap<(*const said::Texture, bool), Option<Arc<Texture>>>,
}

impl Loader<'_> {
    fn texture(&mut self, texture: &Arc<said::Texture>, color: bool) -> Option<Arc<Texture>> {
        let key = (Arc::as_ptr(texture), color);
        if let Some(known) = self.textures.get(&key) {
            return known.clone();
        }
        let made = self.make(texture, color).map(Arc::new);
        self.textures.insert(key, made.clone());
        made
    }

    fn make(&mut self, texture: &said::Texture, color: bool) -> Option<Texture> {
        Some(match texture {
            said::Texture::Image(picture) => {
                let image = self.image(picture)?;
                // Numbers of light are what they say; a picture of 8 or 16 bits is meant for a screen.
                let encoded = color && !matches!(image.texels(), Texels::Rgba32F(_));
                let space = if encoded { ColorSpace::Srgb } else { ColorSpace::Linear };
                let channel = if color { Channel::Color } else { Channel::R };
                reading(picture, image, picture.space.unwrap_or(space), picture.channel.unwrap_or(channel))
            }
            said::Texture::Normal { picture, .. } => {
                let image = self.image(picture)?;
                reading(picture, image, ColorSpace::Linear, Channel::Color)
            }
            said::Texture::Tape(tape) => Texture::Tape(tape.clone()),
            said::Texture::Checker { squares: [a, b], scale } => Texture::Checker {
                a: self.paint(&a.value, color)?,
                b: self.paint(&b.value, color)?,
                scale: DVec2::from_array(*scale).as_vec2(),
                uv_set: UvSet::First,
            },
        })
    }

    fn paint(&mut self, paint: &said::Paint, color: bool) -> Option<Paint> {
        Some(match paint {
            said::Paint::Color([r, g, b]) => Paint::Color(Vec4::new(*r as f32, *g as f32, *b as f32, 1.0)),
            said::Paint::Number(x) => Paint::Color(Vec4::new(*x as f32, *x as f32, *x as f32, 1.0)),
            said::Paint::Texture(texture) => Paint::Texture(self.texture(texture, color)?),
        })
    }

    fn image(&mut self, picture: &said::Picture) -> Option<Arc<Image>> {
        let (file, span) = (self.source.id, picture.span);
        let path = match resolve(&self.source.source(span.start).name, &picture.file) {
            Ok(path) => path,
            Err(error) => {
                self.diagnostics.push(error.diagnostic(file, span));
                return None;
            }
        };
        if let Some(known) = self.images.get(&path) {
            return known.clone();
        }
        let image = match self.read(&path, picture) {
            Ok(image) => Some(image),
            Err(diagnostic) => {
                self.diagnostics.push(*diagnostic);
                None
            }
        };
        self.images.insert(path, image.clone());
        image
    }

    fn read(&self, path: &str, picture: &said::Picture) -> Result<Arc<Image>, Box<Diagnostic>> {
        let (file, span) = (self.source.id, picture.span);
        made(
            self.files,
            || format!("picture {path}"),
            |files| {
                let bytes = files
                    .read(path)
                    .map_err(|error| diagnose(files, &error, (file, span), &picture.file, self.source.slice(span)))?;
                picture::read(path, &bytes).map_err(|AssetError { code, message, help }| {
                    let diagnostic =
                        Diagnostic::new(code, format!("`{path}` {message}")).primary(file, span, "cannot be used");
                    let help = if help.is_empty() { "save it again: the file is damaged, or cut off" } else { help };
                    Box::new(diagnostic.help(help))
                })
            },
        )
    }

    /// W0809: a ratio that is read as if it were light.
    fn data_as_color(&mut self, request: &TextureRequest) {
        let said::Texture::Image(picture) = &*request.texture else { return };
        if !request.color && picture.space == Some(ColorSpace::Srgb) {
            let (file, text) = (self.source.id, self.source.slice(request.span));
            let found = Diagnostic::new("W0809", "a ratio is read as an sRGB colour").primary(
                file,
                request.span,
                "0.5 of the file counts as 0.21",
            );
            self.diagnostics.push(match words(text, "srgb").as_slice() {
                [at] => {
                    let start = request.span.start + *at as u32;
                    let place = Span::new(start, start + 4);
                    found.fix(Applicability::Safe, "write `space: linear`", file, place, "linear")
                }
                _ => found.help("leave out `space: srgb`"),
            });
        }
    }
}

fn reading(picture: &said::Picture, image: Arc<Image>, space: ColorSpace, channel: Channel) -> Texture {
    Texture::Image(ImageTexture {
        wrap: [picture.wrap; 2],
        filter: picture.filter,
        scale: DVec2::from_array(picture.scale).as_vec2(),
        offset: DVec2::from_array(picture.offset).as_vec2(),
        rotation: picture.rotation,
        moving: picture.moving.clone(),
        channel,
        ..ImageTexture::new(image, space)
    })
}

/// W0808: a texture on a mesh that does not say where it goes.
fn without_coordinates(lowered: &Lowered, source: &Texts, diagnostics: &mut Vec<Diagnostic>) {
    let scene = &lowered.scene;
    for request in &lowered.meshes {
        let Some(node) = scene.nodes.get(request.node) else { continue };
        let Some(Shape::Mesh(mesh)) = &node.shape else { continue };
        if mesh.triangles.is_empty() || !mesh.uvs.is_empty() {
            continue;
        }
        let Some(material) = textured_part(scene, node.material) else { continue };
        let mut diagnostic = Diagnostic::new("W0808", "a texture on a mesh without texture coordinates")
            .primary(source.id, request.span, "does not say where the texture goes")
            .help("give it `uvs`, or a material without textures");
        if let Some(texture) = lowered.textures.iter().find(|texture| texture.material == material) {
            diagnostic = diagnostic.label(source.id, texture.span, "the texture");
        }
        diagnostics.push(diagnostic);
    }
}

// The first part of a material that needs texture coordinates.
fn textured_part(scene: &Scene, material: usize) -> Option<usize> {
    let mut open = vec![material];
    let mut seen = std::collections::HashSet::new();
    while let Some(index) = open.pop() {
        let Some(material) = scene.materials.get(index).filter(|_| seen.insert(index)) else { continue };
        let needs = |map: &Map| reads_coordinates(&map.texture) || is_normal(map.slot);
        if material.maps.iter().any(needs) {
            return Some(index);
        }
        open.extend(material.bsdf.parts().into_iter().flatten());
    }
    None
}

fn reads_coordinates(texture: &Texture) -> bool {
    match texture {
        Texture::Image(_) | Texture::Checker { .. } => true,
        Texture::Tape(tape) => tape.reads(Point::Uv),
        Texture::VertexColor { .. } => false,
    }
}

fn is_normal(slot: Slot) -> bool {
    matches!(slot, Slot::Normal { .. })
}
