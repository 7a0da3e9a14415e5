//! From images to tracks.
pub mod corners;
pub mod image;
pub mod klt;
pub mod ransac;
