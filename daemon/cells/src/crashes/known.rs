//! What a daemon knows of a cell while it lives, for the report of its crash: the libraries of its
//! components, the statistics of their tasks, and the end of its log.

use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use genom_configuration::LoadRequest;
use genom_protocol::{CrashedComponent, LogEntry, Statistics, routes};
use serde_json::Value;

use crate::client::Client;

/// Entries of the log that are kept.
const ENTRIES: usize = 100;
/// Most characters of one.
const LONGEST: usize = 2000;
/// Components whose statistics are asked at once: a cell of many is asked in turns.
const AT_ONCE: usize = 8;

/// What is known of a cell.
#[derive(Debug, Default)]
pub(crate) struct Known {
    components: BTreeMap<String, Last>,
    log: VecDeque<LogEntry>,
    /// The component asked last.
    asked: String,
}

#[derive(Debug, Default)]
struct Last {
    library: PathBuf,
    statistics: Option<Statistics>,
}

impl Known {
    /// An entry of its log.
    pub(crate) fn hear(&mut self, entry: &Value) {
        let Ok(mut entry) = serde_json::from_value::<LogEntry>(entry.clone()) else { return };
        if let Some((at, _)) = entry.message.char_indices().nth(LONGEST) {
            entry.message.truncate(at);
        }
        if self.log.len() >= ENTRIES {
            self.log.pop_front();
        }
        self.log.push_back(entry);
    }

    pub(super) fn log(&self) -> Vec<LogEntry> {
        self.log.iter().cloned().collect()
    }

    /// A component that it was to hold.
    pub(super) fn component(&self, held: &LoadRequest) -> CrashedComponent {
        let name = held.instance();
        let last = self.components.get(&name);
        CrashedComponent {
            library: last.map_or(&held.library, |last| &last.library).clone(),
            statistics: last.and_then(|last| last.statistics.clone()),
            build_id: None,
            name,
        }
    }

    /// Keeps those that are there; returns whose statistics to ask next.
    fn there(&mut self, all: Vec<(String, PathBuf)>) -> Vec<String> {
        let mut before = std::mem::take(&mut self.components);
        for (name, library) in all {
            let statistics = before.remove(&name).and_then(|last| last.statistics);
            self.components.insert(name, Last { library, statistics });
        }
        let (done, rest): (Vec<_>, Vec<_>) =
            self.components.keys().partition(|name| **name <= self.asked);
        let next: Vec<String> = rest.into_iter().chain(done).take(AT_ONCE).cloned().collect();
        self.asked = next.last().cloned().unwrap_or_default();
        next
    }
}

/// Asks a cell how its tasks do.
pub(crate) async fn learn(client: &Client, known: &Mutex<Known>) {
    let lock = || known.lock().unwrap_or_else(PoisonError::into_inner);
    let Ok(all) = client.ask(&routes::components()).await else { return };
    let all = all.components.into_iter().map(|one| (one.name, one.library)).collect();
    let next = lock().there(all);
    for name in next {
        let Ok(statistics) = client.ask(&routes::statistics(&name)).await else { continue };
        if let Some(last) = lock().components.get_mut(&name) {
            last.statistics = Some(statistics);
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn the_end_of_the_log_is_kept() {
        let mut known = Known::default();
        for number in 0..250 {
            let message = format!("{number}{}", "x".repeat(3000));
            known.hear(&json!({"time": 0.0, "level": "info", "origin": "o", "message": message}));
        }
        let log = known.log();
        assert_eq!(log.len(), ENTRIES);
        assert!(log[99].message.starts_with("249x") && log[99].message.len() == LONGEST);
    }

    #[test]
    fn many_components_are_asked_in_turns() {
        let mut known = Known::default();
        let all = || (0..20).map(|n| (format!("c{n:02}"), PathBuf::new())).collect::<Vec<_>>();
        let mut asked: Vec<String> = (0..3).flat_map(|_| known.there(all())).collect();
        assert_eq!(asked.len(), 24);
        asked.sort();
        asked.dedup();
        assert_eq!(asked.len(), 20);
    }
}
