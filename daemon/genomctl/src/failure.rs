//! Why a verb failed, how the failure is printed, and its exit status.

use std::io;
use std::process::ExitCode;
use std::time::Duration;

use genom_protocol::{Code, Reason};
use genom_recording::WriteError;
use serde_json::{Value, json};

use crate::chosen::Chosen;
use crate::escape;
use crate::terminal::{Tone, coloured_errors};

/// Why a verb failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// The arguments are not valid. Nothing was sent.
    #[error("{message}")]
    Usage { message: String, help: Option<String> },
    /// No daemon can be reached.
    #[error("no genomd answers on {target}{}: {source}", by(chosen.as_ref()))]
    Unreachable { target: String, chosen: Option<Chosen>, source: io::Error },
    /// The daemon closed the connection during a reply or a stream.
    #[error("genomd on {target} went away")]
    Lost { target: String },
    /// The daemon accepts connections but answers no request.
    #[error(
        "genomd on {target} does not answer{}",
        stopped.map_or_else(
            || format!(", nor did it for {} s", limit.as_secs_f64()),
            |process| format!(": its process {process} is stopped"),
        )
    )]
    Silent { target: String, limit: Duration, stopped: Option<i32> },
    /// The daemon refused the request, which changed nothing.
    #[error("{}", .0.message)]
    Refused(Reason),
    /// The service ended with an exception.
    #[error("{what} ended with {exception}{}", members(.detail))]
    Exception { what: String, exception: String, detail: Value },
    /// The reply is not what a genomd of this version sends.
    #[error("the reply of genomd on {target} is not understood: {why}")]
    Reply { target: String, why: String },
    /// A description has errors; they were printed.
    #[error("{} in the description", counted(*.errors, *.warnings))]
    Description { errors: usize, warnings: usize },
    /// `fmt` found files to format or refused some; each was printed.
    #[error("{}", unformatted_files(*.unformatted, *.refused))]
    Format { unformatted: usize, refused: usize },
    /// `verify` found properties that do not hold, or could not decide; they were printed.
    #[error("{}", unproved(*.violated, *.undecided))]
    Verdict { violated: usize, undecided: usize },
    /// `schedule` found tasks that may be late, or of which it cannot tell; they were printed.
    #[error("{}", unscheduled(*.late, *.open))]
    Late { late: usize, open: usize },
    /// An error of a file or the terminal.
    #[error(transparent)]
    Io(#[from] io::Error),
}

fn plural(count: usize, word: &str) -> String {
    format!("{count} {word}{}", if count == 1 { "" } else { "s" })
}

fn unscheduled(late: usize, open: usize) -> String {
    match (late, open) {
        (0, open) => format!("no bound for {}", plural(open, "task")),
        (late, 0) => format!("{} may be late", plural(late, "task")),
        (late, open) => format!("{} may be late, no bound for {open}", plural(late, "task")),
    }
}

fn unproved(violated: usize, undecided: usize) -> String {
    let count = |count: usize| match count {
        1 => "1 property is".to_owned(),
        _ => format!("{count} properties are"),
    };
    match (violated, undecided) {
        (0, undecided) => format!("{} not decided", count(undecided)),
        (violated, 0) => format!("{} violated", count(violated)),
        (violated, undecided) => {
            format!("{} violated, {undecided} not decided", count(violated))
        }
    }
}

fn unformatted_files(unformatted: usize, refused: usize) -> String {
    match (unformatted, refused) {
        (unformatted, 0) => format!("{} to format", plural(unformatted, "file")),
        (0, refused) => format!("{} cannot be formatted", plural(refused, "file")),
        (unformatted, refused) => format!(
            "{} to format, {} cannot be formatted",
            plural(unformatted, "file"),
            plural(refused, "file")
        ),
    }
}

fn counted(errors: usize, warnings: usize) -> String {
    match (errors, warnings) {
        (0, warnings) => plural(warnings, "warning"),
        (errors, 0) => plural(errors, "error"),
        (errors, warnings) => {
            format!("{}, {}", plural(errors, "error"), plural(warnings, "warning"))
        }
    }
}

fn by(chosen: Option<&Chosen>) -> String {
    chosen.map_or_else(String::new, |chosen| format!(" ({chosen})"))
}

fn members(detail: &Value) -> String {
    match detail {
        Value::Null => String::new(),
        Value::Object(members) if members.is_empty() => String::new(),
        detail => format!(" {detail}"),
    }
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Self {
        let code = if matches!(error, WriteError::Full { .. }) { "full" } else { "file" };
        Self::refused(code, error.to_string())
    }
}

impl Failure {
    /// Invalid arguments, with advice.
    pub(crate) fn usage(message: impl Into<String>, help: impl Into<String>) -> Self {
        Failure::Usage { message: message.into(), help: Some(help.into()) }
    }

    /// An error of clap: its first line is the message; hints and usage are the advice.
    pub(crate) fn typed(told: &str) -> Self {
        let mut lines = told.lines().map(str::trim).filter(|line| !line.is_empty());
        let first = lines.next().unwrap_or_default();
        let message = first.strip_prefix("error: ").unwrap_or(first);
        let (help, more): (Vec<_>, Vec<_>) = lines
            .filter(|line| !line.starts_with("For more information"))
            .partition(|line| line.starts_with("tip:") || line.starts_with("Usage:"));
        let message = std::iter::once(message).chain(more).collect::<Vec<_>>().join(" ");
        let help = help.iter().map(|line| line.trim_start_matches("tip: ")).collect::<Vec<_>>();
        Self::usage(message, help.join("; "))
    }

