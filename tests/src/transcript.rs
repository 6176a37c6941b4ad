//! Transcripts: commands as a user types them, with the exact output each must give.
//!
//! The first characters of a line tell what it is:
//!
//! | | |
//! |---|---|
//! | `# TEXT` | for the reader |
//! | `@ genomd ARGUMENTS` | starts the daemon of the transcript |
//! | `@ file NAME` | the lines that follow, indented by four, are put into a file |
//! | `$ COMMAND` | a line for the shell; `genomctl` talks to the daemon |
//! | `! TEXT` | standard error must have this line |
//! | `? STATUS` | exit status, when it is not 0 |
//! | anything else | standard output must have this line; after `\` if it starts as above |
//!
//! `{demo}` stands for the library of a component, `{home}` for the working directory. `[..]`
//! stands for any text within a line, for what depends on the machine. With `UPDATE_EXPECT=1` in
//! the environment, the file is rewritten with the actual output.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{Daemon, Home, Running, component, path, program};

/// One command with its actual or expected output.
struct Step {
    command: String,
    output: Vec<String>,
}

/// Runs a transcript and compares; on a difference it panics and shows both.
///
/// # Panics
/// If the output differs.
#[track_caller]
pub fn transcript(file: &Path) {
    let text =
        std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let mut stage = Stage { home: Some(Home::new()), daemon: None, names: Vec::new() };
    let (mut came, mut differs) = (String::new(), false);
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        came.push_str(line);
        came.push('\n');
        if let Some(arguments) = line.strip_prefix("@ genomd") {
            stage.start(arguments);
        } else if let Some(name) = line.strip_prefix("@ file ") {
            let mut content = String::new();
            while let Some(line) = lines.next_if(|line| line.starts_with("    ")) {
                content.push_str(&format!("{}\n", &line[4..]));
                came.push_str(&format!("{line}\n"));
            }
            let content = stage.named(&content);
            std::fs::write(stage.path().join(name), content).expect("a file can be written");
        } else if let Some(command) = line.strip_prefix("$ ") {
            let output = stage.run(command);
            let mut wanted = Vec::new();
            while let Some(line) = lines.next_if(|line| !starts_step(line)) {
                wanted.push(line.to_owned());
            }
            // An empty line before the next step only separates steps.
            let blank = wanted.last().is_some_and(String::is_empty)
                && output.last().is_none_or(|line| !line.is_empty());
            if blank {
                wanted.pop();
            }
            let (wanted, output) = (
                Step { command: command.to_owned(), output: wanted },
                Step { command: command.to_owned(), output },
            );
            differs |= !wanted.allows(&output);
            came.push_str(&wanted.merged(&output));
            if blank {
                came.push('\n');
            }
        }
    }
    if !differs {
        return;
    }
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        std::fs::write(file, came).expect("the transcript can be written");
        return;
    }
    panic!("{}: another output; UPDATE_EXPECT=1 takes it over. It is:\n{came}", file.display());
}

fn starts_step(line: &str) -> bool {
    ["$ ", "@ ", "# "].iter().any(|mark| line.starts_with(mark))
}

impl Step {
    fn allows(&self, came: &Step) -> bool {
        self.output.len() == came.output.len()
            && self.output.iter().zip(&came.output).all(|(wanted, line)| matches(wanted, line))
    }

    /// The actual output; where an expected line matches it, that line.
    fn merged(&self, came: &Step) -> String {
        let same = self.output.len() == came.output.len();
        let line = |(rank, line): (usize, &String)| {
            let kept =
                self.output.iter().find(|wanted| wanted.contains("[..]") && matches(wanted, line));
            let aligned = self.output.get(rank).filter(|wanted| same && matches(wanted, line));
            format!("{}\n", aligned.or(kept).unwrap_or(line))
        };
        debug_assert_eq!(self.command, came.command);
        came.output.iter().enumerate().map(line).collect()
    }
}

/// Whether a line is as expected; `[..]` matches any text.
fn matches(wanted: &str, line: &str) -> bool {
    let mut parts = wanted.split("[..]");
    let Some(mut rest) = parts.next().and_then(|first| line.strip_prefix(first)) else {
        return false;
    };
    let parts: Vec<&str> = parts.collect();
    let Some((last, middle)) = parts.split_last() else { return rest.is_empty() };
    for part in middle {
        let Some(at) = rest.find(part) else { return false };
        rest = &rest[at + part.len()..];
    }
    rest.ends_with(last)
}

/// State of a running transcript.
struct Stage {
    /// Present until the daemon starts.
    home: Option<Home>,
    daemon: Option<Daemon>,
    /// Placeholders and their paths.
    names: Vec<(String, PathBuf)>,
}

impl Stage {
    fn path(&self) -> PathBuf {
        let home = self.home.as_ref().or(self.daemon.as_ref().map(Daemon::home));
        home.expect("a home").path().to_owned()
    }

    fn start(&mut self, arguments: &str) {
        let arguments: Vec<String> =
            arguments.split_whitespace().map(|word| self.named(word)).collect();
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let home = self.home.take().expect("one daemon a transcript");
        self.daemon = Some(home.start(&arguments));
    }

    /// Replaces placeholders by paths.
    fn named(&mut self, text: &str) -> String {
        let text = text.replace("{home}", path(&self.path()));
        let mut pieces = text.split('{');
        let mut out = pieces.next().unwrap_or_default().to_owned();
        for piece in pieces {
            let is_name = |name: &str| {
                !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-')
            };
            match piece.split_once('}').filter(|(name, _)| is_name(name)) {
                Some((name, after)) => {
                    let library = component(name).library;
                    out.push_str(path(&library));
                    out.push_str(after);
                    if self.names.iter().all(|(known, _)| known != name) {
                        self.names.push((name.to_owned(), library));
                    }
                }
                None => {
                    out.push('{');
                    out.push_str(piece);
                }
            }
        }
        out
    }

    /// Replaces paths by placeholders.
    fn unnamed(&self, line: &str) -> String {
        let home = self.path();
        let mut line = line.replace(path(&home), "{home}");
        for (name, library) in &self.names {
            line = line.replace(path(library), &format!("{{{name}}}"));
        }
        line
    }

    fn run(&mut self, command: &str) -> Vec<String> {
        let socket = match (&self.home, &self.daemon) {
            (Some(home), _) => home.socket(),
            (None, Some(daemon)) => daemon.home().socket(),
            (None, None) => PathBuf::new(),
        };
        let line = self.named(command);
        let programs = program("genomctl").parent().expect("in a directory").to_owned();
        let system = std::env::var("PATH").unwrap_or_default();
        let mut shell = Command::new("sh");
        shell
            .env_clear()
            .env("PATH", format!("{}:{system}", programs.display()))
            .env("HOME", self.path())
            .env("GENOMD_SOCKET", socket)
            .current_dir(self.path())
            .args(["-c", &line]);
        let finished = Running::start(&mut shell).finish();
        let mut output = Vec::new();
        for line in finished.out.lines() {
            let line = self.unnamed(line);
            let escaped = ["$ ", "! ", "? ", "@ ", "# ", "\\"].iter().any(|m| line.starts_with(m));
            output.push(if escaped { format!("\\{line}") } else { line });
        }
        let told = finished.err.lines().map(|line| format!("! {}", self.unnamed(line)));
        output.extend(told.map(|line| line.trim_end().to_owned()));
        match finished.code {
            Some(0) => {}
            Some(code) => output.push(format!("? {code}")),
            None => output.push("? killed".to_owned()),
        }
        output
    }
}
