//! Named tensors with a JSON description in one safetensors file: written whole or not at all, checked when read.
//!
//! The description stands under the single metadata key `"dpn"` (one key, because the container writes several in any order, and the same
//! network shall be the same bytes): `{"format", "version", "sha256", "content"}`. The checksum is taken over the description as it stands, with
//! zeros for the checksum's digits, and over the tensors' bytes in the order of their names.

use dpn_core::checksum::of_parts;
use dpn_core::config::gone;
use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The metadata key the description stands under.
const KEY: &str = "dpn";
/// The version of the layout that is written, and the only one that is read.
pub(crate) const FORMAT_VERSION: u64 = 2;
/// What stands for the checksum while it is taken.
const NO_SUM: &str = "0000000000000000000000000000000000000000000000000000000000000000";

/// Why weights or a checkpoint cannot be read, or made into bytes.
#[derive(Debug, Error)]
pub enum StoreError {
    /// The file cannot be read.
    #[error("{}: cannot be read; check that it exists and may be read", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Not a safetensors file, or a damaged or truncated one.
    #[error("{}: no whole safetensors file ({detail}); fetch or train it again", path.display())]
    Container {
        /// The file.
        path: PathBuf,
        /// What the container's reader said.
        detail: String,
    },
    /// A safetensors file that dpn has not written, or one of another purpose.
    #[error("{}: {found}, where {wanted} is needed; give a file that dpn wrote for this purpose", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What it says it is.
        found: String,
        /// What it should be.
        wanted: &'static str,
    },
    /// Written by another version of the layout.
    #[error("{}: layout version {found}, but this program reads version {FORMAT_VERSION}; use the dpn that wrote it, or train again", path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: String,
    },
    /// The description cannot be understood.
    #[error("{}: its description cannot be read ({detail}); use the dpn that wrote it, or train again", path.display())]
    Description {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        detail: String,
    },
    /// A tensor that the configuration asks for is not there.
    #[error("{}: tensor `{name}` is missing; its configuration asks for it, so the file was altered: fetch or train it again", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// The tensor.
        name: String,
    },
    /// A tensor that the configuration does not know.
    #[error("{}: tensor `{name}` is not in its configuration, so the file was altered: fetch or train it again", path.display())]
    Unknown {
        /// The file.
        path: PathBuf,
        /// The tensor.
        name: String,
    },
    /// A tensor of another shape or number type.
    #[error("{}: tensor `{name}` is {found}, where {wanted} is needed; fetch or train it again", path.display())]
    Shape {
        /// The file.
        path: PathBuf,
        /// The tensor.
        name: String,
        /// Its number type and shape.
        found: String,
        /// What its configuration asks for.
        wanted: String,
    },
    /// NaN or infinity among the numbers.
    #[error("{}: tensor `{name}` holds {value} at index {index}; that training diverged: train again with a lower rate", path.display())]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// The tensor.
        name: String,
        /// Index in the tensor, row by row.
        index: usize,
        /// The value.
        value: f32,
    },
    /// Numbers or description are not those that were written.
    #[error("{}: its checksum does not fit its numbers and description; the file is damaged: fetch or train it again", path.display())]
    Checksum {
        /// The file.
        path: PathBuf,
    },
}

/// A tensor on its way into a file or out of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Named {
    /// What it is called.
    pub name: String,
    /// Row by row.
    pub shape: Vec<usize>,
    /// As many as the shape says.
    pub numbers: Vec<f32>,
}

fn le_bytes(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// Over a description without its checksum, and the tensors.
fn checksum<'a>(description: &str, by_name: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> String {
    let tensors = by_name.into_iter().flat_map(|(name, bytes)| [name.as_bytes(), bytes]);
    of_parts(std::iter::once(description.as_bytes()).chain(tensors))
}

/// The bytes of a file with these tensors and this description. The same input gives the same bytes.
///
/// # Errors
/// A description that is no JSON, a shape that does not fit its numbers.
pub fn to_bytes(
    format: &'static str,
    content: &impl Serialize,
    tensors: &[Named],
    path: &Path,
) -> Result<Vec<u8>, StoreError> {
    let description = |detail: String| StoreError::Description { path: path.to_owned(), detail };
    let bytes: BTreeMap<&str, Vec<u8>> =
        tensors.iter().map(|t| (t.name.as_str(), le_bytes(&t.numbers))).collect();
    let content = serde_json::to_value(content).map_err(|e| description(e.to_string()))?;
    let mut meta = json!({"format": format, "version": FORMAT_VERSION, "sha256": NO_SUM, "content": content});
    let sum = checksum(&meta.to_string(), bytes.iter().map(|(n, b)| (*n, b.as_slice())));
    meta["sha256"] = sum.into();
    let mut views = Vec::with_capacity(tensors.len());
    for tensor in tensors {
        let data = &bytes[tensor.name.as_str()];
        let view = TensorView::new(Dtype::F32, tensor.shape.clone(), data)
            .map_err(|e| description(e.to_string()))?;
        views.push((tensor.name.as_str(), view));
    }
    safetensors::serialize(views, Some([(KEY.to_owned(), meta.to_string())].into_iter().collect()))
        .map_err(|e| description(e.to_string()))
}

/// The bytes of a file.
///
/// # Errors
/// One that cannot be read; a pipe, which would be waited for.
pub fn read(path: &Path) -> Result<Vec<u8>, StoreError> {
    let bytes = std::fs::metadata(path).and_then(|meta| match meta.is_file() {
        true => std::fs::read(path),
        false => Err(std::io::Error::new(std::io::ErrorKind::InvalidInput, "not a regular file")),
    });
    bytes.map_err(|source| StoreError::Read { path: path.to_owned(), source })
}

