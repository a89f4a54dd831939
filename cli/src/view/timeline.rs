//! The playhead.

use kinora_scene::{Clock, Shutter};

/// What the slider covers, in seconds, where things move but no duration is said.
const OPEN_LENGTH_S: f64 = 10.0;

/// How frames follow each other while it plays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Speed {
    /// A second takes a second; frames that cannot be shown in time are left out.
    #[default]
    RealTime,
    /// Each frame is shown before the next one.
    EveryFrame,
}

/// Where in time the viewer is, and whether it goes on by itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Timeline {
    clock: Clock,
    moves: bool,
    time_s: f64,
    /// Whether time passes.
    pub playing: bool,
    /// Whether it goes on at the start from the end, or stays there.
    pub looping: bool,
    /// How it plays.
    pub speed: Speed,
    /// The first and the last frame that it plays, where those are not all.
    range: Option<[i64; 2]>,
    /// How far it is known where bodies are, in seconds, while that is being computed.
    pub baked_s: Option<f64>,
}

impl Default for Timeline {
    fn default() -> Self {
        Self {
            clock: Clock::default(),
            moves: false,
            time_s: 0.0,
            playing: false,
            looping: true,
            speed: Speed::RealTime,
            range: None,
            baked_s: None,
        }
    }
}

impl Timeline {
    /// Takes the clock of another scene; `moves`: whether anything in it depends on time. Keeps the time as far as the
    /// new clock goes, the range likewise, and whether it plays.
    pub fn take(&mut self, clock: Clock, moves: bool) {
        let of_range = self.range.map(|range| range.map(|frame| frame as f64 / self.clock.fps));
        (self.clock, self.moves) = (clock, moves);
        self.time_s = self.time_s.min(self.last_frame() as f64 / clock.fps);
        self.playing &= self.shown();
        self.range = None;
        match of_range.map(|range| range.map(|time| self.frame_at(time))) {
            // Of a range that lies beyond the new end nothing is left.
            Some([first, last]) if first < last => self.set_range(first, last),
            _ => {}
        }
    }

    /// Whether there is a choice of times at all.
    pub fn shown(&self) -> bool {
        self.moves || self.clock.duration_s > 0.0
    }

    /// Frames a second.
    pub fn fps(&self) -> f64 {
        self.clock.fps
    }

    /// The last frame that can be chosen.
    pub fn last_frame(&self) -> i64 {
        let open = Clock { duration_s: OPEN_LENGTH_S, ..self.clock };
        let clock = if self.clock.duration_s > 0.0 || !self.moves { self.clock } else { open };
        clock.frame_count() - 1
    }

    /// The first and the last frame that it plays.
    pub fn range(&self) -> [i64; 2] {
        self.range.unwrap_or([0, self.last_frame()])
    }

    /// Whether it plays a part only.
    pub fn has_range(&self) -> bool {
        self.range.is_some()
    }

    /// Plays from `first` to `last` only, in whichever order they are given.
    pub fn set_range(&mut self, first: i64, last: i64) {
        let end = self.last_frame();
        let [first, last] = [first.min(last).clamp(0, end), first.max(last).clamp(0, end)];
        self.range = ([first, last] != [0, end]).then_some([first, last]);
    }

    /// Plays all of it.
    pub fn clear_range(&mut self) {
        self.range = None;
    }

    fn frame_at(&self, time_s: f64) -> i64 {
        ((time_s * self.clock.fps + 1e-6).floor() as i64).clamp(0, self.last_frame())
    }

    /// The frame at the playhead.
    pub fn frame(&self) -> i64 {
        self.frame_at(self.time_s)
    }

    /// The time of that frame in seconds.
    pub fn frame_s(&self) -> f64 {
        self.frame() as f64 / self.clock.fps
    }

    /// The shutter of that frame.
    pub fn shutter(&self) -> Shutter {
        self.clock.shutter_of(self.frame())
    }

    /// Puts the playhead on a frame.
    pub fn seek(&mut self, frame: i64) {
        self.time_s = frame.clamp(0, self.last_frame()) as f64 / self.clock.fps;
    }

    /// Begins to play or ends it. From the end of what is played once it begins anew.
    pub fn toggle(&mut self) {
        self.playing = !self.playing && self.shown();
        let [first, last] = self.range();
        if self.playing && !self.looping && self.frame() >= last {
            self.seek(first);
        }
    }

