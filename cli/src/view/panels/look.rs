//! Which part of the scene each pixel shows, and how far away it is: for picking and for the outline of what is chosen.
//!
//! A thread of its own looks only when something is asked, with one ray a pixel, on the CPU: the picture goes on beside it.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use egui::{Color32, ColorImage};
use kinora_renderer::{Choice, Film, Options, Renderer, Request};
use kinora_scene::{Copied, Scene, Shown, Shutter, View, World};

use super::outline::Part;
use crate::session::Loaded;
use crate::view::slot::Slot;

/// Colour of the outline.
const LINE: Color32 = Color32::from_rgb(255, 160, 40);
/// What lies around it, so that it is seen on any ground.
const HALO: Color32 = Color32::from_rgba_premultiplied(0, 0, 0, 130);

/// What is looked at.
#[derive(Clone)]
pub struct Sight {
    /// The scene.
    pub loaded: Arc<Loaded>,
    /// Which load of it that is.
    pub load: u64,
    /// When.
    pub shutter: Shutter,
    /// By which camera, if it is not the scene's.
    pub view: Option<View>,
    /// Width and height in pixels.
    pub size: [u32; 2],
}

impl Sight {
    /// Whether both show the same.
    pub fn same(&self, other: &Sight) -> bool {
        let key = |sight: &Sight| (sight.load, sight.shutter.open_s.to_bits(), sight.size);
        key(self) == key(other) && self.view == other.view
    }
}

/// What was seen.
pub struct Seen {
    /// Where it was looked.
    pub sight: Sight,
    parts: Vec<Option<Part>>,
    /// Metres along the camera's axis.
    depths: Vec<f32>,
}

impl Seen {
    /// What is at a place of the picture, 0..=1 from the left and from the top, and how far away it is, in metres.
    pub fn at(&self, place: [f32; 2]) -> Option<(Part, f64)> {
        let [width, height] = self.sight.size;
        let cell = |at: f32, count: u32| {
            (0.0..=1.0).contains(&at).then(|| ((at * count as f32) as usize).min(count.saturating_sub(1) as usize))
        };
        let index = cell(place[1], height)? * width as usize + cell(place[0], width)?;
        let part = (*self.parts.get(index)?)?;
        Some((part, f64::from(*self.depths.get(index)?)))
    }

    /// The outline of what is `chosen`, to lie over the picture; `None` where nothing of it is seen.
    pub fn outline(&self, chosen: &HashSet<Part>) -> Option<ColorImage> {
        let [width, height] = self.sight.size.map(|side| side as usize);
        let inside: Vec<bool> = self.parts.iter().map(|part| part.is_some_and(|part| chosen.contains(&part))).collect();
        if !inside.iter().any(|inside| *inside) || inside.len() != width * height {
            return None;
        }
        let at = |x: usize, y: usize| x < width && y < height && inside[y * width + x];
        // How near a pixel is to one of the other kind, as far as two.
        let near = |x: usize, y: usize, kind: bool, reach: usize| {
            let (left, top) = (x.saturating_sub(reach), y.saturating_sub(reach));
            let mut places = (top..=y + reach).flat_map(|y| (left..=x + reach).map(move |x| (x, y)));
            places.any(|(x, y)| x < width && y < height && at(x, y) == kind)
        };
        let mut pixels = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let edge = x == 0 || y == 0 || x + 1 == width || y + 1 == height;
                pixels.push(match at(x, y) {
                    true if edge || near(x, y, false, 1) => LINE,
                    false if near(x, y, true, 1) => LINE,
                    false if near(x, y, true, 2) => HALO,
                    _ => Color32::TRANSPARENT,
                });
            }
        }
        Some(ColorImage::new([width, height], pixels))
    }
}

/// Where sights are left and what was seen is fetched.
#[derive(Default)]
pub struct Window {
    /// To the thread; closed when the window is.
    pub sights: Slot<Sight>,
    /// From the thread; `None` where there was nothing to see.
    pub results: Slot<Result<Seen, Sight>>,
}

