//! Selects entries of the log.

use genom_nearest::suggest;
use genom_protocol::Level;
use genom_supervisor::bus::Numbered;
use serde::Deserialize as _;
use strum::VariantNames as _;

/// Which entries are wanted.
#[derive(Clone, Debug)]
pub struct Selection {
    level: Level,
    /// Only entries about this component.
    pub component: Option<String>,
}

/// The text is no level.
#[derive(Clone, Debug, thiserror::Error)]
#[error("level: there is no level `{0}`")]
pub struct UnknownLevel(String);

impl UnknownLevel {
    /// The nearest level, or all of them.
    #[must_use]
    pub fn help(&self) -> String {
        suggest(&self.0, Level::VARIANTS.iter().copied())
    }
}

impl Selection {
    /// Entries of this level and more severe ones, all by default; about one component, or all.
    ///
    /// # Errors
    /// There is no such level.
    pub fn new(level: Option<&str>, component: Option<String>) -> Result<Self, UnknownLevel> {
        let level = level.unwrap_or("trace");
        let level = level.parse().map_err(|_| UnknownLevel(level.to_owned()))?;
        Ok(Self { level, component })
    }

    /// Whether an entry is wanted.
    #[must_use]
    pub fn has(&self, entry: &Numbered) -> bool {
        Level::deserialize(&entry.data["level"]).is_ok_and(|level| level <= self.level)
            && self.component.as_deref().is_none_or(|name| entry.data["component"] == name)
    }

    /// The latest `last` of the selected entries.
    #[must_use]
    pub fn latest(&self, all: Vec<Numbered>, last: Option<usize>) -> Vec<Numbered> {
        let mut found: Vec<_> = all.into_iter().filter(|entry| self.has(entry)).collect();
        found.drain(..found.len().saturating_sub(last.unwrap_or(usize::MAX)));
        found
    }
}
