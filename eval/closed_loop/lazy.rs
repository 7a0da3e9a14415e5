//! Values that many cells share: made by the first that asks, dropped after the last.

use std::sync::{Arc, Mutex, PoisonError};

/// A value made once and handed out a known number of times.
#[derive(Debug)]
pub(super) struct Shared<T> {
    state: Mutex<State<T>>,
}

#[derive(Debug)]
struct State<T> {
    value: Option<Arc<T>>,
    uses_left: usize,
}

impl<T> Shared<T> {
    /// A value that [`done`](Self::done) will be said of `uses` times.
    pub(super) fn new(uses: usize) -> Self {
        Self { state: Mutex::new(State { value: None, uses_left: uses }) }
    }

    /// The value, by `make` if there is none yet; whoever asks meanwhile waits.
    pub(super) fn get<E>(&self, make: impl FnOnce() -> Result<T, E>) -> Result<Arc<T>, E> {
        // A panic in `make` left no value behind: nothing is broken.
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(value) = &state.value {
            return Ok(Arc::clone(value));
        }
        let value = Arc::new(make()?);
        state.value = Some(Arc::clone(&value));
        Ok(value)
    }

    /// One use is over; with the last one the value goes.
    pub(super) fn done(&self) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.uses_left = state.uses_left.checked_sub(1).expect("no use ends twice");
        if state.uses_left == 0 {
            state.value = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    #[test]
    fn a_value_is_made_once_and_goes_after_its_last_use() {
        let made = Cell::new(0);
        let make = || {
            made.set(made.get() + 1);
            Ok::<_, ()>(7)
        };
        let shared = Shared::new(2);
        let first = shared.get(make).unwrap();
        shared.done();
        assert_eq!(*shared.get(make).unwrap(), 7);
        assert_eq!(made.get(), 1);
        shared.done();
        assert_eq!(Arc::strong_count(&first), 1);
        assert_eq!(shared.get(|| Err::<i32, _>("no")), Err("no"));
        let again = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| shared.done()));
        assert!(again.is_err(), "one use too many goes unnoticed");
    }
}