    /// A refusal by genomctl itself, in the form of the daemon's.
    pub(crate) fn refused(code: &str, message: String) -> Self {
        Failure::Refused(Reason::new(code, message))
    }

    /// The same with advice.
    pub(crate) fn refused_with(code: &str, message: String, help: String) -> Self {
        Failure::Refused(Reason { help: Some(help), ..Reason::new(code, message) })
    }

    /// A recording could not be written or read.
    pub(crate) fn file(path: &std::path::Path, error: impl std::fmt::Display) -> Self {
        Self::refused("file", format!("{}: {error}", path.display()))
    }

    /// A recording ended before all samples had arrived.
    pub(crate) fn cut_short(path: &std::path::Path) -> Self {
        let message = format!("cut short: {} holds what came until then", path.display());
        Self::refused("cut_short", message)
    }

    /// The text for standard error.
    pub(crate) fn text(&self) -> String {
        let mut text = format!("error: {self}\n");
        if let Some(place) = self.place() {
            text.push_str(&format!("  at: {place}\n"));
        }
        if let Some(help) = self.help() {
            text.push_str(&format!("help: {help}\n"));
        }
        text
    }

    fn place(&self) -> Option<&str> {
        match self {
            Failure::Refused(reason) => reason.place.as_deref().filter(|at| !at.is_empty()),
            _ => None,
        }
    }

    fn help(&self) -> Option<String> {
        match self {
            Failure::Usage { help, .. } => help.clone(),
            // Failures of TLS have this kind.
            Failure::Unreachable { source, .. } if source.kind() == io::ErrorKind::InvalidData => {
                Some(
                    "--ca FILE names the root of the daemon's certificate, --cert yours".to_owned(),
                )
            }
            Failure::Unreachable { chosen: Some(chosen), .. } => Some(chosen.help()),
            Failure::Unreachable { .. } => Some(
                "start one with `genomd LIBRARY...`, or name its socket with --socket".to_owned(),
            ),
            Failure::Silent { stopped: Some(process), .. } => {
                Some(format!("`kill -CONT {process}` lets it go on, unless a debugger holds it"))
            }
            Failure::Silent { .. } => {
                Some("look at its process and its log; --timeout SECONDS waits longer".to_owned())
            }
            Failure::Refused(reason) => reason.help.clone(),
            _ => None,
        }
    }

    /// The failure in the form of the daemon's errors, for `--json`.
    fn data(&self) -> Value {
        let code = match self {
            Failure::Usage { .. } => "usage",
            Failure::Unreachable { .. } => "unreachable",
            Failure::Lost { .. } => "lost",
            Failure::Silent { .. } => "silent",
            Failure::Refused(reason) => &reason.code,
            // The outcome itself was printed on standard output already.
            Failure::Exception { .. } => "exception",
            Failure::Reply { .. } => "not_understood",
            Failure::Description { .. } => "description",
            Failure::Format { .. } => "format",
            Failure::Verdict { violated: 0, .. } | Failure::Late { late: 0, .. } => "undecided",
            Failure::Verdict { .. } | Failure::Late { .. } => "violated",
            Failure::Io(_) => "io",
        };
        json!({"error": {
            "code": code, "message": self.to_string(), "where": self.place(), "help": self.help(),
        }})
    }

    /// Prints the failure on standard error and returns the exit status; a closed pipe counts as
    /// success.
    pub(crate) fn report(self, json: bool) -> ExitCode {
        if let Failure::Io(error) = &self
            && error.kind() == io::ErrorKind::BrokenPipe
        {
            return ExitCode::SUCCESS;
        }
        use io::Write as _;
        let text = if json { escape::json(&format!("{}\n", self.data())) } else { self.text() };
        let text = match text.strip_prefix("error:") {
            Some(rest) if coloured_errors() => format!("{}{rest}", Tone::Bad.paint("error:")),
            _ => text,
        };
        let _ = io::stderr().lock().write_all(text.as_bytes());
        ExitCode::from(match self {
            Failure::Usage { .. } => 2,
            Failure::Unreachable { .. } | Failure::Lost { .. } | Failure::Silent { .. } => 3,
            Failure::Refused(reason) if reason.is(Code::DaemonSilent) => 3,
            Failure::Verdict { violated: 0, .. } | Failure::Late { late: 0, .. } => 4,
            _ => 1,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;

    #[test]
    fn a_refusal_tells_place_and_way_out() {
        let refusal = serde_json::from_value(json!({
            "code": "bad_input", "message": "goal: expected a number, found \"x\"",
            "where": "/goal", "help": "goal is a double",
        }));
        let failure = Failure::Refused(refusal.unwrap());
        expect![[r#"
            error: goal: expected a number, found "x"
              at: /goal
            help: goal is a double
        "#]]
        .assert_eq(&failure.text());
    }

    #[test]
    fn an_exception_shows_its_detail() {
        let failure = Failure::Exception {
            what: "demo/goto".into(),
            exception: "::demo::TOO_FAR".into(),
            detail: json!({"goal": 9.0}),
        };
        expect![[r#"
            error: demo/goto ended with ::demo::TOO_FAR {"goal":9.0}
        "#]]
        .assert_eq(&failure.text());
    }
}
