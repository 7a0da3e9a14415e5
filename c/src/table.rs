//! Objects by number. Numbers are given once, over all kinds: one that was freed, or is another kind's, is unknown.

use crate::status::{Fault, Status};
use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

/// A trained network.
pub type WeightsHandle = u64;
/// Two networks on a stream of samples.
pub type StreamHandle = u64;
/// A level that is learned from residuals.
pub type LevelHandle = u64;
/// A gyroscope's bias that a network learns.
pub type GyroBiasHandle = u64;
/// A visual-inertial odometry.
pub type OdometryHandle = u64;

static NEXT: AtomicU64 = AtomicU64::new(1);

/// All objects of a kind.
pub(crate) struct Table<T> {
    /// As the argument is called.
    name: &'static str,
    all: LazyLock<Mutex<HashMap<u64, Arc<Mutex<T>>>>>,
}

impl<T> Table<T> {
    pub(crate) const fn new(name: &'static str) -> Self {
        Self { name, all: LazyLock::new(|| Mutex::new(HashMap::new())) }
    }

    pub(crate) fn put(&self, object: T) -> u64 {
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        self.lock().insert(number, Arc::new(Mutex::new(object)));
        number
    }

    /// Works on an object; two threads take turns.
    pub(crate) fn with<R>(
        &self,
        number: u64,
        work: impl FnOnce(&mut T) -> Result<R, Fault>,
    ) -> Result<R, Fault> {
        let object = self.lock().get(&number).cloned().ok_or_else(|| self.unknown(number))?;
        // A panic in it was reported; what it left is safe, if not right.
        work(&mut object.lock().unwrap_or_else(PoisonError::into_inner))
    }

    pub(crate) fn free(&self, number: u64) -> Result<(), Fault> {
        self.lock().remove(&number).map(drop).ok_or_else(|| self.unknown(number))
    }

    fn unknown(&self, number: u64) -> Fault {
        let name = self.name;
        let words = format!("`{name}` is {number}; expected a dpn_{name} that was made and not freed yet");
        Fault(Status::UnknownHandle, words)
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, HashMap<u64, Arc<Mutex<T>>>> {
        self.all.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