/// Works until `window.sights` is closed; `wake` tells of every result.
pub fn run(window: &Window, wake: &dyn Fn()) {
    let mut renderer: Option<Renderer> = None;
    while let Some(sight) = window.sights.wait() {
        if renderer.is_none() {
            // One thread is enough, and leaves the others to the picture.
            let options = Options { threads: 1, checks: false };
            renderer = kinora_renderer::open(Choice::Cpu, options).ok().map(Renderer::new);
        }
        let seen = renderer.as_mut().and_then(|renderer| look(renderer, &sight, &|| !window.sights.calls()));
        window.results.put(seen.ok_or(sight));
        wake();
    }
}

/// Looks; `None` where the scene has no picture then, or `go_on` says that there is something newer.
fn look(renderer: &mut Renderer, sight: &Sight, go_on: &dyn Fn() -> bool) -> Option<Seen> {
    let shutter = Shutter { close_s: sight.shutter.open_s, ..sight.shutter };
    let mut world = sight.loaded.sample(shutter).ok()?;
    if let Some(view) = &sight.view {
        world.view = view.clone();
    }
    // The middle of each pixel, as near as there is.
    world.render.samples = 1;
    world.render.adaptive = 0.0;
    world.render.view = Shown::Id;
    world.render.resolution = sight.size;
    let mut film = renderer.load_for(&world, &Request { layers: true, ..Request::default() }).ok()?;
    if !renderer.trace_pass(&mut film, 1, &|_: f64| go_on()).ok()? {
        return None;
    }
    let (parts, depths) = parts(&film, &world, sight.loaded.scene.as_deref()?);
    Some(Seen { sight: sight.clone(), parts, depths })
}

fn parts(film: &Film, world: &World, scene: &Scene) -> (Vec<Option<Part>>, Vec<f32>) {
    let of_id = names(world, scene);
    let [width, height] = film.size().map(|side| side as usize);
    let seen = (0..width * height).map(|at| match film.seen(at) {
        Some(seen) if seen.id > 0 => (of_id(seen.id as usize - 1), seen.depth),
        _ => (None, f32::INFINITY),
    });
    seen.unzip()
}

/// What an id less one is in the scene: a node, a light, or a copy, which is told as the node that shows it.
fn names(world: &World, scene: &Scene) -> impl Fn(usize) -> Option<Part> {
    let (nodes, lights) = (scene.nodes.len(), scene.lights.len());
    // First id, how many, and the node.
    let mut copies: Vec<(usize, usize, usize)> = Vec::new();
    let mut add =
        |list: &[Copied]| copies.extend(list.iter().map(|copied| (copied.first, copied.places.len(), copied.node)));
    add(&world.copies);
    world.parts.iter().for_each(|part| add(&part.copies));
    copies.sort_unstable();
    move |id| {
        if id < nodes {
            return Some(Part::Node(id));
        }
        if id < nodes + lights {
            return Some(Part::Light(id - nodes));
        }
        let at = copies.partition_point(|(first, ..)| *first <= id).checked_sub(1)?;
        let (first, count, node) = *copies.get(at)?;
        (id < first + count).then_some(Part::Node(node))
    }
}

