//! `genomctl fmt`: formats descriptions. No daemon.

use std::fs;
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};

use genom_description::source::{Disk, Files as _};
use genom_description_tools::{FormatError, format_bytes};

use serde_json::Value;

use crate::failure::Failure;
use crate::session::Session;

/// Format descriptions: adjusts indentation and blanks; keeps comments, line breaks and meaning.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The .gen files, rewritten if they change; `-` formats standard input to standard output.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Write nothing: show where a file would change, and exit with 1 if one would.
    #[arg(long)]
    check: bool,
    /// Print the result instead of writing it back.
    #[arg(long, conflicts_with = "check")]
    stdout: bool,
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let (mut unformatted, mut refused) = (0, 0);
    // With `--json`, one line for all files.
    let mut all = Vec::new();
    for path in &args.files {
        let piped = path == Path::new("-");
        let name = if piped { "<stdin>".into() } else { path.display().to_string() };
        let before = if piped {
            let mut bytes = Vec::new();
            io::stdin().lock().read_to_end(&mut bytes).map(|_| bytes)
        } else {
            Disk.read(path)
        };
        let before = before
            .map_err(|error| Failure::usage(format!("{name}: {error}"), "name a .gen file"))?;
        match format_bytes(&before) {
            Err(error) => {
                refused += 1;
                if session.json {
                    all.push(told(&name, "refused", Some(&error.to_string())));
                    continue;
                }
                io::stderr().lock().write_all(refusal(&name, &error).as_bytes())?;
            }
            Ok(after) if args.check => {
                let hint = hint(&name, &before, &after);
                unformatted += usize::from(hint.is_some());
                match hint {
                    Some(_) if session.json => all.push(told(&name, "to format", None)),
                    Some(hint) => session.print(&hint)?,
                    None => all.push(told(&name, "as it should be", None)),
                }
            }
            Ok(after) if (piped || args.stdout) && session.json => {
                let mut printed = told(&name, "printed", None);
                printed["text"] = String::from_utf8_lossy(&after).into();
                all.push(printed);
            }
            Ok(after) if piped || args.stdout => io::stdout().lock().write_all(&after)?,
            Ok(after) if after != before => {
                fs::write(path, after)
                    .map_err(|error| io::Error::new(error.kind(), format!("{name}: {error}")))?;
                all.push(told(&name, "formatted", None));
            }
            Ok(_) => all.push(told(&name, "as it should be", None)),
        }
    }
    if session.json {
        session.print(&format!("{}\n", serde_json::json!({ "files": all })))?;
    }
    match (unformatted, refused) {
        (0, 0) => Ok(()),
        (unformatted, refused) => Err(Failure::Format { unformatted, refused }),
    }
}

/// What was done with a file, for `--json`.
fn told(file: &str, what: &str, why: Option<&str>) -> Value {
    serde_json::json!({ "file": file, "outcome": what, "why": why })
}

fn refusal(name: &str, error: &FormatError) -> String {
    format!("error: {name}: {error}\n")
}

/// Maximum number of lines shown of each version.
const SHOWN: usize = 8;

/// The first block of lines that would change, in the form of `diff`; `None` if nothing would.
fn hint(name: &str, before: &[u8], after: &[u8]) -> Option<String> {
    if before == after {
        return None;
    }
    let (before, after) = (String::from_utf8_lossy(before), String::from_utf8_lossy(after));
    let old: Vec<_> = before.split('\n').collect();
    let new: Vec<_> = after.split('\n').collect();
    let first = old.iter().zip(&new).take_while(|(old, new)| old == new).count();
    let (old, new) = (old.get(first..).unwrap_or_default(), new.get(first..).unwrap_or_default());
    let last = old.iter().rev().zip(new.iter().rev()).take_while(|(old, new)| old == new).count();
    let mut text = format!("{name}:{}: would be formatted\n", first + 1);
    for (sign, lines) in [('-', old), ('+', new)] {
        let lines = lines.get(..lines.len() - last).unwrap_or_default();
        for line in lines.iter().take(SHOWN) {
            text.push_str(&format!("{sign}{line}\n"));
        }
        if lines.len() > SHOWN {
            text.push_str(&format!("{sign}... {} lines more\n", lines.len() - SHOWN));
        }
    }
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;

    #[test]
    fn the_hint_shows_what_changes_and_no_more() {
        let hint = hint("a.gen", b"x;\n  y;\nz;\n", b"x;\ny;\nz;\n").unwrap();
        expect![[r"
            a.gen:2: would be formatted
            -  y;
            +y;
        "]]
        .assert_eq(&hint);
    }

    #[test]
    fn a_long_hint_is_cut() {
        let hint = hint("a.gen", " x\n".repeat(20).as_bytes(), "x\n".repeat(20).as_bytes());
        let hint = hint.unwrap();
        assert_eq!(hint.lines().count(), 1 + 2 * (SHOWN + 1));
        assert!(hint.contains("-... 12 lines more\n"), "{hint}");
    }
}
