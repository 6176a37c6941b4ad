//! Limits log lines that peers can cause at will: the first is logged at once, then one per
//! interval with the number of those left out.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Interval between two lines of one kind.
const EVERY: Duration = Duration::from_secs(10);

/// Maximum number of kinds; beyond that, further kinds are counted as one.
const KINDS: usize = 256;

/// What was logged, and when.
#[derive(Debug, Default)]
pub struct Seldom(Mutex<HashMap<String, Told>>);

#[derive(Debug)]
struct Told {
    when: Instant,
    /// Number of lines left out since.
    hidden: u64,
}

impl Seldom {
    /// Logs a line, unless one of this kind was logged recently; `line` receives a text to append.
    pub fn tell(&self, kind: String, line: impl FnOnce(&str)) {
        if let Some(hidden) = self.due(kind, Instant::now()) {
            let more = if hidden == 0 { String::new() } else { format!(" ({hidden} more before)") };
            line(&more);
        }
    }

    /// Whether to log, and the number of lines left out before.
    fn due(&self, mut kind: String, now: Instant) -> Option<u64> {
        let mut told = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if told.len() >= KINDS && !told.contains_key(&kind) {
            told.retain(|_, one| now.duration_since(one.when) < EVERY || one.hidden > 0);
            if told.len() >= KINDS {
                kind.clear();
            }
        }
        let Some(one) = told.get_mut(&kind) else {
            told.insert(kind, Told { when: now, hidden: 0 });
            return Some(0);
        };
        if now.duration_since(one.when) < EVERY {
            one.hidden += 1;
            return None;
        }
        one.when = now;
        Some(std::mem::take(&mut one.hidden))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_told_at_once_and_then_with_its_count() {
        let (seldom, now) = (Seldom::default(), Instant::now());
        let due = |kind: &str, after: Duration| seldom.due(kind.to_owned(), now + after);
        assert_eq!(due("a", Duration::ZERO), Some(0));
        assert_eq!(due("b", Duration::ZERO), Some(0));
        for _ in 0..1000 {
            assert_eq!(due("a", EVERY / 2), None);
        }
        assert_eq!(due("a", EVERY), Some(1000));
        assert_eq!(due("b", EVERY), Some(0));
    }

    #[test]
    fn ever_new_kinds_take_no_more_memory() {
        let (seldom, now) = (Seldom::default(), Instant::now());
        let told = (0..10_000).filter(|kind| seldom.due(format!("{kind}"), now).is_some()).count();
        assert_eq!(told, KINDS + 1);
        assert!(seldom.0.lock().unwrap().len() <= KINDS + 1);
        assert_eq!(
            seldom.due("new".to_owned(), now + EVERY),
            Some(0),
            "the old ones are forgotten"
        );
    }
}
