//! What is wrong with a description without being a mistake.

use genom_finder::Located;
use genom_finder::Reading;

/// Tells the warnings of a description.
pub(super) fn tell_warnings(located: &Located, reading: &Reading) {
    if let Some(warnings) = &reading.warnings {
        tracing::warn!("{}\n{warnings}", located.description.path().display());
    }
}
