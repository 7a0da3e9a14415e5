//! `closed_loop.json`: rows and what is made of them.

use super::Study;
use crate::closed_loop::{Consistency, Row};
use serde::ser::{Error, SerializeMap, SerializeSeq};
use serde::{Serialize, Serializer};
use serde_json::to_value;

/// Rows, what they say of noises, and how consistent the estimator is; all keys in alphabetical order.
#[derive(Debug, Clone, Copy)]
pub struct StudyFile<'a> {
    /// NEES over many seeds.
    pub consistency: &'a [Consistency],
    /// All rows.
    pub rows: &'a [Row],
    /// What they say of noises.
    pub study: &'a Study,
}

impl Serialize for StudyFile<'_> {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        let mut map = out.serialize_map(Some(3))?;
        map.serialize_entry("consistency", &to_value(self.consistency).map_err(S::Error::custom)?)?;
        map.serialize_entry("rows", &Rows(self.rows))?;
        map.serialize_entry("study", &to_value(self.study).map_err(S::Error::custom)?)?;
        map.end()
    }
}

/// One row after another: all of them as JSON values would take a hundred times their bytes.
struct Rows<'a>(&'a [Row]);

impl Serialize for Rows<'_> {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        let mut rows = out.serialize_seq(Some(self.0.len()))?;
        for row in self.0 {
            rows.serialize_element(&to_value(row).map_err(S::Error::custom)?)?;
        }
        rows.end()
    }
}
