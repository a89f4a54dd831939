//! The state of the viewer, without its window: scene, findings, playhead and camera.

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec3;
use kinora_scene::Scene;

use super::compare::{moves, same_camera};
use super::orbit::{self, Orbit};
use super::panels::look::Sight;
use super::picture::{Looking, Zoom};
use super::timeline::Timeline;
use super::work::Job;
use crate::session::Loaded;

/// After the last change by hand the picture counts as still.
const STILL_AFTER: Duration = Duration::from_millis(150);
/// How long a toast stays.
const TOAST: Duration = Duration::from_secs(4);

/// What was found in the text.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Findings {
    /// The errors, with the lines that they are in.
    pub text: String,
    /// How many they are.
    pub errors: usize,
    /// And the warnings.
    pub warnings: usize,
}

/// What a drag over the picture does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gesture {
    /// Turns about the pivot: to the right and down, in heights of the picture.
    Turn([f64; 2]),
    /// Moves across the picture, likewise.
    Pan([f64; 2]),
    /// Changes the distance to the pivot by this factor.
    Dolly(f64),
    /// Looks around, likewise.
    Look([f64; 2]),
    /// Flies to the right, up and forward, in distances to the pivot.
    Fly([f64; 3]),
}

/// The state.
#[derive(Default)]
pub struct Model {
    /// The last text that made a scene.
    pub good: Option<Arc<Loaded>>,
    /// What was found in the text as it is now.
    pub findings: Findings,
    /// Why that scene cannot be rendered as it is asked for.
    pub trouble: Option<String>,
    /// The playhead.
    pub timeline: Timeline,
    /// The camera, once the user has moved it.
    pub orbit: Option<Orbit>,
    /// How the picture is looked at.
    pub looking: Looking,
    /// How large it is.
    pub zoom: Zoom,
    /// Whether the next drag over it chooses the part that is rendered.
    pub choosing: bool,
    /// How many scenes were taken.
    pub loads: u64,
    toast: Option<(&'static str, Instant)>,
    /// Since when the picture no longer is what is wanted.
    stale: bool,
    still_at: Option<Instant>,
}

impl Model {
    /// Takes what came of reading the text. True if that is a scene.
    pub fn take(&mut self, loaded: Option<Arc<Loaded>>, findings: Findings, now: Instant) -> bool {
        self.findings = findings;
        let Some(loaded) = loaded else { return false };
        let Some(scene) = &loaded.scene else { return false };
        let camera_stays = self.scene().is_none_or(|old| same_camera(old, scene));
        if !camera_stays && self.orbit.take().is_some() {
            self.toast = Some(("The camera changed in the text: the view follows it", now));
        }
        self.timeline.take(scene.clock, moves(scene));
        self.good = Some(loaded);
        self.trouble = None;
        self.loads += 1;
        self.stale = true;
        true
    }

    /// Moves the camera by hand.
    pub fn gesture(&mut self, gesture: Gesture, now: Instant) {
        self.edit_view(
            |orbit| match gesture {
                Gesture::Turn(drag) => orbit.turn(drag),
                Gesture::Pan(drag) => orbit.pan(drag),
                Gesture::Dolly(factor) => orbit.dolly(factor),
                Gesture::Look(drag) => orbit.look(drag),
                Gesture::Fly(way) => orbit.fly(DVec3::from_array(way) * orbit.distance_m),
            },
            now,
        );
    }

    /// Changes the camera by hand, from wherever it is.
    pub fn edit_view(&mut self, edit: impl FnOnce(&mut Orbit), now: Instant) {
        if self.orbit.is_none() {
            self.orbit = self.scene().and_then(|scene| orbit::begin(scene, self.timeline.shutter()));
        }
        let Some(orbit) = &mut self.orbit else { return };
        edit(orbit);
        self.touched(now);
    }

    /// Looks at the picture in another way.
    pub fn look(&mut self, looking: Looking) {
        self.stale |= self.looking != looking;
        self.looking = looking;
    }

    /// What a picture of that size would show now.
    pub fn sight(&self, size: [u32; 2]) -> Option<Sight> {
        let loaded = self.good.clone()?;
        let view = self.orbit.as_ref().map(|orbit| orbit.view.clone());
        Some(Sight { loaded, load: self.loads, shutter: self.timeline.shutter(), view, size })
    }