    /// Lets `seconds` pass, if it plays; `seen`: whether the frame at the playhead is on the screen. From the end it goes on
    /// at the start, or stops. True if another frame is reached.
    pub fn pass(&mut self, seconds: f64, seen: bool) -> bool {
        if !self.playing || (self.speed == Speed::EveryFrame && !seen) {
            return false;
        }
        let before = self.frame();
        let [first, last] = self.range();
        let frame_s = 1.0 / self.clock.fps;
        let (start_s, end_s) = (first as f64 * frame_s, (last + 1) as f64 * frame_s);
        let next_s = match self.speed {
            Speed::RealTime => self.time_s + seconds.max(0.0),
            // No faster than the clock says, however fast pictures come.
            Speed::EveryFrame => self.time_s + seconds.max(0.0).min(frame_s),
        };
        // As near to a frame as it counts as that frame.
        let near_s = next_s + 1e-6 * frame_s;
        let outside = !(start_s..end_s).contains(&near_s);
        if outside && !self.looping && near_s >= end_s {
            self.seek(last);
            self.playing = false;
        } else if outside {
            self.time_s = start_s + (near_s - start_s).rem_euclid(end_s - start_s);
        } else {
            self.time_s = next_s;
        }
        self.frame() != before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(duration_s: f64, fps: f64, moves: bool) -> Timeline {
        let mut timeline = Timeline::default();
        timeline.take(Clock { fps, duration_s, shutter: 0.5 }, moves);
        timeline
    }

    #[test]
    fn shown_where_there_is_something_to_choose() {
        for (duration_s, moves, shown, last) in
            [(0.0, false, false, 0), (0.0, true, true, 239), (2.0, false, true, 47), (2.0, true, true, 47)]
        {
            let timeline = of(duration_s, 24.0, moves);
            assert_eq!((timeline.shown(), timeline.last_frame()), (shown, last), "{duration_s} {moves}");
        }
    }

    #[test]
    fn playing_loops_over_whole_frames() {
        let mut timeline = of(2.0, 10.0, true);
        assert!(!timeline.pass(1.0, true));
        timeline.toggle();
        assert!(!timeline.pass(0.05, true));
        assert!(timeline.pass(0.06, false));
        assert_eq!((timeline.frame(), timeline.frame_s()), (1, 0.1));
        assert_eq!(timeline.shutter(), Shutter { open_s: 0.1, close_s: 0.1 + 0.05 });
        timeline.pass(2.0, true);
        assert_eq!(timeline.frame(), 1);
    }

    #[test]
    fn played_once_it_stays_at_the_end_and_begins_anew() {
        let mut timeline = of(2.0, 10.0, true);
        timeline.looping = false;
        timeline.toggle();
        for _ in 0..30 {
            timeline.pass(0.1, true);
        }
        assert_eq!((timeline.frame(), timeline.playing), (19, false));
        timeline.toggle();
        assert_eq!((timeline.frame(), timeline.playing), (0, true));
    }

    #[test]
    fn a_range_is_played_alone() {
        let mut timeline = of(2.0, 10.0, true);
        timeline.set_range(8, 5);
        timeline.toggle();
        let mut seen = Vec::new();
        for _ in 0..8 {
            timeline.pass(0.1, true);
            seen.push(timeline.frame());
        }
        // From outside it comes in at once.
        assert!(seen.iter().all(|frame| (5..=8).contains(frame)), "{seen:?}");
        assert!((5..=8).all(|frame| seen.contains(&frame)), "{seen:?}");
        timeline.set_range(-5, 100);
        assert!(!timeline.has_range());
    }

    #[test]
    fn every_frame_waits_for_its_picture() {
        let mut timeline = of(2.0, 10.0, true);
        timeline.speed = Speed::EveryFrame;
        timeline.toggle();
        assert!(!timeline.pass(5.0, false));
        for frame in 1..=19 {
            assert!(timeline.pass(5.0, true));
            assert_eq!(timeline.frame(), frame);
        }
        assert!(timeline.pass(5.0, true));
        assert_eq!(timeline.frame(), 0);
    }

    #[test]
    fn every_frame_is_found_again() {
        let mut timeline = of(10.0, 30000.0 / 1001.0, true);
        for frame in 0..=timeline.last_frame() {
            timeline.seek(frame);
            assert_eq!(timeline.frame(), frame);
        }
        timeline.seek(100_000);
        assert_eq!(timeline.frame(), timeline.last_frame());
    }

    #[test]
    fn a_reload_keeps_the_time() {
        let mut timeline = of(4.0, 24.0, true);
        timeline.seek(72);
        timeline.set_range(24, 72);
        timeline.toggle();
        timeline.take(Clock { fps: 12.0, duration_s: 4.0, shutter: 0.0 }, true);
        assert_eq!((timeline.frame(), timeline.playing, timeline.range()), (36, true, [12, 36]));
        timeline.take(Clock { fps: 12.0, duration_s: 1.0, shutter: 0.0 }, true);
        assert_eq!((timeline.frame(), timeline.playing, timeline.range()), (11, true, [0, 11]));
        timeline.take(Clock { fps: 12.0, duration_s: 0.0, shutter: 0.0 }, false);
        assert_eq!((timeline.frame(), timeline.playing), (0, false));
    }
}
