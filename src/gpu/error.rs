//! What goes wrong with a card.

use thiserror::Error;

/// Why a card does not serve.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum GpuError {
    /// None there.
    #[error("no GPU was found through Vulkan, Metal, DirectX or OpenGL: {reason}")]
    None {
        /// What was looked for.
        reason: String,
    },
    /// It stopped answering, or refused what it was asked.
    #[error("{adapter} failed: {reason}")]
    Failed {
        /// Its name and driver.
        adapter: String,
        /// What it said.
        reason: String,
    },
    /// A network that does not go in.
    #[error(
        "{adapter} has no room for this network: {what} takes {bytes} bytes, and {most} is the most at a time"
    )]
    Memory {
        /// Its name and driver.
        adapter: String,
        /// A window or a batch.
        what: &'static str,
        /// It takes.
        bytes: u64,
        /// What there is.
        most: u64,
    },
    /// Numbers that are not what the processor gets.
    #[error("{adapter} computes wrongly: of the same windows its {what} are {apart} off the processor's")]
    Wrong {
        /// Its name and driver.
        adapter: String,
        /// Answers or gradients.
        what: &'static str,
        /// Largest difference, in units of the largest number.
        apart: String,
    },
}

impl GpuError {
    /// What to do about it.
    pub fn hint(&self) -> String {
        match self {
            Self::None { .. } => {
                "install a Vulkan driver, or leave --device out: the processor trains too".into()
            }
            Self::Memory { .. } => {
                "make `fit.batch`, `network.window` or `network.channels` smaller, or leave --device out"
                    .into()
            }
            Self::Failed { .. } => {
                "finished epochs are kept: add --resume, with --device cpu if the card does not come back"
                    .into()
            }
            Self::Wrong { .. } => {
                "another driver may do better; --device cpu goes on from the same checkpoint".into()
            }
        }
    }
}
