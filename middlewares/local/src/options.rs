//! The options of this backend: none so far.

use serde::Deserialize;

/// Section `[backends.local]` of the configuration; it has no keys.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Options {}