/// What is chosen together with these parts: what moves with them.
pub fn with_children(scene: &Scene, parts: &[Part]) -> HashSet<Part> {
    let mut chosen: HashSet<Part> = parts.iter().copied().collect();
    let mut known: HashMap<usize, bool> = HashMap::new();
    for (at, node) in scene.nodes.iter().enumerate() {
        // Parents stand before their children.
        let inside =
            chosen.contains(&Part::Node(at)) || node.parent.is_some_and(|parent| known.get(&parent) == Some(&true));
        known.insert(at, inside);
        if inside {
            chosen.insert(Part::Node(at));
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::{self, Changes};

    fn seen(nodes: &str) -> Seen {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.kin");
        let text = format!(
            "lang 1\nrender {{ resolution: (40, 20) }}\n\
            camera {{ position: (0, 0, 5), look_at: (0, 0, 0), fov: 40deg }}\nsky {{ color: #fff }}\n{nodes}"
        );
        std::fs::write(&path, &text).unwrap();
        let loaded = session::load(&path, &Changes::default()).unwrap();
        assert!(loaded.scene.is_some(), "{text}\n{:?}", loaded.diagnostics);
        let shutter = Shutter { open_s: 0.0, close_s: 0.0 };
        let sight = Sight { loaded: Arc::new(loaded), load: 1, shutter, view: None, size: [40, 20] };
        let mut renderer =
            Renderer::new(kinora_renderer::open(Choice::Cpu, Options { threads: 1, checks: false }).unwrap());
        look(&mut renderer, &sight, &|| true).unwrap()
    }

    #[test]
    fn a_pixel_knows_what_it_shows() {
        let seen = seen(
            "sphere a { radius: 50cm, position: (-1.5, 0, 0) }\n\
            group g { box b { position: (1.5, 0, -1) } }\n\
            instance c { of: g, position: (0, 0, -2), material: metal { color: #fff } }\n",
        );
        let name = |place| {
            let (part, depth) = seen.at(place)?;
            let Part::Node(node) = part else { return None };
            let scene = seen.sight.loaded.scene.as_deref()?;
            Some((scene.nodes[node].name.clone(), (depth * 10.0).round() / 10.0))
        };
        // The height shows 3.64 m at the origin, twice as much lies across.
        let x = |metres: f32, depth: f32| 0.5 + metres / (4.0 * depth * 20f32.to_radians().tan());
        assert_eq!(name([x(-1.5, 5.0), 0.5]).map(|seen| seen.0), Some("a".into()));
        assert_eq!(name([x(1.5, 5.5), 0.5]), Some(("b".into(), 5.5)));
        assert_eq!(name([0.5, 0.5]), None);
        assert_eq!(name([0.5, 1.5]), None);
        assert_eq!(name([f32::NAN, 0.5]), None);
    }

    #[test]
    fn what_is_chosen_has_an_outline() {
        let seen = seen("group g { sphere a { radius: 1m } }\nsphere far { radius: 1m, position: (0, 50, 0) }\n");
        let scene = seen.sight.loaded.scene.clone().unwrap();
        let chosen = with_children(&scene, &[Part::Node(0)]);
        assert_eq!(chosen.len(), 2);
        let image = seen.outline(&chosen).unwrap();
        let at = |x: usize, y: usize| image.pixels[y * 40 + x];
        assert_eq!((at(20, 10), at(0, 0)), (Color32::TRANSPARENT, Color32::TRANSPARENT));
        // The ball is as wide as 11 pixels: 1 m of 3.64 m, a little larger as it is near.
        assert!((13..=16).any(|x| at(x, 10) == LINE), "{:?}", (12..18).map(|x| at(x, 10)).collect::<Vec<_>>());
        let far = scene.nodes.iter().position(|node| node.name == "far").unwrap();
        assert_eq!(seen.outline(&with_children(&scene, &[Part::Node(far)])), None);
    }

    #[test]
    fn copies_are_their_instance() {
        let seen = seen(
            "sphere ball { radius: 50cm, position: (0, 9, 0) }\n\
            for i in 0..3 { instance row { of: ball, position: (1.5 * i - 1.5, -9, 0) } }\n",
        );
        let scene = seen.sight.loaded.scene.clone().unwrap();
        let names: Vec<Option<&str>> = [0.3, 0.5, 0.7]
            .map(|x| match seen.at([x, 0.5]) {
                Some((Part::Node(node), _)) => Some(&*scene.nodes[node].name),
                _ => None,
            })
            .into();
        assert_eq!(names, [Some("row"); 3]);
    }
}
