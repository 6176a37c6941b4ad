//! What all roles share: tables, clocks, and the rules as functions.

use std::fmt::Write as _;

use genom_formal::{System, Times};

use crate::error::ExportError;
use crate::tables::{Entry, Sizes, durations, listed, periodic, tables};

/// The rules.
const RULES: &str = include_str!("../rules.xta");
/// What a clock is compared with is less than 2 to the power of 30.
const LONGEST: usize = 1_000_000_000;

pub(super) fn declared(
    system: &System,
    sizes: &Sizes,
    times: Option<&Times>,
) -> Result<String, ExportError> {
    let mut text = String::from("\n");
    let mut constants = sizes.constants(system);
    constants.push(("MACHINES", sizes.machines.max(1)));
    constants.push(("HEARD", sizes.sinks.max(1)));
    for (name, value) in constants {
        let _ = writeln!(text, "const int {name} = {value};");
    }
    let entries = |text: &mut String, all: &[Entry]| all.iter().for_each(|one| entry(text, one));
    entries(&mut text, &tables(system));
    match times {
        None => entry(&mut text, &periodic(system)),
        Some(times) => entries(&mut text, &clocks(system, times)?),
    }
    text.push_str(&RULES.replace("FIRST_PHASE", sizes.first_phase()));
    if times.is_some() {
        text.push_str(CLOCKS);
    }
    Ok(text)
}

/// Declared where there are times.
const CLOCKS: &str = "
clock clk[TASKS];              /* time since the last tick */
clock since[CONTEXTS + 1];     /* time since each context began its node; the last one is of none */
/* The clock of a context that executes nothing; that of none otherwise. */
int idle(int c) {
  if (held[c] == 0) return c;
  return CONTEXTS;
}
";

/// Durations by what contexts execute: a node plus one, and 0 for nothing.
fn clocks(system: &System, times: &Times) -> Result<Vec<Entry>, ExportError> {
    let mut all = durations(system, times);
    for entry in &mut all {
        let Entry::Table(name, values) = entry else { continue };
        if let Some(count) = values.iter().copied().find(|value| *value > LONGEST) {
            let what = "units of time in one of its times";
            return Err(ExportError::TooMany { what, count, most: LONGEST, format: "uppaal" });
        }
        if ["LEAST", "MOST"].contains(name) {
            values.insert(0, 0);
        }
    }
    Ok(all)
}

fn entry(text: &mut String, entry: &Entry) {
    let _ = match entry {
        Entry::Note(..) => writeln!(text, "/* {entry} */"),
        Entry::Table(name, values) => {
            let values = if values.is_empty() { &vec![0] } else { values };
            writeln!(text, "const int {name}[{}] = {{ {} }};", values.len(), listed(values))
        }
    };
}
