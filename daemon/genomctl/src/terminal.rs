//! Properties of the terminal: whether there is one, its width, whether to use colours.

use std::io::{self, IsTerminal as _, Write as _};

/// Standard output, as far as formatting depends on it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Terminal {
    /// Number of columns, if it is a terminal.
    pub(crate) width: Option<usize>,
    /// Whether to use colours.
    pub(crate) colour: bool,
}

impl Terminal {
    /// The properties of standard output.
    pub(crate) fn of_output() -> Self {
        let is_terminal = io::stdout().is_terminal();
        let size = is_terminal.then(crossterm::terminal::size);
        let width = size.and_then(Result::ok).map(|(width, _)| usize::from(width));
        let width = width.filter(|width| *width > 0);
        Self { width, colour: is_terminal && colours_welcome() }
    }
}

/// Neither `NO_COLOR` (no-color.org) nor a terminal without colours.
fn colours_welcome() -> bool {
    std::env::var_os("NO_COLOR").is_none_or(|set| set.is_empty())
        && std::env::var_os("TERM").is_some_and(|term| term != "dumb")
}

/// Whether there is a user to ask: standard input and output are terminals.
pub(crate) fn somebody_there() -> bool {
    io::stdin().is_terminal() && io::stderr().is_terminal()
}

/// Whether to use colours on standard error.
pub(crate) fn coloured_errors() -> bool {
    io::stderr().is_terminal() && colours_welcome()
}

/// Colour of a word that names a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tone {
    Good,
    Careful,
    Bad,
}

impl Tone {
    /// The tone of a state, a status or a level.
    pub(crate) fn of(word: &str) -> Option<Self> {
        Some(match word {
            "running" | "done" | "ok" => Tone::Good,
            "waiting" | "note" | "warn" | "WARN" | "stop" => Tone::Careful,
            "exception" | "failed" | "problem" | "error" | "ERROR" => Tone::Bad,
            _ => return None,
        })
    }

    fn code(self) -> &'static str {
        match self {
            Tone::Good => "\x1b[32m",
            Tone::Careful => "\x1b[33m",
            Tone::Bad => "\x1b[31m",
        }
    }

    /// The text in this tone's colour.
    pub(crate) fn paint(self, text: &str) -> String {
        format!("{}{text}\x1b[0m", self.code())
    }
}

/// One line on standard error that is overwritten while something takes long.
#[derive(Debug, Default)]
pub(crate) struct Progress {
    shown: bool,
}

impl Progress {
    /// Whether standard error is a terminal.
    pub(crate) fn seen(&self) -> bool {
        io::stderr().is_terminal()
    }

    /// Replaces the line; does nothing if standard error is not a terminal.
    pub(crate) fn show(&mut self, text: &str) {
        if self.seen() {
            // Some pseudo-terminals report zero columns.
            let size = crossterm::terminal::size().ok().filter(|(width, _)| *width > 0);
            let width = size.map_or(80, |(width, _)| usize::from(width));
            let text: String = text.chars().take(width.saturating_sub(1)).collect();
            let _ = write!(io::stderr().lock(), "\r\x1b[2K{text}");
            let _ = io::stderr().lock().flush();
            self.shown = true;
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if self.shown {
            let _ = write!(io::stderr().lock(), "\r\x1b[2K");
        }
    }
}
