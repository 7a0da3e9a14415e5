//! Textures: painted once from random streams, looked up at any size.

mod atlas;
mod canvas;
mod material;

pub(super) use atlas::{Atlas, LOG_COARSEST, LOG_SIDE};
pub(super) use canvas::SIDE;
pub(super) use material::Material;
