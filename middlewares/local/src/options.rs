//! What can be chosen: nothing, so far.

use serde::Deserialize;

/// `[backends.local]`: it has no keys.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Options {}
