//! How the options that are no plain values are written in a configuration.

use std::path::PathBuf;

use serde::{Deserialize as _, Deserializer};

/// A folder; an empty string is none.
pub(crate) fn folder<'de, D: Deserializer<'de>>(from: D) -> Result<Option<PathBuf>, D::Error> {
    let folder = PathBuf::deserialize(from)?;
    Ok(Some(folder).filter(|folder| !folder.as_os_str().is_empty()))
}

/// Keys of zenoh's own configuration, with values as JSON, which is JSON5 as well.
pub(crate) fn of_zenoh<'de, D: Deserializer<'de>>(
    from: D,
) -> Result<Vec<(String, String)>, D::Error> {
    let table = serde_json::Map::deserialize(from)?;
    Ok(table.into_iter().map(|(key, value)| (key, value.to_string())).collect())
}
