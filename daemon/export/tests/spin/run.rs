//! Runs Spin on a model.

use std::path::Path;
use std::process::Command;

use genom_export::{Format, export, fairness};
use genom_formal::{Limits, System, Times};

/// A model that Spin has made a program of.
pub(crate) struct Checked {
    folder: tempfile::TempDir,
    timed: bool,
}

/// What that program found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Found {
    pub(crate) errors: u64,
    pub(crate) states: u64,
}

impl Checked {
    /// Spin's program for this component; with times if there are any.
    pub(crate) fn new(system: &System, times: Option<&Times>) -> Self {
        let text = export(system, Format::Promela, times, &Limits::default()).unwrap();
        Self::of(&text, times.is_some())
    }

    /// The same for a model.
    pub(crate) fn of(text: &str, timed: bool) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("model.pml"), text).unwrap();
        let checked = Self { folder, timed };
        let time: &[&str] = if checked.timed { &["-DTIME"] } else { &[] };
        let spin = genom_components::debian::spin().unwrap_or_else(|error| panic!("{error}"));
        run(&spin, &[time, &["-a", "model.pml"]].concat(), checked.folder.path());
        checked
    }

    /// All states, and whether an assertion fails or one has no next step.
    pub(crate) fn all(&self) -> Option<Found> {
        self.compiled("all", &["-DNOCLAIM"]);
        self.found("all", &[])
    }

    /// Whether a claim fails.
    pub(crate) fn claim(&self, name: &str) -> Option<bool> {
        if !self.folder.path().join("claims").exists() {
            self.compiled("claims", &[]);
        }
        Some(self.found("claims", &["-N", name])?.errors > 0)
    }

    /// Whether a formula of a user fails, if each process goes on that can.
    pub(crate) fn user(&self, name: &str) -> Option<bool> {
        let path = self.folder.path();
        if !path.join("user").exists() {
            let model = std::fs::read_to_string(path.join("model.pml")).unwrap();
            let fair = format!("-DNFAIR={}", fairness(&model));
            let all = ["-O0", "-w", &fair, "-DMEMLIM=2048", "-DVECTORSZ=4096", "-o", "user"];
            run(Path::new("cc"), &[&all[..], &["pan.c"]].concat(), path);
        }
        Some(self.found("user", &["-a", "-f", "-N", name])?.errors > 0)
    }

    fn compiled(&self, program: &str, options: &[&str]) {
        let all = ["-O0", "-w", "-DSAFETY", "-DMEMLIM=2048", "-o", program, "pan.c"];
        run(Path::new("cc"), &[&all[..], options].concat(), self.folder.path());
    }

    /// `None` if it came to a limit before it had seen all or found an error.
    fn found(&self, program: &str, options: &[&str]) -> Option<Found> {
        let path = self.folder.path().join(program);
        let options = [&["-m2000000"], options].concat();
        let text = run(&path, &options, self.folder.path());
        let limits = ["max search depth too small", "reached -DMEMLIM", "out of memory"];
        let number = |from: &str, before: bool| {
            let at = text.find(from).unwrap_or_else(|| panic!("no `{from}` in: {text}"));
            let part = if before { &text[..at] } else { &text[at + from.len()..] };
            let word = if before {
                part.split_whitespace().next_back()
            } else {
                part.split_whitespace().next()
            };
            word.unwrap().parse::<f64>().unwrap() as u64
        };
        let states = number("states, stored", true);
        let found = Found { errors: number("errors:", false), states };
        let ended = limits.iter().any(|limit| text.contains(limit));
        (found.errors > 0 || !ended).then_some(found)
    }
}

fn run(program: &Path, arguments: &[&str], folder: &Path) -> String {
    let named = program.display();
    let output = Command::new(program).args(arguments).current_dir(folder).output();
    let output = output.unwrap_or_else(|error| panic!("{named}: {error}"));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        output.status.success(),
        "{named} {arguments:?}: {}\n{text}\n{}",
        output.status,
        String::from_utf8_lossy(&output.stderr)
    );
    text
}
