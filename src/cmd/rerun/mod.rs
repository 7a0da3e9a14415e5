//! `--rerun`: recordings for the viewer of rerun.io, on one time line, `time`, in seconds since the first sample.
//!
//! | entity | what |
//! |---|---|
//! | `truth`, `truth/path` | the true body and its way |
//! | `estimate` | the odometry's world; it lies in the truth's by its yaw and position |
//! | `estimate/body`, `estimate/path`, `estimate/landmarks` | newest pose, way, points of known depth |
//! | `estimate/three_sigma` | ellipsoid of the position's three deviations, where covariances are asked for |
//! | `estimate/body/camera`, `.../image`, `.../image/tracks` | the camera, what it sees, the tracks |
//! | `noise`, `sample`, `bias`, `level` | over time, an axis a line |
//!
//! The SDK is large and behind the Cargo feature `rerun`.

#[cfg(feature = "rerun")]
mod log;
#[cfg(feature = "rerun")]
mod noise;
#[cfg(feature = "rerun")]
mod run;

#[cfg(feature = "rerun")]
pub(super) use {noise::noise, run::RunScene};

use crate::ui::refuse;
use anyhow::Result;
use std::path::Path;

/// Refuses the flag in a program that was built without the SDK.
pub(super) fn check(flag: Option<&Path>) -> Result<()> {
    if cfg!(feature = "rerun") || flag.is_none() {
        return Ok(());
    }
    let text = "this dpn was built without the SDK that --rerun needs";
    refuse(text, "build it with the feature: cargo install --path . --locked --features rerun")
}
