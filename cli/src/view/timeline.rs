//! The playhead.

use kinora_scene::{Clock, Shutter};

/// What the slider covers, in seconds, where things move but no duration is said.
const OPEN_LENGTH_S: f64 = 10.0;

/// Where in time the viewer is, and whether it goes on by itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Timeline {
    clock: Clock,
    moves: bool,
    time_s: f64,
    /// Whether time passes.
    pub playing: bool,
}

impl Default for Timeline {
    fn default() -> Self {
        Self { clock: Clock::default(), moves: false, time_s: 0.0, playing: false }
    }
}

impl Timeline {
    /// Takes the clock of another scene; `moves`: whether anything in it depends on time. Keeps the time as far as the
    /// new clock goes, and whether it plays.
    pub fn take(&mut self, clock: Clock, moves: bool) {
        (self.clock, self.moves) = (clock, moves);
        self.time_s = self.time_s.min(self.last_frame() as f64 / clock.fps);
        self.playing &= self.shown();
    }

    /// Whether there is a choice of times at all.
    pub fn shown(&self) -> bool {
        self.moves || self.clock.duration_s > 0.0
    }

    /// The last frame that can be chosen.
    pub fn last_frame(&self) -> i64 {
        let open = Clock { duration_s: OPEN_LENGTH_S, ..self.clock };
        let clock = if self.clock.duration_s > 0.0 || !self.moves { self.clock } else { open };
        clock.frame_count() - 1
    }

    /// The frame at the playhead.
    pub fn frame(&self) -> i64 {
        ((self.time_s * self.clock.fps + 1e-6).floor() as i64).clamp(0, self.last_frame())
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

    /// Lets `seconds` pass, if it plays; from the end it goes on at the start. True if another frame is reached.
    pub fn pass(&mut self, seconds: f64) -> bool {
        if !self.playing {
            return false;
        }
        let before = self.frame();
        let length_s = (self.last_frame() + 1) as f64 / self.clock.fps;
        self.time_s = (self.time_s + seconds.max(0.0)).rem_euclid(length_s);
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
        assert!(!timeline.pass(1.0));
        timeline.playing = true;
        assert!(!timeline.pass(0.05));
        assert!(timeline.pass(0.06));
        assert_eq!((timeline.frame(), timeline.frame_s()), (1, 0.1));
        assert_eq!(timeline.shutter(), Shutter { open_s: 0.1, close_s: 0.1 + 0.05 });
        timeline.pass(2.0);
        assert_eq!(timeline.frame(), 1);
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
        timeline.playing = true;
        timeline.take(Clock { fps: 12.0, duration_s: 4.0, shutter: 0.0 }, true);
        assert_eq!((timeline.frame(), timeline.playing), (36, true));
        timeline.take(Clock { fps: 12.0, duration_s: 1.0, shutter: 0.0 }, true);
        assert_eq!((timeline.frame(), timeline.playing), (11, true));
        timeline.take(Clock { fps: 12.0, duration_s: 0.0, shutter: 0.0 }, false);
        assert_eq!((timeline.frame(), timeline.playing), (0, false));
    }
}
