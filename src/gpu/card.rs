//! A card: how it is found, what it is called, and the one thread that gives it work.
//!
//! Trainings run on threads of their own and hand in steps; those of one shape that wait at the same time go to the card in one launch, a network a row of workgroups.
//! A network's numbers do not depend on who went with it.

use crate::engine::{Engine, Steps, Wanted};
use crate::error::GpuError;
use cubecl::wgpu::{AutoGraphicsApi, RuntimeOptions, WgpuDevice, try_init_setup};
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

/// How long the card waits for trainings that have not handed in anything yet.
const PATIENCE: Duration = Duration::from_millis(5);

/// A card and the thread that gives it work.
#[derive(Clone)]
pub struct Gpu {
    adapter: Arc<str>,
    wanted: Arc<Mutex<Sender<Wanted>>>,
    /// Trainings that may hand in steps.
    pub(crate) trainings: Arc<AtomicUsize>,
}

impl fmt::Debug for Gpu {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Gpu").field(&self.adapter).finish()
    }
}

impl Gpu {
    /// The first card that wgpu finds, a software driver where there is nothing else: one a process.
    ///
    /// # Errors
    /// No adapter; one that gives no device.
    pub fn open() -> Result<Self, GpuError> {
        static CARD: OnceLock<Result<Gpu, GpuError>> = OnceLock::new();
        CARD.get_or_init(Self::first).clone()
    }

    fn first() -> Result<Self, GpuError> {
        let failed = |error: &dyn fmt::Display| GpuError::None { reason: error.to_string() };
        let options = RuntimeOptions::try_default().map_err(|error| failed(&error))?;
        let device = WgpuDevice::default();
        let setup = try_init_setup::<AutoGraphicsApi>(&device, options).map_err(|error| failed(&error))?;
        let info = setup.adapter.get_info();
        let adapter: Arc<str> =
            format!("{} ({}, {} {})", info.name, info.backend, info.driver, info.driver_info).into();
        let engine = Engine::new(cubecl::Device::Wgpu(device).client(), Arc::clone(&adapter));
        let (wanted, waiting) = channel();
        let trainings = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&trainings);
        std::thread::spawn(move || serve(&engine, &waiting, &counted));
        Ok(Self { adapter, wanted: Arc::new(Mutex::new(wanted)), trainings })
    }

    /// Name of the card, its interface and its driver.
    pub fn adapter(&self) -> &str {
        &self.adapter
    }

    pub(crate) fn want(&self, wanted: Wanted) -> Result<(), GpuError> {
        let sender = self.wanted.lock().unwrap_or_else(PoisonError::into_inner);
        sender.send(wanted).map_err(|_| self.lost())
    }

    pub(crate) fn lost(&self) -> GpuError {
        GpuError::Failed { adapter: self.adapter.to_string(), reason: "its driver gave up".into() }
    }
}

/// Works off what is handed in until nobody is left who could.
fn serve(engine: &Engine, waiting: &Receiver<Wanted>, trainings: &AtomicUsize) {
    let mut held: Vec<Steps> = Vec::new();
    loop {
        let next = if held.is_empty() {
            waiting.recv().map_err(|_| RecvTimeoutError::Disconnected)
        } else {
            waiting.recv_timeout(PATIENCE)
        };
        match next {
            Ok(Wanted::Answers(asked)) => {
                let said = guarded(engine, || engine.answers(&asked));
                // Nobody waits any more.
                let _ = asked.reply.send(said);
                continue;
            }
            Ok(Wanted::Steps(steps)) => {
                held.push(*steps);
                if held.len() < trainings.load(Ordering::Relaxed) {
                    continue;
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
        while let Some(first) = held.first() {
            let same = first.alike();
            let gang: Vec<Steps> = held.extract_if(.., |steps| steps.alike() == same).collect();
            let done = guarded(engine, || engine.steps(&gang));
            match done {
                Ok(done) => {
                    for (steps, done) in gang.iter().zip(done) {
                        let _ = steps.reply.send(Ok(done));
                    }
                }
                Err(error) => {
                    for steps in &gang {
                        let _ = steps.reply.send(Err(error.clone()));
                    }
                }
            }
        }
    }
}

/// A driver that panics has failed.
fn guarded<T>(engine: &Engine, work: impl FnOnce() -> Result<T, GpuError>) -> Result<T, GpuError> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let said = panic
            .downcast_ref::<String>()
            .map(String::as_str)
            .or_else(|| panic.downcast_ref::<&str>().copied());
        Err(engine.failed(&said.unwrap_or("its driver gave up")))
    })
}
