//! A reader's machine: genomd installed below a prefix, the examples of the book in the home.

use std::cell::RefCell;
use std::fs;
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::path::PathBuf;
use std::process::Command;

use genom_components::{Paths, python};
use genom_tests::{Memory, Running, WATCHDOG, component, copy_folder, path, program, repository};
use tempfile::TempDir;

use super::console::Step;

/// Directory and link of the same name that a page shows as a user's home.
const HOME: &str = "/home/you";

/// CMake and its generator, from the registry of Python's packages.
const CMAKE: [&str; 2] = ["cmake==3.31.6", "ninja==1.11.1.4"];

pub(super) struct Place {
    root: TempDir,
    memory: Memory,
    /// Running daemons, by the socket they were given.
    daemons: RefCell<Vec<(String, Running)>>,
}

impl Place {
    pub(super) fn new() -> Self {
        let place = Self {
            root: TempDir::new().unwrap(),
            memory: Memory::new(),
            daemons: RefCell::default(),
        };
        for name in ["home", "run", "prefix/bin", "prefix/lib/genomd", "bin"] {
            fs::create_dir_all(place.path(name)).unwrap();
            let private = fs::Permissions::from_mode(0o700);
            fs::set_permissions(place.path(name), private).unwrap();
        }
        for name in ["genomd", "genomctl"] {
            let installed = place.path("prefix/bin").join(name);
            if fs::hard_link(program(name), &installed).is_err() {
                fs::copy(program(name), installed).unwrap();
            }
        }
        let mut sdk = Command::new(place.path("prefix/bin/genomctl"));
        Running::start(sdk.arg("sdk").arg(place.path("prefix"))).finish().expect_code(0);
        for name in ["demo", "mission"] {
            let made = component(name);
            for file in [&made.library, &made.description] {
                let to = place.path("prefix/lib/genomd").join(file.file_name().unwrap());
                fs::copy(file, to).unwrap();
            }
        }
        // genomd on shared memory and networks that no other test uses.
        let genomd = format!(
            "#!/bin/sh\nexec {:?} --set backends.shm.prefix={} --set backends.shm.root={:?} \
             --set backends.zenoh.rendezvous={:?} --set backends.ros2.domain={} \
             --set backends.ros2.namespace={} \"$@\"\n",
            place.path("prefix/bin/genomd"),
            place.memory.prefix(),
            place.memory.root(),
            place.memory.root().join("zenoh"),
            place.memory.domain(),
            place.memory.prefix().trim_end_matches('_'),
        );
        fs::write(place.path("bin/genomd"), genomd).unwrap();
        let executable = fs::Permissions::from_mode(0o700);
        fs::set_permissions(place.path("bin/genomd"), executable).unwrap();
        copy_folder(&repository().join("docs/book/examples"), &place.path("home"));
        symlink(repository(), place.path("home/genomd")).unwrap();
        // What components in Rust are made of is compiled once, for all tests.
        let shared = Paths::of_workspace().unwrap().target.join("readme");
        fs::create_dir_all(&shared).unwrap();
        symlink(shared, place.path("home/picker/target")).unwrap();
        fs::copy(repository().join("Cargo.lock"), place.path("home/picker/Cargo.lock")).unwrap();
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.root.path().join(name)
    }

    /// Writes a file that the page shows.
    pub(super) fn write(&self, name: &str, text: &str) {
        let file = self.path("home").join(name);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, text).unwrap();
    }

    fn start(&self, command: &str) -> Running {
        let cmake = python::environment(&CMAKE).unwrap_or_else(|error| panic!("{error}"));
        let variable = |name: &str| std::env::var(name).unwrap_or_default();
        let programs = format!(
            "{}:{}:{}:{}",
            self.path("bin").display(),
            self.path("prefix/bin").display(),
            cmake.parent().unwrap().display(),
            variable("PATH"),
        );
        let own = |name: &str, usual: &str| match variable(name) {
            set if set.is_empty() => format!("{}/{usual}", variable("HOME")),
            set => set,
        };
        let mut shell = Command::new("sh");
        shell
            .env_clear()
            .env("PATH", programs)
            .env("HOME", self.path("home"))
            .env("XDG_RUNTIME_DIR", self.path("run"))
            .env("CMAKE_PREFIX_PATH", self.path("prefix"))
            .env("CMAKE_GENERATOR", "Ninja")
            .env("CARGO_HOME", own("CARGO_HOME", ".cargo"))
            .env("RUSTUP_HOME", own("RUSTUP_HOME", ".rustup"))
            .env("PYTHONPATH", repository().join("clients/python/src"))
            .env("PYTHONDONTWRITEBYTECODE", "1")
            .current_dir(self.path("home"))
            .args(["-c", command]);
        Running::start(&mut shell)
    }

    /// Runs a command, and gives the lines that it prints.
    #[track_caller]
    pub(super) fn run(&self, step: &Step) -> Vec<String> {
        let command = step.command.trim();
        if is_daemon(command) {
            return self.daemon(command);
        }
        // A build may take long on a busy machine.
        let running = self.start(&format!("{{ {command}\n}} 2>&1"));
        let finished = running.finish_within(5 * WATCHDOG);
        let told: Vec<String> = finished.out.lines().map(|line| self.unnamed(line)).collect();
        let refused = told.iter().any(|line| line.starts_with("error"));
        let error_shown = step.shown.iter().any(|line| line.starts_with("error"));
        let as_shown = finished.code == Some(0) || refused && error_shown;
        assert!(as_shown, "`{command}` ends with {:?}:\n{}", finished.code, told.join("\n"));
        told
    }

    fn daemon(&self, command: &str) -> Vec<String> {
        let socket = command.split_once("--socket ").map_or("", |(_, rest)| rest);
        let socket = socket.split(' ').next().unwrap_or_default();
        self.stop(Some(socket));
        let running = self.start(&format!("exec {command}"));
        let told = RefCell::new(Vec::new());
        let ready = running.error_line_where(|line| {
            told.borrow_mut().push(self.unnamed(line));
            line.contains("ready on ")
        });
        if ready.is_none() {
            panic!("`{command}` does not start:\n{}", running.finish().err);
        }
        self.daemons.borrow_mut().push((socket.to_owned(), running));
        told.into_inner()
    }

    /// A line as a user would see it, whose name is `you`.
    fn unnamed(&self, line: &str) -> String {
        let line = line.replace(path(&self.path("home")), HOME);
        let line = line.replace(path(&self.path("run")), "/run/user/1000");
        line.replace(path(&self.path("prefix")), "/usr")
    }

    /// Stops the daemon at this socket, or all of them, as Ctrl-C does; they must end normally.
    pub(super) fn stop(&self, socket: Option<&str>) {
        let (stop, keep): (Vec<_>, Vec<_>) = self
            .daemons
            .take()
            .into_iter()
            .partition(|(at, _)| socket.is_none_or(|socket| socket == at));
        self.daemons.replace(keep);
        for (_, running) in stop {
            running.signal("INT");
            running.finish().expect_code(0);
        }
    }
}

/// Whether a command starts a daemon, which is left running.
fn is_daemon(command: &str) -> bool {
    let other = ["--check", "--version", "--help", "--dump-config", "--man", "--completion"];
    command.starts_with("genomd ") && !other.iter().any(|option| command.contains(option))
}
