//! Checks filters of the log: `info`, or `info,genomd=debug`.

use genom_nearest::nearest;

use crate::error::NoLevel;

/// Checks a filter: a level, or levels of modules (`info,genomd=debug`). Without this check a
/// misspelt level would count as the name of a module, and nothing would be logged.
pub fn understood(filter: &str) -> Result<(), NoLevel> {
    const LEVELS: [&str; 6] = ["off", "error", "warn", "info", "debug", "trace"];
    let is_level = |word: &str| {
        LEVELS.contains(&word.to_ascii_lowercase().as_str())
            || word.parse::<u8>().is_ok_and(|n| n < 6)
    };
    for word in filter.split(',').map(str::trim).filter(|word| !word.is_empty()) {
        let level = word.rsplit_once('=').map_or(word, |(_, level)| level);
        // A span or a field may stand in brackets, with any content.
        if !is_level(level) && !word.contains(['[', ']']) {
            let nearest = nearest(level, LEVELS).map(str::to_owned);
            return Err(NoLevel { word: level.to_owned(), nearest });
        }
    }
    Ok(())
}
