//! How much work a dispatch gets, so that each takes about as long as another.

/// What a dispatch should take, in seconds.
const DISPATCH_S: f64 = 0.05;

/// Learns how fast a device is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    work: f64,
}

impl Default for Pace {
    fn default() -> Self {
        Self { work: 16384.0 }
    }
}

impl Pace {
    /// Samples of pixels that the next dispatch should have.
    pub fn work(&self) -> f64 {
        self.work
    }

    /// A dispatch of `work` samples took so long.
    pub fn took(&mut self, work: f64, seconds: f64) {
        // One dispatch says little, the first least: it waits for the compiler.
        let target = work * DISPATCH_S / seconds.max(1e-6);
        self.work = target.clamp(self.work * 0.5, self.work * 2.0).clamp(1024.0, 1e9);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // A device that does `speed` samples a second after a first dispatch of `compile_s`: dispatches until it is paced.
    fn check(speed: f64, compile_s: f64, expected: usize) {
        let mut pace = Pace::default();
        pace.took(pace.work(), compile_s + pace.work() / speed);
        let paced = (1..100).find(|_| {
            let seconds = pace.work() / speed;
            pace.took(pace.work(), seconds);
            (DISPATCH_S * 0.8..DISPATCH_S * 1.25).contains(&seconds)
        });
        assert_eq!(paced, Some(expected), "{speed} samples a second");
    }

    #[test]
    fn settles() {
        check(3e5, 0.0, 1);
        check(3e5, 3.0, 2);
        check(1e9, 3.0, 14);
        check(2e4, 3.0, 4);
    }

    #[test]
    fn stays_within_bounds() {
        let mut pace = Pace::default();
        for _ in 0..100 {
            pace.took(pace.work(), 1e9);
        }
        assert_eq!(pace.work(), 1024.0);
        for _ in 0..100 {
            pace.took(pace.work(), 0.0);
        }
        assert_eq!(pace.work(), 1e9);
    }
}
