//! Every recorded case of GenoM3's behaviour: same verdict, same line of the first error. Where
//! genomd differs on purpose (docs/language.md), the fourth column of the manifest says why.

#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

use std::path::{Path, PathBuf};

use genom_description::diagnostic::Severity;
use genom_description::{Options, read};

#[derive(Debug, PartialEq, Eq)]
struct Outcome {
    accepted: bool,
    line: Option<u32>,
}

fn ours(file: &Path) -> (Outcome, String) {
    let options = Options { standard_interface: false, ..Options::default() };
    let analysis = read(&[file], &options);
    let errors = || analysis.diagnostics.iter().filter(|d| d.severity == Severity::Error);
    // As GenoM3 reports it: the line only, whatever the file.
    let line = errors().next().map(|d| analysis.sources.location(d.span).line);
    let said = errors().map(|d| format!("{} {}", d.code, d.message)).collect::<Vec<_>>().join("; ");
    (Outcome { accepted: line.is_none(), line }, said)
}

/// Verdict of the manifest and line of the first message counted as an error.
fn theirs(cases: &Path, name: &str, verdict: &str) -> Outcome {
    let accepted = verdict == "accept";
    let text = std::fs::read_to_string(cases.join(name).with_extension("expected")).unwrap();
    let line = text.lines().find_map(|line| {
        let mut parts = line.splitn(3, ':');
        let (_, number, message) = (parts.next()?, parts.next()?, parts.next()?);
        let counted = !message.starts_with("  ") && !message.starts_with(" warning");
        if counted { number.parse().ok() } else { None }
    });
    Outcome { accepted, line: if accepted { None } else { line } }
}

#[test]
fn verdicts_and_lines_agree_with_genom3() {
    let cases = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
    let manifest = std::fs::read_to_string(cases.join("manifest.tsv")).unwrap();
    let (mut total, mut same, mut intended, mut wrong) = (0, 0, 0, Vec::new());
    for row in manifest.lines().filter(|row| !row.is_empty()) {
        let mut columns = row.split('\t');
        let (name, verdict) = (columns.next().unwrap(), columns.nth(1).unwrap());
        let reason = columns.next();
        total += 1;
        intended += usize::from(reason.is_some());
        let (ours, said) = ours(&cases.join(name));
        let theirs = theirs(&cases, name, verdict);
        let agree =
            ours.accepted == theirs.accepted && (ours.line == theirs.line || theirs.line.is_none());
        same += usize::from(agree);
        let mark = match (agree, reason) {
            (true, None) => "",
            (true, Some(_)) => {
                wrong.push(format!("{name} is listed as a difference, and agrees"));
                "listed"
            }
            (false, Some(reason)) => reason,
            (false, None) => {
                wrong.push(format!("{name}: ours {ours:?} [{said}], theirs {theirs:?}"));
                "DIFFERS"
            }
        };
        println!("{name:20} {:6} {:4} {mark}", ours.accepted, ours.line.unwrap_or(0));
    }
    println!("{same} of {total} agree, {intended} differ on purpose");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
