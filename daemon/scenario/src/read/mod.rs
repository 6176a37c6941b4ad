//! Reads a file of scenarios. All mistakes of a file are told at once.

mod expected;
mod fields;
mod found;
mod run;
mod setup;
mod step;
mod value;

use std::collections::BTreeSet;
use std::path::Path;

use toml::de::DeTable;

use crate::model::{Scenario, Setup, Suite};
use crate::source::{Mistake, Mistakes, Place};
use fields::{Fields, Spot};
use found::Found;

/// The key that makes a file one of scenarios.
pub(crate) const SCENARIO: &str = "scenario";

impl Suite {
    /// Reads the text of a file.
    ///
    /// # Errors
    /// The file has mistakes.
    pub fn read(file: &Path, text: &str) -> Result<Self, Mistakes> {
        let mistakes = |list| Mistakes { file: file.to_owned(), text: text.to_owned(), list };
        let root = DeTable::parse(text).map_err(|error| {
            let span = error.span().unwrap_or(0..0);
            let message = error.message().trim().replace('\n', ", ");
            mistakes(vec![Mistake { span, message, help: None }])
        })?;
        let found = Found::default();
        let directory = file.parent().unwrap_or(Path::new(""));
        let scenarios = read(root.get_ref(), text, directory, &found);
        match found.take() {
            none if none.is_empty() => Ok(Self { file: file.to_owned(), scenarios, script: false }),
            list => Err(mistakes(list)),
        }
    }

    /// Whether a text is one of scenarios: other files of TOML may be beside them.
    #[must_use]
    pub fn is_one(text: &str) -> bool {
        // What cannot be parsed is told when it is read.
        DeTable::parse(text).map_or(true, |root| root.get_ref().contains_key(SCENARIO))
    }
}

fn read(root: &DeTable<'_>, text: &str, directory: &Path, found: &Found) -> Vec<Scenario> {
    let fields = Fields::new(root, 0..0, found);
    let common = setup::read(&fields, directory);
    let mut names = BTreeSet::new();
    let one = |value: Spot<'_, '_>| {
        let fields = Fields::of(value, "a scenario", found)?;
        let place = Place::of(text, value.span().start);
        let name = fields.text("name");
        if name.is_none() {
            fields.missing("name", "say what the scenario shows: name = \"stops at the wall\"");
        }
        if let Some(again) = name.filter(|name| !names.insert((*name).to_owned())) {
            let span = fields.get("name").map_or(value.span(), toml::Spanned::span);
            found.add(span, format!("a second scenario `{again}`"), None);
        }
        if fields.has("play") {
            let run = run::read(&fields, text, directory);
            fields.finish("a scenario that is played without libraries");
            let (setup, steps) = (Setup::default(), Vec::new());
            let name = name.unwrap_or_default().to_owned();
            return Some(Scenario { name, place, setup, steps, run });
        }
        let setup = setup::read(&fields, directory).over(&common);
        let steps: Vec<_> = {
            let mut steps = step::Steps::new(text, directory, found);
            fields.list("steps").filter_map(|step| steps.read(step)).collect()
        };
        if !fields.has("steps") || fields.list("steps").next().is_none() {
            fields.missing("steps", "[[scenario.steps]] begins one");
        }
        fields.finish("a scenario");
        Some(Scenario { name: name.unwrap_or_default().to_owned(), place, setup, steps, run: None })
    };
    let scenarios: Vec<_> = fields.list(SCENARIO).filter_map(one).collect();
    if scenarios.is_empty() && !root.contains_key(SCENARIO) {
        fields.missing(SCENARIO, "[[scenario]] begins one");
    }
    fields.finish("a file of scenarios");
    scenarios
}

#[cfg(test)]
mod tests;
