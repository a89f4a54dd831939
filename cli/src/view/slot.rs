//! A letter box that holds one letter: a newer one replaces it. This is how the window and the render thread talk.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Room for one value.
pub struct Slot<T> {
    inner: Mutex<Inner<T>>,
    changed: Condvar,
}

struct Inner<T> {
    value: Option<T>,
    closed: bool,
}

impl<T> Default for Slot<T> {
    fn default() -> Self {
        Self { inner: Mutex::new(Inner { value: None, closed: false }), changed: Condvar::new() }
    }
}

impl<T> Slot<T> {
    /// Puts `value` in the place of whatever was there.
    pub fn put(&self, value: T) {
        self.lock().value = Some(value);
        self.changed.notify_all();
    }

    /// Takes what is there.
    pub fn take(&self) -> Option<T> {
        self.lock().value.take()
    }

    /// Waits for a value and takes it; none once the slot is closed.
    pub fn wait(&self) -> Option<T> {
        let waiting = |inner: &mut Inner<T>| inner.value.is_none() && !inner.closed;
        let mut inner = self.changed.wait_while(self.lock(), waiting).unwrap_or_else(PoisonError::into_inner);
        if inner.closed { None } else { inner.value.take() }
    }

    /// Whether something is there, or nothing will come any more.
    pub fn calls(&self) -> bool {
        let inner = self.lock();
        inner.value.is_some() || inner.closed
    }

    /// Whether nothing will come any more.
    pub fn closed(&self) -> bool {
        self.lock().closed
    }

    /// Ends every waiting, now and later.
    pub fn close(&self) {
        self.lock().closed = true;
        self.changed.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, Inner<T>> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_wins_and_closing_ends() {
        let slot = Slot::default();
        assert!(!slot.calls());
        slot.put(1);
        slot.put(2);
        assert!(slot.calls());
        assert_eq!((slot.wait(), slot.take()), (Some(2), None));
        std::thread::scope(|scope| {
            let waiting = scope.spawn(|| slot.wait());
            slot.close();
            assert_eq!(waiting.join().unwrap(), None);
        });
        assert!(slot.calls() && slot.closed());
    }
}
