//! Every command in the README and the other pages is run as printed, in order, or is listed here
//! with the reason why not.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fs;
use std::net::TcpListener;
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;

use genom_tests::{Memory, Running, component, files, path, program, repository};
use tempfile::TempDir;

/// Beginnings of commands that are not run here, with what runs them or the reason.
const ELSEWHERE: &[(&str, &str)] = &[
    ("cargo demo", "components/build/tests/demos.rs"),
    ("cargo test", "what this is part of"),
    ("cargo quick", "a part of `cargo test`"),
    ("cargo bench", "minutes; benchmarks are compiled by the lints"),
    (
        "cargo conformance",
        "its tests are part of `cargo test`; the table of `tests/src/conformance.rs`",
    ),
    ("cargo faults", "tests/tests/all/components/trials.rs runs the short course"),
    ("cargo +nightly", "wants another toolchain"),
    ("rustup ", "wants another toolchain"),
    ("export MIRIFLAGS", "wants another toolchain"),
    ("export RUSTFLAGS", "wants another toolchain"),
    ("tsan", "wants another toolchain"),
    ("cargo build -p genomd --features rustix/use-libc", "wants valgrind"),
    ("valgrind", "wants valgrind"),
    ("openssl", "middlewares/zenoh/tests/tls.rs makes its certificates without it"),
    ("printf 'subjectAltName", "goes with openssl"),
    ("chmod 600 machine.key", "goes with openssl"),
    ("packaging/", "packaging/deb/check and packaging/wheel/check, which `.ci/run` calls"),
    ("sudo apt install ./genomd", "packaging/deb/check, which `.ci/run` calls"),
    ("sudo systemctl ", "wants systemd"),
    ("sudo -u genomd genomctl", "packaging/deb/check, which `.ci/run` calls"),
    ("pip install ", "packaging/wheel/check, which `.ci/run` calls"),
    ("cargo install ", "minutes"),
    ("genomctl bench ", "minutes; tests/tests/all/deployment/compared.rs"),
    ("genomctl sdk ", "tests/tests/all/projects/mod.rs"),
    ("export PATH=~/.local", "tests/tests/all/projects/autotools.rs"),
    ("autoreconf -i", "tests/tests/all/projects/autotools.rs"),
    ("./configure --prefix", "tests/tests/all/projects/autotools.rs"),
    ("make install", "tests/tests/all/projects/autotools.rs"),
    ("genomd --path ~/.local axis", "tests/tests/all/projects/autotools.rs"),
    // On a busy machine the viewer takes a second to write a file, and requests meanwhile are
    // refused: `held_up`.
    ("genomctl start --wait viewer sheet", "tests/tests/all/deployment/pipeline.rs"),
    ("python3 -m venv target/mujoco", "tests/tests/all/deployment/simulated.rs"),
    ("target/mujoco/bin/", "tests/tests/all/deployment/simulated.rs"),
    ("PKG_CONFIG_PATH=target/mujoco", "tests/tests/all/deployment/simulated.rs"),
    ("genomd --config configs/sim-arm.toml", "tests/tests/all/deployment/simulated.rs"),
    ("genomd --config configs/sim-quadrotor.toml", "tests/tests/all/deployment/quadrotor.rs"),
    ("genomctl start hover", "tests/tests/all/deployment/quadrotor.rs"),
    ("python components/sim/blender.py", "wants Blender, 1 GB"),
    ("genomctl start planner", "tests/tests/all/deployment/simulated.rs"),
    ("genomctl plot sim/", "tests/tests/all/deployment/simulated.rs"),
    ("cd docs/editors/vscode", "tests/tests/all/editors/vscode.rs"),
    ("npm ", "tests/tests/all/editors/vscode.rs"),
    ("code --install-extension", "wants Visual Studio Code"),
    ("genomctl header -I idl NAME.gen", "NAME is the reader's: `fixture` of genom-tests does it"),
    ("touch acNAME.h", "NAME is the reader's"),
    ("cc -g -fPIC -shared -I plugin-api/include -I . *.c", "NAME is the reader's"),
    ("genomd -I idl NAME.so", "NAME is the reader's"),
];

/// Commands that run until they are interrupted.
const ENDLESS: &[&str] = &["genomctl echo ", "genomctl hz ", "genomctl bw ", "genomctl events"];