/// Description and tensors of a file's bytes; `path` is for messages. Checks container, format, version and checksum.
///
/// # Errors
/// Each of them that does not fit, and numbers that are not finite.
pub fn from_bytes<T: DeserializeOwned>(
    format: &'static str,
    bytes: &[u8],
    path: &Path,
) -> Result<(T, BTreeMap<String, Named>), StoreError> {
    let container = |detail: String| StoreError::Container { path: path.to_owned(), detail };
    let (_, header) = SafeTensors::read_metadata(bytes).map_err(|e| container(e.to_string()))?;
    let tensors = SafeTensors::deserialize(bytes).map_err(|e| container(e.to_string()))?;
    let foreign = |found: String| StoreError::Format { path: path.to_owned(), found, wanted: format };
    let text = header
        .metadata()
        .as_ref()
        .and_then(|m| m.get(KEY))
        .ok_or_else(|| foreign("a safetensors file without dpn's description".to_owned()))?;
    let mut meta: Value = serde_json::from_str(text)
        .map_err(|e| StoreError::Description { path: path.to_owned(), detail: e.to_string() })?;
    let found = meta["format"].as_str().unwrap_or("a description without format");
    if found != format {
        return Err(foreign(found.to_owned()));
    }
    if meta["version"].as_u64() != Some(FORMAT_VERSION) {
        return Err(StoreError::Version { path: path.to_owned(), found: meta["version"].to_string() });
    }
    let content = serde_json::from_value(meta["content"].take()).map_err(|e| {
        let detail = gone(&e.to_string()).unwrap_or_else(|| e.to_string());
        StoreError::Description { path: path.to_owned(), detail }
    })?;
    let views: BTreeMap<&str, TensorView<'_>> = tensors.iter().collect();
    let mut named = BTreeMap::new();
    for (name, view) in &views {
        if view.dtype() != Dtype::F32 {
            return Err(StoreError::Shape {
                path: path.to_owned(),
                name: (*name).to_owned(),
                found: format!("{:?} {:?}", view.dtype(), view.shape()),
                wanted: "F32".to_owned(),
            });
        }
        let (words, _) = view.data().as_chunks::<4>();
        let numbers: Vec<f32> = words.iter().map(|b| f32::from_le_bytes(*b)).collect();
        if let Some(index) = numbers.iter().position(|v| !v.is_finite()) {
            return Err(StoreError::NotFinite {
                path: path.to_owned(),
                name: (*name).to_owned(),
                index,
                value: numbers[index],
            });
        }
        let tensor = Named { name: (*name).to_owned(), shape: view.shape().to_vec(), numbers };
        named.insert(tensor.name.clone(), tensor);
    }
    let said = meta["sha256"].as_str().unwrap_or_default();
    // Of a text of digits alone nothing else is replaced.
    let is_sum = said.len() == NO_SUM.len() && said.bytes().all(|byte| byte.is_ascii_hexdigit());
    let unsigned = text.replace(&format!("\"sha256\":\"{said}\""), &format!("\"sha256\":\"{NO_SUM}\""));
    if !is_sum || said != checksum(&unsigned, views.iter().map(|(n, v)| (*n, v.data()))) {
        return Err(StoreError::Checksum { path: path.to_owned() });
    }
    Ok((content, named))
}

/// The file with the checksum that fits it.
#[cfg(all(test, feature = "train"))]
pub(crate) fn signed(mut bytes: Vec<u8>) -> Vec<u8> {
    let (_, header) = SafeTensors::read_metadata(&bytes).expect("a file of ours");
    let text = header.metadata().as_ref().and_then(|meta| meta.get(KEY)).expect("a file of ours").clone();
    let meta: Value = serde_json::from_str(&text).expect("a file of ours");
    let said = meta["sha256"].as_str().expect("a file of ours");
    let tensors = SafeTensors::deserialize(&bytes).expect("a file of ours");
    let views: BTreeMap<&str, TensorView<'_>> = tensors.iter().collect();
    let sum = checksum(&text.replace(said, NO_SUM), views.iter().map(|(n, v)| (*n, v.data())));
    let at = bytes.windows(said.len()).position(|part| part == said.as_bytes()).expect("it was read there");
    bytes[at..at + sum.len()].copy_from_slice(sum.as_bytes());
    bytes
}

/// Takes the tensor `name` out of `tensors` if it has this shape.
///
/// # Errors
/// None of that name, or another shape.
pub fn take(
    tensors: &mut BTreeMap<String, Named>,
    name: &str,
    shape: &[usize],
    path: &Path,
) -> Result<Vec<f32>, StoreError> {
    let tensor = tensors
        .remove(name)
        .ok_or_else(|| StoreError::Missing { path: path.to_owned(), name: name.to_owned() })?;
    if tensor.shape != shape {
        return Err(StoreError::Shape {
            path: path.to_owned(),
            name: name.to_owned(),
            found: format!("{:?}", tensor.shape),
            wanted: format!("{shape:?}"),
        });
    }
    Ok(tensor.numbers)
}

/// Refuses tensors nobody took.
///
/// # Errors
/// A tensor.
pub fn nothing_left(tensors: &BTreeMap<String, Named>, path: &Path) -> Result<(), StoreError> {
    match tensors.keys().next() {
        None => Ok(()),
        Some(name) => Err(StoreError::Unknown { path: path.to_owned(), name: name.clone() }),
    }
}
