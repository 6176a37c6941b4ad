//! A report for people: a line for each scenario, and what did not hold.

use std::path::Path;

use super::{Outcome, Report, ScenarioReport};
use crate::duration::seconds;

impl ScenarioReport {
    /// A line, and what did not hold below it.
    #[must_use]
    pub fn text(&self, file: &Path) -> String {
        let word = match self.outcome {
            Outcome::Passed => "ok   ",
            Outcome::Failed(_) => "FAIL ",
            Outcome::Error(_) => "ERROR",
        };
        let count = match self.played.steps {
            1 => "1 step".to_owned(),
            count => format!("{count} steps"),
        };
        let mut text =
            format!("  {word} {} ({count}, {})\n", self.name, seconds(self.played.nanoseconds));
        if let Some(unmet) = self.outcome.unmet() {
            let lines = [
                format!("{}:{}: {}", file.display(), unmet.line, unmet.step),
                format!("  at        {}", seconds(unmet.nanoseconds)),
                format!("  expected  {}", unmet.expected),
                format!("  came      {}", unmet.came),
            ];
            let help = unmet.help.as_ref().map(|help| format!("  help      {help}"));
            for line in lines.into_iter().chain(help) {
                text.push_str(&format!("        {line}\n"));
            }
        }
        text
    }
}

impl Report {
    /// How many there were, and how many passed.
    #[must_use]
    pub fn summary(&self) -> String {
        let total = self.total();
        let plural = if total == 1 { "" } else { "s" };
        match self.failed {
            0 => format!("{total} scenario{plural} passed\n"),
            failed => {
                format!("{total} scenario{plural}: {} passed, {failed} failed\n", total - failed)
            }
        }
    }
}
