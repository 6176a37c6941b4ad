//! What the interpreter says of a script that it was to load.

use std::collections::HashMap;
use std::ops::Range;

use serde::Deserialize;

/// A script that is loaded.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Loaded {
    /// Address of the C function of each codel.
    pub(crate) functions: HashMap<String, usize>,
    /// Memory of the events that they return.
    pub(crate) events: Range<usize>,
    /// What the interpreter calls it.
    pub(crate) number: u64,
}

/// Why it is not.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Refused {
    errors: Vec<String>,
}

/// Reads an answer.
///
/// # Errors
/// The script was refused, with the reasons.
pub(crate) fn understand(answer: &[u8]) -> Result<Loaded, Vec<String>> {
    if let Ok(Refused { errors }) = serde_json::from_slice(answer) {
        return Err(errors);
    }
    serde_json::from_slice(answer).map_err(|why| {
        let text = "the interpreter gave no answer; its standard error says why";
        vec![if answer.is_empty() { text.to_owned() } else { format!("{text}: {why}") }]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_is_what_was_loaded_or_why_not() {
        let text = br#"{"functions": {"f": 16}, "events": {"start": 32, "end": 64}, "number": 3}"#;
        let loaded = understand(text).unwrap();
        assert_eq!((loaded.functions["f"], loaded.events, loaded.number), (16, 32..64, 3));
        assert_eq!(understand(br#"{"errors": ["no"]}"#).unwrap_err(), ["no"]);
        assert!(understand(b"").unwrap_err()[0].contains("standard error"));
    }
}
