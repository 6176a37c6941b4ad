//! Blocks marked `console`: commands after `$`, each with what it prints on the terminal.
//!
//! `…` within a line stands for any text, as a line for any number of lines.

use std::fmt::Write as _;

/// A command, with the lines that follow it on the page.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Step {
    pub(super) command: String,
    pub(super) shown: Vec<String>,
}

/// A part of a page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Text, and blocks that are no sessions, as they are.
    Text(String),
    /// A block that a line before it names: "`robot.toml`:".
    File(String, String),
    /// A session.
    Session(Vec<Step>),
}

/// The parts of a page, which joined are the page.
pub(super) fn parts(page: &str) -> Vec<Part> {
    let mut parts = Vec::new();
    let mut text = String::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        let Some(language) = line.strip_prefix("```") else {
            text.push_str(line);
            text.push('\n');
            continue;
        };
        let block: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
        if language == "console" {
            parts.push(Part::Text(std::mem::take(&mut text)));
            parts.push(Part::Session(steps(&block)));
            continue;
        }
        let named = text.trim_end().strip_suffix("`:").and_then(|it| it.rsplit('`').next());
        if let Some(name) = named.filter(|name| name.contains('.')) {
            let name = name.to_owned();
            parts.push(Part::File(name, block.iter().map(|line| format!("{line}\n")).collect()));
        }
        let _ = writeln!(text, "{line}\n{}\n```", block.join("\n"));
    }
    parts.push(Part::Text(text));
    parts
}

fn steps(block: &[&str]) -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    for line in block {
        match (line.strip_prefix("$ "), steps.last_mut()) {
            (Some(command), _) => {
                steps.push(Step { command: command.to_owned(), shown: Vec::new() });
            }
            (None, Some(step)) if step.command.ends_with('\\') => {
                step.command.push('\n');
                step.command.push_str(line);
            }
            (None, Some(step)) => step.shown.push((*line).to_owned()),
            (None, None) => panic!("a session begins with a command after `$ `: {line}"),
        }
    }
    steps
}

impl Step {
    /// Whether what came is what is shown.
    pub(super) fn allows(&self, came: &[String]) -> bool {
        allows(&self.shown, came)
    }

    /// The step with what came; lines that are shown with `…` stay where they fit.
    pub(super) fn with(&self, came: &[String]) -> Self {
        if self.allows(came) {
            return self.clone();
        }
        let line = |line: &String| {
            let mut kept = self.shown.iter().filter(|shown| *shown != "…" && shown.contains('…'));
            kept.find(|shown| fits(shown, line)).unwrap_or(line).clone()
        };
        Self { command: self.command.clone(), shown: came.iter().map(line).collect() }
    }

    /// The step as on the page.
    pub(super) fn text(&self) -> String {
        let shown: String = self.shown.iter().map(|line| format!("{line}\n")).collect();
        format!("$ {}\n{shown}", self.command)
    }
}

fn allows(shown: &[String], came: &[String]) -> bool {
    match shown.split_first() {
        None => came.is_empty(),
        Some((first, rest)) if first == "…" => {
            (0..=came.len()).any(|skipped| allows(rest, &came[skipped..]))
        }
        Some((first, rest)) => came
            .split_first()
            .is_some_and(|(line, others)| fits(first, line) && allows(rest, others)),
    }
}

/// Whether a line is as shown.
fn fits(shown: &str, line: &str) -> bool {
    let mut pieces = shown.split('…');
    let Some(mut rest) = pieces.next().and_then(|first| line.strip_prefix(first)) else {
        return false;
    };
    let pieces: Vec<&str> = pieces.collect();
    let Some((last, middle)) = pieces.split_last() else { return rest.is_empty() };
    for piece in middle {
        let Some(at) = rest.find(piece) else { return false };
        rest = &rest[at + piece.len()..];
    }
    rest.ends_with(last)
}

#[test]
fn what_is_left_out_of_a_session_may_be_anything_and_the_rest_is_as_shown() {
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
    let step = Step { command: "x".to_owned(), shown: lines("a … c\n…\nend") };
    assert!(step.allows(&lines("a b c\nend")));
    assert!(step.allows(&lines("a  c\n1\n2\nend")));
    assert!(!step.allows(&lines("a b d\nend")));
    assert!(!step.allows(&lines("a b c\nend\nmore")));
    assert_eq!(step.with(&lines("a b c\nother")).shown, lines("a … c\nother"));
}

#[test]
fn a_page_is_read_into_sessions_files_and_text() {
    let page = "A.\n\n```console\n$ one \\\n  two\nout\n$ three\n```\n\n`f.toml`:\n\n```toml\na = 1\n```\n";
    let [Part::Text(_), Part::Session(steps), Part::File(name, text), Part::Text(_)] =
        &parts(page)[..]
    else {
        panic!("{:?}", parts(page));
    };
    assert_eq!(steps[0], Step { command: "one \\\n  two".to_owned(), shown: vec!["out".into()] });
    assert_eq!(steps[1].command, "three");
    assert_eq!((name.as_str(), text.as_str()), ("f.toml", "a = 1\n"));
}
