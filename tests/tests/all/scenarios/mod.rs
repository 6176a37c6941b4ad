//! `genomctl test`: the project's own scenarios (`tests/scenarios`), and what is told of those that
//! do not pass.

mod failures;
mod played;
mod python;
mod refused;

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use genom_tests::{Finished, Running, component, program, repository};
use tempfile::TempDir;

/// A directory with scenarios, and with components in `lib`.
struct Place(TempDir);

impl Place {
    fn new() -> Self {
        let place = Self(TempDir::new().unwrap());
        place.link("demo", "demo");
        fs::create_dir(place.path("tmp")).unwrap();
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Puts a component of the repository into `lib`, under a name.
    fn link(&self, of: &str, name: &str) {
        let made = component(of);
        let directory = self.path("lib");
        fs::create_dir_all(&directory).unwrap();
        // A library, or a script, by its extension.
        for from in [made.library, made.description] {
            let extension = from.extension().unwrap().to_owned();
            let to = directory.join(name).with_extension(extension);
            std::os::unix::fs::symlink(from, to).unwrap();
        }
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    /// Starts `genomctl test` here; nothing of the user's is used.
    fn start(&self, arguments: &[&str]) -> Running {
        let mut command = Command::new(program("genomctl"));
        command.env_clear().env("PATH", std::env::var_os("PATH").unwrap_or_default());
        command.env("TMPDIR", self.path("tmp")).env("XDG_CONFIG_HOME", self.path("config"));
        command.env("XDG_STATE_HOME", self.path("state")).current_dir(self.0.path());
        command.env("PYTHONPATH", repository().join("clients/python/src"));
        command.env("PYTHONDONTWRITEBYTECODE", "1");
        command.arg("test").arg("--genomd").arg(program("genomd")).args(arguments);
        Running::start(&mut command)
    }

    fn test(&self, arguments: &[&str]) -> Finished {
        self.start(arguments).finish()
    }

    /// What is there of daemons that genomctl started.
    fn left(&self) -> Vec<PathBuf> {
        let all = fs::read_dir(self.path("tmp")).unwrap();
        let mine = |path: &PathBuf| {
            let path = path.to_string_lossy();
            path.contains("genomctl-test-") || path.contains("gtest-")
        };
        all.map(|entry| entry.unwrap().path()).filter(mine).collect()
    }
}

/// A file with one scenario of these steps, each on a line of its own from the sixth on.
fn steps(components: &str, steps: &[&str]) -> String {
    let steps = steps.join(",\n");
    format!(
        "path = [\"lib\"]\ncomponents = {components}\n[[scenario]]\nname = \"a\"\nsteps = [\n{steps},\n]\n"
    )
}

/// Where the scenarios of the project are.
fn scenarios() -> PathBuf {
    repository().join("tests/scenarios")
}
