//! What came of scenarios.

mod junit;
mod text;

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::model::Scenario;

/// Everything that was played.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Report {
    /// Scenarios that did not pass.
    pub failed: usize,
    /// By file, in the order of playing.
    pub files: Vec<SuiteReport>,
}

/// What came of the scenarios of a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SuiteReport {
    /// The file, as it was named.
    pub file: PathBuf,
    /// In the order of the file.
    pub scenarios: Vec<ScenarioReport>,
}

/// What came of a scenario.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct ScenarioReport {
    /// Its name.
    pub name: String,
    /// Its line in the file.
    pub line: usize,
    /// What was done of it.
    #[serde(flatten)]
    pub played: Played,
    /// How it ended.
    #[serde(flatten)]
    pub outcome: Outcome,
}

/// How far a scenario got.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Played {
    /// Steps that held.
    pub steps: usize,
    /// The time on the clock at its end.
    pub nanoseconds: u64,
}

/// How a scenario ended.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(tag = "outcome", content = "why", rename_all = "snake_case")]
pub enum Outcome {
    /// All steps held.
    Passed,
    /// A step did not hold.
    Failed(Unmet),
    /// It could not be played to its end.
    Error(Unmet),
}

/// What did not hold.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct Unmet {
    /// Line of the step in the file, or of the scenario if it did not begin.
    pub line: usize,
    /// The step in a few words.
    pub step: String,
    /// The time on the clock.
    pub nanoseconds: u64,
    /// What was to be.
    pub expected: String,
    /// What was.
    pub came: String,
    /// What the daemon advises.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
}

impl Outcome {
    /// A scenario did not begin, since its daemon does not run.
    #[must_use]
    pub fn not_begun(scenario: &Scenario, why: &str) -> Self {
        Self::Error(Unmet {
            line: scenario.place.line,
            step: "begin".to_owned(),
            nanoseconds: 0,
            expected: "a daemon with what the scenario names".to_owned(),
            came: why.to_owned(),
            help: None,
        })
    }

    /// A run without libraries did not come to its end: this step is not what the runtime did.
    #[must_use]
    pub fn not_as_scripted(scenario: &Scenario, step: Option<usize>, why: &str) -> Self {
        let run = scenario.run.as_ref();
        let place = run.and_then(|run| run.places.get(step?));
        let at = run.and_then(|run| run.script.steps.get(step?)).map_or(0, |step| step.at);
        Self::Failed(Unmet {
            line: place.map_or(scenario.place.line, |place| place.line),
            step: step.map_or("begin".to_owned(), |step| format!("step {} of the run", step + 1)),
            nanoseconds: at,
            expected: "that it is possible".to_owned(),
            came: why.to_owned(),
            help: None,
        })
    }

    /// A script of which nobody knows how far it got did not end.
    #[must_use]
    pub fn not_ended(scenario: &Scenario, why: &str) -> Self {
        Self::Error(Unmet {
            line: scenario.place.line,
            step: "the scenario".to_owned(),
            nanoseconds: 0,
            expected: "that it ends".to_owned(),
            came: why.to_owned(),
            help: None,
        })
    }

    /// What did not hold.
    #[must_use]
    pub fn unmet(&self) -> Option<&Unmet> {
        match self {
            Self::Passed => None,
            Self::Failed(unmet) | Self::Error(unmet) => Some(unmet),
        }
    }
}

impl Report {
    /// How many scenarios were played.
    #[must_use]
    pub fn total(&self) -> usize {
        self.files.iter().map(|suite| suite.scenarios.len()).sum()
    }

    /// A file begins.
    pub fn begin(&mut self, file: PathBuf) {
        self.files.push(SuiteReport { file, scenarios: Vec::new() });
    }

    /// Adds what came of a scenario of the last file.
    pub fn add(&mut self, scenario: &Scenario, outcome: Outcome, played: Played) {
        self.failed += usize::from(outcome != Outcome::Passed);
        let (name, line) = (scenario.name.clone(), scenario.place.line);
        if let Some(suite) = self.files.last_mut() {
            suite.scenarios.push(ScenarioReport { name, line, played, outcome });
        }
    }
}

#[cfg(test)]
mod tests;
