//! When a burst of file events is over.

use std::time::Duration;

/// Silence after which a file counts as written.
const QUIET: Duration = Duration::from_millis(20);
/// The longest a burst is waited for.
const PATIENCE: Duration = Duration::from_millis(200);

/// A burst of events. Times count from anywhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settle {
    first: Duration,
    last: Duration,
}

impl Settle {
    /// A burst that begins with an event at `now`.
    pub fn begin(now: Duration) -> Settle {
        Settle { first: now, last: now }
    }

    /// Another event.
    pub fn event(&mut self, now: Duration) {
        self.last = self.last.max(now);
    }

    /// When it began.
    pub fn begun(&self) -> Duration {
        self.first
    }

    /// When it is to be acted upon, if nothing else happens.
    pub fn due(&self) -> Duration {
        (self.last + QUIET).min(self.first + PATIENCE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // (times of events in ms, when they are acted upon)
    #[test]
    fn bursts() {
        let every_10: Vec<u64> = (0..100).map(|i| 1000 + 10 * i).collect();
        for (events, due) in
            [(vec![5], 25), (vec![5, 20], 40), (vec![5, 20, 39], 59), (vec![5, 3], 25), (every_10, 1200)]
        {
            let ms = Duration::from_millis;
            let mut settle = Settle::begin(ms(events[0]));
            events[1..].iter().for_each(|&event| settle.event(ms(event)));
            assert_eq!(settle.due(), ms(due), "{events:?}");
        }
    }
}
