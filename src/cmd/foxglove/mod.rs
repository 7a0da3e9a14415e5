//! What Foxglove shows without a plugin, in its own schemas, in JSON: the log of `dpn run --mcap`, and live by `--view`.
//!
//! | topic | type | what |
//! |---|---|---|
//! | `/tf` | `foxglove.FrameTransform` | `world` to `body` at every frame; in a log `truth` to `world`, yaw and position aligned, once |
//! | `/estimate`, `/truth` | `foxglove.PoseInFrame` | poses; truth in a log alone |
//! | `/estimate/path`, `/truth/path` | `foxglove.PosesInFrame` | in a log all of them, in the first message; live the way so far, thinned, once a second |
//! | `/camera/image`, `/camera/tracks` | `foxglove.CompressedImage`, `foxglove.ImageAnnotations` | an image now and then, and the points followed in it |
//! | `/sigma` | `dpn.Sigma` | noise in force \[m/s^2, rad/s\] |
//! | `/state` | `dpn.State` | velocity, biases, believed deviations of the pose and the scale, levels, live the time from image to pose |

mod log;
mod messages;
#[cfg(feature = "view")]
mod view;

pub(super) use log::RunLog;
pub(super) use messages::Onlooker;
#[cfg(feature = "rerun")]
pub(super) use messages::is_due;

#[cfg(not(feature = "view"))]
use crate::ui::refuse;
use anyhow::Result;
use std::net::SocketAddr;

/// Serves viewers where `--view` says so.
///
/// # Errors
/// A program without it; an address that is taken.
pub(super) fn onlooker(address: Option<SocketAddr>) -> Result<Option<Box<dyn Onlooker>>> {
    let Some(address) = address else { return Ok(None) };
    #[cfg(feature = "view")]
    return Ok(Some(Box::new(view::View::open(address)?)));
    #[cfg(not(feature = "view"))]
    refuse(
        format!("this dpn was built without what --view={address} needs"),
        "take a release's, or build it with the feature: cargo install --path . --locked --features view",
    )
}
