//! Camera tracks along any trajectory: what a tracker would have seen, with its errors, so that a recorded or simulated IMU gets a
//! camera beside it.
//!
//! * A [`CameraPath`] says where the body is: [`RecordedPath`] from ground truth, smoothed, or [`AnalyticPath`] from a simulated flight,
//!   exact.
//! * The world is the inside of a box around the flight, its six faces in relief, covered with points ([`World`]).
//! * The tracker follows at most 150 points, at birth 30 px apart, at the camera's rate and hands over every second frame. A track ends at the
//!   image's border, at random, when its point moves too far in one frame, or when the tracker was blind. Its error is white noise plus
//!   a slow drift, as a template tracker's; a few tracks turn into outliers that slide away.
//! * [`TracksConfig`] has every figure; [`summarise`] says what tracks are like, for comparison.
//!
//! Every draw has a name: the world's by the seed alone, a frame's by its stamp, a track's by its point and the stamp of its birth. So two runs that
//! differ in one figure (a level of noise, a delay) share every other draw.
//!
//! Not here: motion blur, rolling shutter, light, descriptors; occlusion, for a box is convex and its relief is thin.

mod camera;
mod coefficients;
mod config;
mod path;
mod recorded;
mod sight;
mod simulate;
mod smooth;
mod spline;
mod summary;
mod tracker;
mod world;

pub use camera::{BadCameraSettings, CameraSettings};
pub use coefficients::Coefficients;
pub use config::{PathConfig, TracksConfig};
pub use path::{AnalyticPath, Bounds, CameraPath, camera_stamps};
pub use recorded::{PathError, RecordedPath};
pub use simulate::{TracksError, simulate_tracks};
pub use summary::{TrackSummary, summarise};
pub use world::World;
