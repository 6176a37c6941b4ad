//! The rates that ports had lately, and a sparkline of them.

use std::collections::{HashMap, VecDeque};

use super::snapshot::Snapshot;

/// Readings that are kept.
const MOST: usize = 20;
/// From the least to the most.
const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// The latest rates of each port.
#[derive(Debug, Default)]
pub struct Trends(HashMap<String, VecDeque<f64>>);

impl Trends {
    /// Adds the rates between two readings. Ports that are no more are forgotten.
    pub fn add(&mut self, now: &Snapshot, before: &Snapshot) {
        self.0.retain(|address, _| now.ports.iter().any(|port| port.address == *address));
        for port in &now.ports {
            let Some(rate) = now.rate(port, before) else { continue };
            let rates = self.0.entry(port.address.clone()).or_default();
            if rates.len() == MOST {
                rates.pop_front();
            }
            rates.push_back(rate);
        }
    }

    /// Whether there are enough readings for a line.
    pub(crate) fn say_something(&self) -> bool {
        self.0.values().any(|rates| rates.len() > 1)
    }

    /// One bar for each reading, the latest last, as high as its part of the greatest.
    pub(crate) fn line(&self, address: &str) -> String {
        let Some(rates) = self.0.get(address) else { return String::new() };
        let most = rates.iter().copied().fold(0.0, f64::max);
        rates.iter().map(|&rate| bar(rate, most)).collect()
    }
}

/// A port that is silent has the lowest bar, one with any sample at least the next.
fn bar(rate: f64, most: f64) -> char {
    if rate <= 0.0 || most <= 0.0 {
        return BARS[0];
    }
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 7")]
    let level = (rate / most * 7.0).round() as usize;
    BARS[level.clamp(1, 7)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_the_latest_readings_by_their_part_of_the_greatest() {
        let mut trends = Trends::default();
        let rates = (0..MOST + 3).map(|number| number as f64).rev();
        trends.0.insert("a/x".to_owned(), rates.skip(3).collect());
        let line = trends.line("a/x");
        assert_eq!(line.chars().count(), MOST);
        assert!(line.starts_with('█') && line.ends_with("▂▁"), "{line}");
        assert_eq!(trends.line("a/y"), "");
    }

    #[test]
    fn silence_is_lower_than_a_little() {
        assert_eq!([0.0, 0.01, 50.0, 100.0].map(|rate| bar(rate, 100.0)), ['▁', '▂', '▅', '█']);
        assert_eq!(bar(0.0, 0.0), '▁');
    }
}