/// May exit with a status other than 0, depending on the machine.
const MAY_COMPLAIN: &str = "genomctl doctor";

/// The commands of a page's `sh` blocks, and the files that it shows.
#[derive(Default)]
struct Page {
    commands: Vec<String>,
    files: Vec<(String, String)>,
}

impl Page {
    fn read(file: &Path) -> Self {
        let text = fs::read_to_string(file).unwrap();
        let mut page = Self::default();
        let mut pieces = text.split("\n```");
        let mut before = pieces.next().unwrap_or_default();
        while let (Some(block), Some(after)) = (pieces.next(), pieces.next()) {
            let (language, body) = block.split_once('\n').unwrap_or((block, ""));
            let named = before.trim_end().strip_suffix("`:").and_then(|it| it.rsplit('`').next());
            match (language, named) {
                ("sh", _) => page.commands.extend(commands(body)),
                (_, Some(name)) if name.contains('.') => {
                    page.files.push((name.to_owned(), format!("{body}\n")));
                }
                _ => {}
            }
            before = after;
        }
        page
    }
}

/// Lines; those that end with `\` are joined with the next.
fn commands(block: &str) -> Vec<String> {
    let joined = block.replace("\\\n", " ");
    let lines = joined.lines().map(str::trim).filter(|line| !line.is_empty());
    lines.filter(|line| !line.starts_with('#')).map(str::to_owned).collect()
}

fn elsewhere(command: &str) -> Option<usize> {
    ELSEWHERE.iter().position(|(begin, _)| command.starts_with(begin))
}

/// A directory that looks like the repository after `cargo demo`, with a separate home for the
/// user's files.
struct Place {
    root: TempDir,
    memory: Memory,
    /// Replaces the address on the pages.
    address: String,
    /// Running daemons, by the socket they were given.
    daemons: RefCell<Vec<(String, Running)>>,
}

impl Place {
    fn new() -> Self {
        let root = TempDir::new().unwrap();
        for name in ["configs", "plugin-api", "components"] {
            symlink(repository().join(name), root.path().join(name)).unwrap();
        }
        let built = root.path().join("target/components");
        fs::create_dir_all(&built).unwrap();
        for name in ["demo", "mission", "camera", "stereo", "viewer"] {
            let made = component(name).library;
            symlink(made.parent().unwrap(), built.join(name)).unwrap();
        }
        let place =
            Self { root, memory: Memory::new(), address: free(), daemons: RefCell::default() };
        for name in ["run", "home", "bin"] {
            fs::create_dir(place.path(name)).unwrap();
            fs::set_permissions(place.path(name), fs::Permissions::from_mode(0o700)).unwrap();
        }
        // genomd on shared memory and a network that nobody else uses.
        let genomd = format!(
            "#!/bin/sh\nexec {:?} --set backends.shm.prefix={} --set backends.shm.root={:?} \
             --set backends.zenoh.rendezvous={:?} \"$@\"\n",
            program("genomd"),
            place.memory.prefix(),
            place.memory.root(),
            place.memory.root().join("zenoh"),
        );
        fs::write(place.path("bin/genomd"), genomd).unwrap();
        fs::set_permissions(place.path("bin/genomd"), fs::Permissions::from_mode(0o700)).unwrap();
        symlink(program("genomctl"), place.path("bin/genomctl")).unwrap();
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.root.path().join(name)
    }

    fn start(&self, command: &str) -> Running {
        // The only difference from what is printed: another test or daemon may use that address.
        let command = command.replace("127.0.0.1:7300", &self.address);
        let system = std::env::var("PATH").unwrap_or_default();
        let mut shell = Command::new("sh");
        shell
            .env_clear()
            .env("PATH", format!("{}:{system}", path(&self.path("bin"))))
            .env("XDG_RUNTIME_DIR", self.path("run"))
            .env("HOME", self.path("home"))
            .current_dir(self.root.path())
            .args(["-c", &command]);
        Running::start(&mut shell)
    }