    /// Whether another picture will be wanted soon.
    pub fn is_moving(&self, now: Instant) -> bool {
        self.timeline.playing || self.still_at.is_some_and(|at| now < at)
    }

    /// The picture is to be made once more, by whatever renders.
    pub fn restart(&mut self) {
        self.stale = true;
    }

    /// Takes the scene with where bodies are as far as that is known now.
    pub fn extend(&mut self, loaded: Arc<Loaded>, baked_s: f64) {
        // Until now bodies rested there.
        if self.timeline.baked_s.is_some_and(|known_s| self.timeline.frame_s() >= known_s) {
            self.loads += 1;
            self.stale = true;
        }
        self.timeline.baked_s = Some(baked_s);
        self.good = Some(loaded);
    }

    /// Forgets where the last scene was looked at from, and when: another one comes.
    pub fn forget(&mut self) {
        self.orbit = None;
        (self.looking, self.zoom, self.choosing) = Default::default();
        let mut timeline = Timeline::default();
        (timeline.looping, timeline.speed) = (self.timeline.looping, self.timeline.speed);
        self.timeline = timeline;
        (self.good, self.trouble) = (None, None);
    }

    /// Goes back to the scene's own camera.
    pub fn reset_view(&mut self) {
        self.stale |= self.orbit.take().is_some();
    }

    /// Chooses a frame by hand.
    pub fn seek(&mut self, frame: i64, now: Instant) {
        let frame = frame.clamp(0, self.timeline.last_frame());
        if frame != self.timeline.frame() {
            self.timeline.seek(frame);
            self.touched(now);
        }
    }

    /// Lets time pass while it plays; `seen_s` is when the shutter of the picture on the screen opens.
    pub fn pass(&mut self, seconds: f64, seen_s: Option<f64>, now: Instant) {
        let seen = seen_s == Some(self.timeline.shutter().open_s);
        if self.timeline.pass(seconds, seen) {
            self.touched(now);
        }
    }

    /// What is to be said for a while.
    pub fn toast(&self, now: Instant) -> Option<&'static str> {
        self.toast.filter(|(_, since)| now.duration_since(*since) < TOAST).map(|(text, _)| text)
    }

    /// What is to be rendered, if that is not at work already.
    pub fn job(&mut self, max_side: u32, now: Instant) -> Option<Job> {
        let loaded = self.good.clone()?;
        let moving = self.is_moving(now);
        // A preview made while things moved is followed by the full picture.
        let settled = !moving && self.still_at.take().is_some();
        if !std::mem::take(&mut self.stale) && !settled {
            return None;
        }
        let view = self.orbit.as_ref().map(|orbit| orbit.view.clone());
        let (shutter, looking) = (self.timeline.shutter(), self.looking.clone());
        Some(Job { loaded, shutter, view, looking, moving, max_side, load: self.loads })
    }

    /// How long nothing needs to happen: until the picture counts as still, the next frame is due or a toast goes.
    pub fn idle(&self, now: Instant) -> Option<Duration> {
        let still = self.still_at.map(|at| at.saturating_duration_since(now));
        let play = self.timeline.playing.then(|| Duration::from_millis(15));
        let toast = self.toast(now).and(self.toast).map(|(_, since)| (since + TOAST).saturating_duration_since(now));
        [still, play, toast].into_iter().flatten().min()
    }

    fn scene(&self) -> Option<&Scene> {
        self.good.as_ref()?.scene.as_deref()
    }

