//! Compares our verdicts on descriptions with those of GenoM3's own tool, as recorded in a
//! manifest.
//!
//! The verdict and the line of the first error are compared, not the messages or their number.

use std::path::{Path, PathBuf};

use genom_description::diagnostic::Severity;
use genom_description::{Options, read};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::table::Table;
use crate::terminal::Terminal;

/// One row of a manifest, with our verdict.
struct Case {
    /// Path as written in the manifest.
    file: String,
    /// `accept`, `reject` or `CRASH`; where the reference tool crashes, an error is expected here.
    expected: String,
    /// Line of the reference tool's first error, if its output is stored beside the file.
    expected_line: Option<u32>,
    /// Line of our first error; `None` if the file is accepted.
    line: Option<u32>,
    /// Why a different verdict is intended.
    reason: Option<String>,
}

impl Case {
    fn agrees(&self) -> bool {
        let refused = self.expected != "accept";
        let elsewhere = self.expected_line.is_some_and(|line| self.line != Some(line));
        refused == self.line.is_some() && !elsewhere
    }

    /// Whether a different verdict is intended and ours is indeed different.
    fn intended(&self) -> bool {
        self.reason.is_some() && !self.agrees()
    }

    fn ours(&self) -> &'static str {
        if self.line.is_some() { "reject" } else { "accept" }
    }

    fn remark(&self) -> &str {
        match (&self.reason, self.agrees()) {
            (None, true) => "",
            (None, false) => "DIFFERS",
            (Some(reason), false) => reason,
            (Some(_), true) => "agrees, though a difference is announced",
        }
    }
}

/// All rows of a manifest.
pub(crate) struct Agreement(Vec<Case>);

impl Agreement {
    /// Reads the manifest, and checks each file that it names relative to itself.
    pub(crate) fn read(manifest: &Path, options: &Options) -> Result<Self, Failure> {
        let text = std::fs::read_to_string(manifest).map_err(|error| {
            Failure::usage(format!("{}: {error}", manifest.display()), "name a manifest")
        })?;
        let directory = manifest.parent().unwrap_or(Path::new(""));
        let rows = text.lines().enumerate().filter(|(_, row)| !row.trim().is_empty());
        rows.map(|(rank, row)| {
            let place = format!("{}:{}", manifest.display(), rank + 1);
            case(&place, row, directory, options)
        })
        .collect::<Result<_, _>>()
        .map(Self)
    }

    /// The table and its summary.
    pub(crate) fn text(&self) -> String {
        let line = |line: Option<u32>| line.map_or_else(|| "-".to_owned(), |n| n.to_string());
        let rows: Vec<Vec<String>> = (self.0.iter())
            .map(|case| {
                vec![
                    case.file.clone(),
                    case.expected.clone(),
                    line(case.expected_line),
                    case.ours().to_owned(),
                    line(case.line),
                    case.remark().to_owned(),
                ]
            })
            .collect();
        let (agree, intended) = (self.count(Case::agrees), self.count(Case::intended));
        let header = vec!["FILE", "EXPECTED", "LINE", "OURS", "LINE", ""];
        let table = Table { header, rows }.text(Terminal::default());
        format!("{table}{agree} of {} agree; {intended} intended differences\n", self.0.len())
    }

    /// Table and summary as JSON.
    pub(crate) fn data(&self) -> Value {
        let case = |case: &Case| {
            json!({
                "file": case.file, "expected": case.expected, "expected_line": case.expected_line,
                "ours": case.ours(), "line": case.line, "agrees": case.agrees(),
                "reason": case.reason,
            })
        };
        self.0.iter().map(case).collect()
    }

    /// Fails if a verdict differs without a stated reason.
    pub(crate) fn verdict(&self) -> Result<(), Failure> {
        let wrong = self.count(|case| !case.agrees() && !case.intended());
        let message = match wrong {
            0 => return Ok(()),
            1 => "1 file differs from the manifest".to_owned(),
            n => format!("{n} files differ from the manifest"),
        };
        Err(Failure::refused("disagreement", message))
    }

    fn count(&self, which: impl Fn(&Case) -> bool) -> usize {
        self.0.iter().filter(|case| which(case)).count()
    }
}

fn case(place: &str, row: &str, directory: &Path, options: &Options) -> Result<Case, Failure> {
    let columns: Vec<&str> = row.split('\t').map(str::trim).collect();
    let (&[file, errors, expected] | &[file, errors, expected, _]) = columns.as_slice() else {
        return Err(malformed(place, "three or four columns are wanted"));
    };
    if errors.parse::<u32>().is_err() {
        return Err(malformed(place, "the second column is no number of errors"));
    }
    if !matches!(expected, "accept" | "reject" | "CRASH") {
        return Err(malformed(place, "the verdict is none of accept, reject, CRASH"));
    }
    let path = directory.join(file);
    if !path.is_file() {
        return Err(malformed(place, &format!("{}: no such file", path.display())));
    }
    Ok(Case {
        file: file.to_owned(),
        expected: expected.to_owned(),
        expected_line: if expected == "accept" { None } else { recorded_line(&path) },
        line: first_line(&path, options),
        reason: columns.get(3).filter(|reason| !reason.is_empty()).map(ToString::to_string),
    })
}

fn malformed(place: &str, why: &str) -> Failure {
    Failure::usage(
        format!("{place}: {why}"),
        "write FILE, number of errors, accept|reject|CRASH and perhaps a reason, with tabs between",
    )
}

/// Line of our first error, in whichever file it is.
fn first_line(path: &PathBuf, options: &Options) -> Option<u32> {
    let analysis = read(&[path], options);
    let error = analysis.diagnostics.iter().find(|said| said.severity == Severity::Error)?;
    Some(analysis.sources.location(error.span).line)
}

/// Line of the first error in the output of the reference tool (`FILE.expected`), if there is one.
fn recorded_line(path: &Path) -> Option<u32> {
    let output = std::fs::read_to_string(path.with_extension("expected")).ok()?;
    output.lines().find_map(|line| {
        let mut parts = line.splitn(3, ':');
        let (_, number, message) = (parts.next()?, parts.next()?, parts.next()?);
        // Notes are indented, and warnings are marked: neither counts as an error.
        let counted = !message.starts_with("  ") && !message.starts_with(" warning");
        counted.then(|| number.parse().ok())?
    })
}