    #[track_caller]
    fn run(&self, command: &str) {
        if command.starts_with("genomd ") {
            let socket = command.split_once("--socket ").map_or("", |(_, rest)| rest);
            let socket = socket.split(' ').next().unwrap_or_default();
            self.stop(Some(socket));
            let running = self.start(&format!("exec {command}"));
            if running.error_line_where(|line| line.contains("ready on ")).is_none() {
                panic!("`{command}` does not start:\n{}", running.finish().err);
            }
            self.daemons.borrow_mut().push((socket.to_owned(), running));
            return;
        }
        let finished = if ENDLESS.iter().any(|begin| command.starts_with(begin)) {
            let running = self.start(&format!("exec {command}"));
            running.line();
            running.signal("INT");
            running.finish()
        } else {
            self.start(command).finish()
        };
        let done = finished.code == Some(0) || command.starts_with(MAY_COMPLAIN);
        assert!(done, "`{command}` ends with {:?}:\n{}", finished.code, finished.err);
    }

    /// Stops the daemon at this socket, or all of them; checks that they end normally.
    fn stop(&self, socket: Option<&str>) {
        let (stop, keep) = self
            .daemons
            .take()
            .into_iter()
            .partition(|(at, _)| socket.is_none_or(|socket| socket == at));
        self.daemons.replace(keep);
        let stop: Vec<(String, Running)> = stop;
        for (_, running) in stop {
            running.signal("INT");
            running.finish().expect_code(0);
        }
    }
}

/// A free address.
fn free() -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.local_addr().unwrap().to_string()
}

fn pages() -> Vec<PathBuf> {
    let ours = |page: &PathBuf| {
        let within = page.strip_prefix(repository()).unwrap();
        !within.starts_with("docs/reference") && !within.ends_with("CHANGELOG.md")
    };
    files("md").into_iter().filter(ours).collect()
}

#[test]
fn every_command_of_the_pages_is_run_as_printed_or_named_with_its_reason() {
    let mut ran = 0;
    let mut held = BTreeSet::new();
    // Later pages continue with the files of the first page, the README.
    let mut shown = Vec::new();
    for page in pages() {
        let Page { commands, files } = Page::read(&page);
        shown.extend(files);
        held.extend(commands.iter().filter_map(|command| elsewhere(command)));
        let mut here = commands.iter().filter(|command| elsewhere(command).is_none()).peekable();
        if here.peek().is_none() {
            continue;
        }
        let place = Place::new();
        for (name, text) in shown.iter().filter(|(name, _)| !name.contains('/')) {
            fs::write(place.path(name), text).unwrap();
        }
        for command in here {
            place.run(command);
            ran += 1;
        }
        place.stop(None);
    }
    assert!(ran > 30, "{ran} commands were run: are they still found?");
    let stale: Vec<_> =
        (0..ELSEWHERE.len()).filter(|at| !held.contains(at)).map(|at| ELSEWHERE[at].0).collect();
    assert!(stale.is_empty(), "no page shows these any more: {stale:?}");
}

#[test]
fn verbs_and_options_named_in_sentences_are_there() {
    let mut seen = BTreeSet::new();
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        for said in text.split("`genomctl ").skip(1).filter_map(|rest| rest.split_once('`')) {
            let words = said.0.split(' ').filter(|word| !word.is_empty());
            let words: Vec<&str> = words.take_while(|word| *word != "|").collect();
            // `genomctl --json`, `genomctl --host X VERB`: options come before the verb.
            let verb = words.first().copied().unwrap_or_default();
            if verb.is_empty() || verb.starts_with('-') || verb.starts_with(char::is_uppercase) {
                continue;
            }
            let options = words[1..].iter().filter(|word| word.starts_with("--"));
            let options = options.map(|word| word.split('=').next().unwrap_or_default().to_owned());
            seen.insert((verb.to_owned(), options.collect::<Vec<_>>()));
        }
    }
    assert!(seen.len() > 20, "{seen:?}");
    let mut wrong = Vec::new();
    for (verb, options) in seen {
        let mut help = Command::new(program("genomctl"));
        let help = Running::start(help.env_clear().args([verb.as_str(), "--help"])).finish();
        if help.code != Some(0) {
            wrong.push(format!("genomctl {verb}"));
        }
        let missing = options.into_iter().filter(|option| !help.out.contains(option.as_str()));
        wrong.extend(missing.map(|option| format!("genomctl {verb} {option}")));
    }
    assert!(wrong.is_empty(), "pages name what is not there: {wrong:#?}");
}
