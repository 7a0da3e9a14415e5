//! The odometry from outside: on flights, on rendered and real images, against other people's pre-integration.
#![allow(clippy::unwrap_used)]

mod at_rest;
mod bias_jump;
mod clock;
mod configs;
mod estimator;
mod flown;
mod gtsam_preintegration;
mod lens;
mod rendered_camera;
mod start_covariance;
mod suspects;
mod take_off;
