//! Deserialisation of those options that have a special form in configurations.

use std::path::PathBuf;

use serde::{Deserialize as _, Deserializer};

/// A folder; an empty string means none.
pub(crate) fn folder<'de, D: Deserializer<'de>>(from: D) -> Result<Option<PathBuf>, D::Error> {
    let folder = PathBuf::deserialize(from)?;
    Ok(Some(folder).filter(|folder| !folder.as_os_str().is_empty()))
}

/// Settings of zenoh's own configuration, with values as JSON (which is valid JSON5).
pub(crate) fn of_zenoh<'de, D: Deserializer<'de>>(
    from: D,
) -> Result<Vec<(String, String)>, D::Error> {
    let table = serde_json::Map::deserialize(from)?;
    Ok(table.into_iter().map(|(key, value)| (key, value.to_string())).collect())
}
