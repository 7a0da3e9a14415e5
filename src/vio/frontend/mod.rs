//! From images to tracks.
pub mod image;
pub mod klt;
