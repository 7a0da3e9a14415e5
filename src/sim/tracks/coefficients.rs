//! A lens' coefficients in a configuration: a list of up to eight.

use dpn_core::camera::Lens;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::ops::Deref;

/// The most that a lens has.
const MOST: usize = 8;

/// Up to eight numbers; a list in files.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    values: [f64; MOST],
    count: usize,
}

impl Coefficients {
    /// Those of `lens`; of a radial-tangential one five at least, as configurations have always had them.
    pub(super) fn of(lens: &Lens) -> Self {
        let mut own = lens.coefficients();
        if matches!(lens, Lens::Radtan(_)) && own.len() < 5 {
            own.resize(5, 0.0);
        }
        Self::try_from(own.as_slice()).expect("no lens has more")
    }
}

impl Deref for Coefficients {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.values[..self.count]
    }
}

impl TryFrom<&[f64]> for Coefficients {
    type Error = String;

    fn try_from(given: &[f64]) -> Result<Self, String> {
        let mut values = [0.0; MOST];
        let to = values.get_mut(..given.len());
        to.ok_or_else(|| format!("a lens has at most {MOST} coefficients, not {}", given.len()))?
            .copy_from_slice(given);
        Ok(Self { values, count: given.len() })
    }
}

impl From<[f64; 5]> for Coefficients {
    fn from(given: [f64; 5]) -> Self {
        let mut values = [0.0; MOST];
        values[..5].copy_from_slice(&given);
        Self { values, count: 5 }
    }
}

impl Serialize for Coefficients {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        out.collect_seq(self.iter())
    }
}

impl<'de> Deserialize<'de> for Coefficients {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        let given = Vec::<f64>::deserialize(input)?;
        Self::try_from(given.as_slice()).map_err(D::Error::custom)
    }
}
