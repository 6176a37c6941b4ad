//! What a filter of logs may say: `info`, or `info,genomd=debug`.

use genom_nearest::nearest;

use crate::error::NoLevel;

/// Whether a filter says what to log: a level, or levels of parts (`info,genomd=debug`). A word that
/// is neither would be taken for a part that nothing is of, and silence all.
pub fn understood(filter: &str) -> Result<(), NoLevel> {
    const LEVELS: [&str; 6] = ["off", "error", "warn", "info", "debug", "trace"];
    let is_level = |word: &str| {
        LEVELS.contains(&word.to_ascii_lowercase().as_str())
            || word.parse::<u8>().is_ok_and(|n| n < 6)
    };
    for word in filter.split(',').map(str::trim).filter(|word| !word.is_empty()) {
        let level = word.rsplit_once('=').map_or(word, |(_, level)| level);
        // A span or a field may stand in brackets, and hold anything.
        if !is_level(level) && !word.contains(['[', ']']) {
            let nearest = nearest(level, LEVELS).map(str::to_owned);
            return Err(NoLevel { word: level.to_owned(), nearest });
        }
    }
    Ok(())
}
