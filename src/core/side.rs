//! Which recordings teach and which judge.

use serde::{Deserialize, Serialize};

crate::named!(
    /// Side of the split a sequence or a flight stands on.
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum Side {
        /// Seen in training (its last part serves as validation).
        Train = "train",
        /// Never looked at in training, nor when anything is chosen.
        Test = "test",
    }
);
