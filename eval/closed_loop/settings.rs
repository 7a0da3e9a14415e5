//! Settings in a plan: a table, or the name of a file that holds one.

use dpn_core::config::{ConfigFaults, Validate};
use dpn_io::config::{ConfigError, load};
use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeOwned, Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::marker::PhantomData;
use std::path::PathBuf;

/// Settings as a plan has them.
#[derive(Debug, Clone, PartialEq)]
pub enum Settings<T> {
    /// A TOML file of them.
    File(PathBuf),
    /// Themselves.
    Inline(Box<T>),
}

impl<T: Default> Default for Settings<T> {
    fn default() -> Self {
        T::default().into()
    }
}

impl<T> From<T> for Settings<T> {
    fn from(settings: T) -> Self {
        Self::Inline(Box::new(settings))
    }
}

impl<T: Validate> Settings<T> {
    /// Adds the faults of a table that stands in a plan under `key`; a file has its own when it is read.
    pub fn faults(&self, key: &str, faults: &mut ConfigFaults) {
        if let Self::Inline(settings) = self {
            faults.table(key, settings.faults());
        }
    }
}

impl<T: DeserializeOwned + Validate + Clone> Settings<T> {
    /// The settings, a file's read and checked; those of a table were checked with their plan.
    ///
    /// # Errors
    /// A file that cannot be read or holds something else.
    pub fn load(&self) -> Result<T, ConfigError> {
        match self {
            Self::File(path) => load(path),
            Self::Inline(settings) => Ok(T::clone(settings)),
        }
    }
}

impl<T: Serialize> Serialize for Settings<T> {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::File(path) => path.serialize(out),
            Self::Inline(settings) => settings.serialize(out),
        }
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Settings<T> {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        struct TableOrPath<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for TableOrPath<T> {
            type Value = Settings<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table of settings, or the name of a file with them")
            }

            fn visit_str<E: Error>(self, path: &str) -> Result<Self::Value, E> {
                Ok(Settings::File(path.into()))
            }

            fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<Self::Value, M::Error> {
                T::deserialize(MapAccessDeserializer::new(map)).map(Settings::from)
            }
        }
        input.deserialize_any(TableOrPath(PhantomData))
    }
}
