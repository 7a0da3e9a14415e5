//! Values of a calibration's keys, with their lines.

use super::CalibrationError;
use crate::noise_formats::tree::{Entry, Item, Node, Tree};
use crate::pose::{self, rigid};
use crate::printable;
use dpn_core::camera::Distortion;
use dpn_core::geometry::rigid::ROTATION_TOLERANCE;
use dpn_core::time::SampleRate;
use nalgebra::{Isometry3, Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3};
use std::path::{Path, PathBuf};

/// Where a value stands.
#[derive(Debug, Clone)]
pub(super) struct Place {
    path: PathBuf,
    line: usize,
    key: String,
}

impl Place {
    pub(super) fn new(path: &Path, line: usize, key: &str) -> Self {
        Self { path: path.to_path_buf(), line, key: key.to_owned() }
    }

    /// What is wrong there.
    pub(super) fn error(&self, problem: String) -> CalibrationError {
        let Self { path, line, key } = self.clone();
        CalibrationError::Bad { path, line, key, problem }
    }

    /// The block that the key stands in, where it stands in one.
    pub(super) fn block(&self) -> Self {
        let key = self.key.rsplit_once('.').map_or(self.key.as_str(), |(block, _)| block).to_owned();
        Self { key, ..self.clone() }
    }
}

/// The keys of a file, or of a block in it.
#[derive(Debug, Clone)]
pub(super) struct Keys<'a> {
    path: &'a Path,
    /// Keys above, with a dot behind; empty at the top.
    above: String,
    entries: &'a [Entry],
}

impl<'a> Keys<'a> {
    pub(super) fn new(path: &'a Path, tree: &'a Tree) -> Self {
        Self { path, above: String::new(), entries: tree.root() }
    }

