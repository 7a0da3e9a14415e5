//! Files as nobody should have to read them, small and large: each once took all memory, minutes or a panic, or is made to.
//!
//! Every reader's budget is held over them in memory (`src/probe/tests/budget.rs`), every command's from outside (`tests/hostile`).

mod bags;
mod binary;
mod damage;
mod logs;
mod text;

pub use bags::{bags, many_channels};
pub use binary::{GIANT_PNG, Spoil, images, safetensors};
pub use damage::{Draw, damage};
pub use logs::{large_logs, logs};
pub use text::{tables, toml, yaml};

/// A file that is made when it is wanted: all of them at once would be a gigabyte.
pub struct Forged {
    /// What is wrong with it.
    pub name: String,
    make: Box<dyn Fn() -> Vec<u8> + Send + Sync>,
}

impl Forged {
    /// A file by how it is made.
    pub fn new(name: impl Into<String>, make: impl Fn() -> Vec<u8> + Send + Sync + 'static) -> Self {
        Self { name: name.into(), make: Box::new(make) }
    }

    /// Its bytes.
    pub fn bytes(&self) -> Vec<u8> {
        (self.make)()
    }
}