    fn touched(&mut self, now: Instant) {
        self.stale = true;
        self.still_at = Some(now + STILL_AFTER);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;
    use crate::session::{self, Changes};
    use crate::view::timeline::Speed;

    const TEXT: &str = "lang 1\nrender { duration: 2s, fps: 10 }\n\
        camera { position: (0, 0, 5), look_at: (0, 0, 0) }\nsphere {}\nsky { color: #ffffff }\n";

    fn loaded(text: &str) -> Option<Arc<Loaded>> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!("kinora-model-{}-{}.kin", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(name);
        std::fs::write(&path, text).unwrap();
        let loaded = session::load(&path, &Changes::default());
        std::fs::remove_file(&path).unwrap();
        loaded.ok().map(Arc::new)
    }

    fn broken() -> Findings {
        Findings { text: "error".into(), errors: 1, warnings: 0 }
    }

    #[test]
    fn an_error_leaves_the_last_good_scene() {
        let now = Instant::now();
        let mut model = Model::default();
        assert!(!model.take(loaded("sphere {"), broken(), now));
        assert!(model.job(100, now).is_none());
        assert!(model.take(loaded(TEXT), Findings::default(), now));
        assert!(model.job(100, now).is_some_and(|job| !job.moving && job.load == 1));
        assert!(!model.take(loaded("sphere {"), broken(), now));
        assert!(model.good.is_some() && model.findings.errors == 1);
        assert!(model.job(100, now).is_none(), "what is rendered stays");
    }

    #[test]
    fn a_gesture_moves_until_it_rests() {
        let now = Instant::now();
        let mut model = Model::default();
        model.gesture(Gesture::Dolly(2.0), now);
        assert!(model.orbit.is_none(), "there is no scene to move in");
        assert!(model.take(loaded(TEXT), Findings::default(), now));
        model.job(100, now);
        model.gesture(Gesture::Dolly(2.0), now);
        let eye = model.job(100, now).and_then(|job| job.moving.then_some(job.view?.world_from_camera.translation));
        assert_eq!(eye.map(|eye| eye.z), Some(10.0));
        assert!(model.job(100, now).is_none());
        assert_eq!(model.idle(now), Some(STILL_AFTER));
        assert!(model.job(100, now + STILL_AFTER).is_some_and(|job| !job.moving && job.view.is_some()));
        assert_eq!(model.idle(now + STILL_AFTER), None);
        model.reset_view();
        assert!(model.job(100, now + STILL_AFTER).is_some_and(|job| job.view.is_none()));
    }

    #[test]
    fn the_view_is_kept_until_the_camera_changes_in_the_text() {
        let now = Instant::now();
        let mut model = Model::default();
        assert!(model.take(loaded(TEXT), Findings::default(), now));
        model.gesture(Gesture::Turn([0.1, 0.1]), now);
        model.take(loaded(&TEXT.replace("#ffffff", "#ff0000")), Findings::default(), now);
        assert!(model.orbit.is_some() && model.toast(now).is_none());
        model.take(loaded(&TEXT.replace("(0, 0, 5)", "(0, 0, 6)")), Findings::default(), now);
        assert!(model.orbit.is_none() && model.toast(now).is_some());
        assert!(model.toast(now + TOAST).is_none());
    }

    #[test]
    fn playing_asks_for_frames() {
        let now = Instant::now();
        let mut model = Model::default();
        assert!(model.take(loaded(TEXT), Findings::default(), now));
        model.job(100, now);
        model.timeline.playing = true;
        model.pass(0.05, None, now);
        assert!(model.job(100, now).is_none(), "the same frame");
        model.pass(0.06, None, now);
        assert!(model.job(100, now).is_some_and(|job| job.moving && job.shutter.open_s == 0.1));
        model.seek(7, now);
        assert!(model.job(100, now).is_some_and(|job| job.shutter.open_s == 0.7));
        model.timeline.speed = Speed::EveryFrame;
        model.pass(0.1, Some(0.6), now);
        assert_eq!(model.timeline.frame(), 7, "its picture is not there yet");
        model.pass(0.1, Some(0.7), now);
        assert_eq!(model.timeline.frame(), 8);
    }

    #[test]
    fn what_is_computed_meanwhile_is_shown_where_it_is_new() {
        let now = Instant::now();
        let mut model = Model::default();
        assert!(model.take(loaded(TEXT), Findings::default(), now));
        model.timeline.baked_s = Some(0.5);
        model.job(100, now);
        model.extend(loaded(TEXT).unwrap(), 1.0);
        assert!(model.job(100, now).is_none(), "it was there already");
        model.seek(15, now);
        assert!(model.job(100, now).is_some());
        model.job(100, now + STILL_AFTER);
        model.extend(loaded(TEXT).unwrap(), 1.6);
        assert!(model.job(100, now + STILL_AFTER).is_some());
        assert_eq!(model.timeline.baked_s, Some(1.6));
    }
}