    /// The file that these are the keys of.
    pub(super) fn path(&self) -> &'a Path {
        self.path
    }

    /// The file that `key` names, which stands in the same folder.
    pub(super) fn beside(&self, key: &'static str) -> Result<PathBuf, CalibrationError> {
        let name = self.text(key)?;
        if !crate::asl::camera::stays_inside(&name) {
            let problem = format!("is \"{}\"; a file of the same folder is needed", printable(&name));
            return Err(self.bad(key, problem));
        }
        Ok(self.path.with_file_name(name))
    }

    fn find(&self, key: &str) -> Option<&'a Entry> {
        self.entries.iter().find(|entry| entry.key == key)
    }

    pub(super) fn has(&self, key: &str) -> bool {
        self.find(key).is_some()
    }

    /// The first of `names` that is there.
    pub(super) fn first(&self, names: &[&'static str]) -> Option<&'static str> {
        names.iter().copied().find(|name| self.has(name))
    }

    fn get(&self, key: &'static str, remedy: &'static str) -> Result<&'a Entry, CalibrationError> {
        let missing = || CalibrationError::Missing {
            path: self.path.to_path_buf(),
            key: format!("{}{key}", self.above),
            remedy,
        };
        self.find(key).ok_or_else(missing)
    }

    fn must(&self, key: &'static str) -> Result<&'a Entry, CalibrationError> {
        self.get(key, "the file's kind has this key; take the whole file as the program wrote it")
    }

    /// Where a key stands; line 1 where it is not there.
    pub(super) fn place(&self, key: &str) -> Place {
        let line = self.find(key).map_or(1, |entry| entry.line);
        Place { path: self.path.to_path_buf(), line, key: format!("{}{key}", self.above) }
    }

    pub(super) fn bad(&self, key: &str, problem: String) -> CalibrationError {
        self.place(key).error(problem)
    }

    /// The block of `key`; of a list its first.
    pub(super) fn below(&self, key: &str) -> Option<Self> {
        let node = &self.find(key)?.value.node;
        let (entries, nth) = match node {
            Node::Map(entries) => (entries, ""),
            Node::List(list) => match &list.first()?.node {
                Node::Map(entries) => (entries, "[0]"),
                _ => return None,
            },
            _ => return None,
        };
        Some(Self { path: self.path, above: format!("{}{key}{nth}.", self.above), entries })
    }

    /// The block of `key`, which must be there.
    pub(super) fn block(&self, key: &'static str) -> Result<Self, CalibrationError> {
        self.must(key)?;
        self.below(key).ok_or_else(|| self.bad(key, "is no block of keys".to_owned()))
    }

    pub(super) fn text(&self, key: &'static str) -> Result<String, CalibrationError> {
        let entry = self.must(key)?;
        match &entry.value.node {
            Node::Text(text) => Ok(text.clone()),
            _ => Err(self.bad(key, format!("is {}; a name is needed", entry.value.shown()))),
        }
    }

    /// The lens that `key` names.
    pub(super) fn lens(&self, key: &'static str) -> Result<Distortion, CalibrationError> {
        let text = self.text(key)?;
        text.parse().map_err(|unknown| self.bad(key, format!("is \"{}\": {unknown}", printable(&text))))
    }

    pub(super) fn number(&self, key: &'static str) -> Result<f64, CalibrationError> {
        self.numbers::<1>(key).map(|[number]| number)
    }

    /// The number of `key`, where it is there.
    pub(super) fn optional(&self, key: &'static str) -> Result<Option<f64>, CalibrationError> {
        self.has(key).then(|| self.number(key)).transpose()
    }

    /// All numbers of a key, finite; those of an OpenCV matrix are its `data`.
    pub(super) fn list(&self, key: &'static str) -> Result<Vec<f64>, CalibrationError> {
        let entry = self.must(key)?;
        let item = data(&entry.value).unwrap_or(&entry.value);
        let numbers = item.numbers().filter(|numbers| numbers.iter().all(|v| v.is_finite()));
        numbers.ok_or_else(|| self.bad(key, format!("is {}; finite numbers are needed", item.shown())))
    }

    pub(super) fn numbers<const N: usize>(&self, key: &'static str) -> Result<[f64; N], CalibrationError> {
        let list = self.list(key)?;
        let found = list.len();
        let count = |_| self.bad(key, format!("has {found} numbers; {N} are needed"));
        <[f64; N]>::try_from(list).map_err(count)
    }

    /// The numbers of several keys.
    pub(super) fn each<const N: usize>(&self, keys: [&'static str; N]) -> Result<[f64; N], CalibrationError> {
        let mut values = [0.0; N];
        for (value, key) in values.iter_mut().zip(keys) {
            *value = self.number(key)?;
        }
        Ok(values)
    }

    /// Width and height from one key or two.
    pub(super) fn size(&self, keys: &[&'static str]) -> Result<[u32; 2], CalibrationError> {
        let size = match *keys {
            [both] => self.numbers(both)?,
            [width, height] => [self.number(width)?, self.number(height)?],
            _ => unreachable!("a size is one key or two"),
        };
        let whole = |v: f64| (v >= 1.0 && v <= f64::from(u32::MAX) && v.fract() == 0.0).then_some(v as u32);
        match size.map(whole) {
            [Some(width), Some(height)] => Ok([width, height]),
            _ => Err(self.bad(keys[0], format!("makes an image of {} x {} px", size[0], size[1]))),
        }
    }

    /// A rate in Hz, where it is there.
    pub(super) fn rate(&self, key: &'static str) -> Result<Option<SampleRate>, CalibrationError> {
        let Some(hz) = self.optional(key)? else { return Ok(None) };
        let rate = SampleRate::from_hz(hz);
        rate.map(Some).ok_or_else(|| self.bad(key, format!("is {hz}; a rate is positive and finite")))
    }

    /// The rigid motion of a matrix of 4 (or 3) rows of 4; `remedy` where the key is not there.
    pub(super) fn pose(
        &self,
        key: &'static str,
        remedy: &'static str,
    ) -> Result<Isometry3<f64>, CalibrationError> {
        self.get(key, remedy)?;
        rigid(&self.list(key)?).map_err(|problem| self.bad(key, problem))
    }

    /// The same of a rotation's nine numbers and a translation's three.
    pub(super) fn rigid(
        &self,
        key: &str,
        rotation: &Matrix3<f64>,
        offset: Vector3<f64>,
    ) -> Result<Isometry3<f64>, CalibrationError> {
        pose::turned(rotation, offset).map_err(|problem| self.bad(key, problem))
    }

    /// The same of a unit quaternion x, y, z, w.
    pub(super) fn turned(
        &self,
        key: &str,
        [x, y, z, w]: [f64; 4],
        offset: Vector3<f64>,
    ) -> Result<Isometry3<f64>, CalibrationError> {
        let q = Quaternion::new(w, x, y, z);
        if (q.norm() - 1.0).abs() > ROTATION_TOLERANCE {
            return Err(
                self.bad(key, format!("holds no rotation: its quaternion has length {:.4}", q.norm()))
            );
        }
        Ok(Isometry3::from_parts(Translation3::from(offset), UnitQuaternion::new_normalize(q)))
    }
}

/// The `data` of an OpenCV matrix.
fn data(item: &Item) -> Option<&Item> {
    match &item.node {
        Node::Map(entries) => entries.iter().find(|entry| entry.key == "data").map(|entry| &entry.value),
        _ => None,
    }
}
