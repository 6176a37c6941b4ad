//! Shared memory with active peers, on which daemons are ended and started again.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;

use super::course::Phase;
use super::outcome::Outcome;
use super::watched::{End, Step, Watched};
use crate::command::Running;
use crate::http::attempt;
use crate::{Daemon, Home, Memory, component, fixture, path};

/// Longest wait for a successor: far more than it may take, so that the table can show how long it
/// took.
const PATIENCE: Duration = Duration::from_secs(15);

/// Where to end a daemon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// During this phase.
    pub phase: Phase,
    /// Before the call with this index.
    pub call: usize,
    /// Whether a peer reads its port and continues afterwards.
    pub followed: bool,
}

/// The peers: a daemon with two connected components, and a program that uses only iceoryx2, writes
/// to itself, and reopens its port again and again (the flow).
#[derive(Debug)]
pub struct Stage {
    memory: Arc<Memory>,
    home: Home,
    peer: Daemon,
    flow: Running,
    program: PathBuf,
    library: String,
    /// Files of the peers.
    theirs: BTreeSet<PathBuf>,
    /// Identities of the flow, whose files appear and disappear.
    its: Vec<String>,
    rounds: u32,
    /// The flow's last line.
    lost: String,
    _made: TempDir,
}

impl Stage {
    /// Starts the peers. `program`, called with `--peer`, plays those that use only iceoryx2.
    #[must_use]
    pub fn new(program: &Path) -> Self {
        let memory = Arc::new(Memory::new());
        let made = TempDir::new().expect("a directory can be made");
        let [sensor, fuser] = ["sensor", "fuser"].map(|name| fixture("robot", name, made.path()));
        let peer = Home::with(&memory).start(&["--backend", "shm", &sensor, &fuser]);
        for (inport, outport) in [("a", "x"), ("b", "y"), ("c", "z")] {
            let ends = [format!("fuser/{inport}"), format!("sensor/{outport}")];
            peer.ctl(&["connect", &ends[0], &ends[1]]).expect_code(0);
        }
        let (flow, its) = start(program, "flow", &memory);
        let home = Home::with(&memory);
        let library = path(&component("demo").library).to_owned();
        let theirs = memory.files().into_iter().collect();
        let program = program.to_owned();
        Self {
            memory,
            home,
            peer,
            flow,
            program,
            library,
            theirs,
            its,
            rounds: 0,
            lost: "lost 0".to_owned(),
            _made: made,
        }
    }

    fn watched(&self, end: End) -> Watched {
        let command = self.home.command(&[], &["--backend", "shm", &self.library]);
        Watched::start(command, &self.memory, Phase::ALL.len(), end)
    }

    /// The calls of a daemon that is not ended, by phase.
    #[must_use]
    pub fn calls(&self, phase: Phase) -> Vec<Step> {
        let watched = self.watched(End::Own);
        for step in phase.way() {
            assert!(step.drive(&watched, &self.home.socket()), "the daemon ended: {step:?}");
        }
        let mut steps = match phase {
            Phase::Stop => watched.finish(),
            // What it does while stopping belongs to another phase.
            _ => {
                watched.enter(usize::MAX);
                watched.stop();
                watched.finish()
            }
        };
        steps.swap_remove(phase.number())
    }

    /// Ends a daemon at that point, and starts its successor.
    #[must_use]
    pub fn run(&mut self, plan: Plan) -> Outcome {
        let Plan { phase, call, followed } = plan;
        let follower = followed.then(|| start(&self.program, "follow", &self.memory).0);
        let watched = self.watched(End::Before { phase: phase.number(), call });
        let socket = self.home.socket();
        for step in phase.way() {
            if !step.drive(&watched, &socket) {
                break;
            }
            if *step == Phase::Load
                && phase != Phase::Load
                && let Some(follower) = &follower
            {
                assert_eq!(follower.line(), "following");
            }
        }
        let mut steps = match phase {
            Phase::Stop => watched.finish(),
            _ => watched.kill(),
        };
        let mut steps = steps.swap_remove(phase.number());
        let step = (steps.len() > call).then(|| steps.swap_remove(call));
        let mut outcome = Outcome {
            phase,
            call,
            step,
            followed,
            ready: None,
            trouble: Vec::new(),
            left: Vec::new(),
        };
        self.succeed(&mut outcome, follower);
        outcome
    }

    fn succeed(&mut self, outcome: &mut Outcome, follower: Option<Running>) {
        let begin = Instant::now();
        let successor = self.home.spawn(&["--backend", "shm", &self.library]);
        let ready = successor.error_line_within(PATIENCE, |line| line.contains("ready on "));
        if ready != Ok(None) && ready.is_ok() {
            outcome.ready = Some(begin.elapsed());
        } else {
            let hangs = ready.is_err();
            if hangs {
                successor.signal("KILL");
            }
            let told = successor.finish().err;
            outcome.trouble.push(format!("{} {told}", if hangs { "hangs:" } else { "refused:" }));
            self.clear();
            return;
        }
        self.use_all(outcome);
        if let Some(follower) = follower {
            follower.signal("TERM");
            follower.finish().expect_code(0);
        }
        self.peers(outcome);
        successor.signal("TERM");
        match successor.finish_or(PATIENCE) {
            Some(finished) if finished.code == Some(0) => {}
            Some(finished) => outcome.trouble.push(format!("stops with {finished:?}")),
            None => outcome.trouble.push("does not stop".to_owned()),
        }
        outcome.left = self.left();
        if !outcome.is_fine() {
            self.clear();
        }
    }

    /// Uses everything that could hang because of what was left.
    fn use_all(&self, outcome: &mut Outcome) {
        let asked = [
            ("GET", "/middlewares?visible=true", ""),
            ("PUT", "/components/demo/backend", r#"{"backend":"local"}"#),
            ("PUT", "/components/demo/backend", r#"{"backend":"shm"}"#),
            ("POST", "/connections", r#"{"in":"demo/parameter","out":"sensor/x"}"#),
            ("DELETE", "/connections/demo/parameter", ""),
            ("POST", "/components/demo/ports/parameter", "0.5"),
        ];
        for (method, at, body) in asked {
            match attempt(&self.home.socket(), method, at, body) {
                Ok(reply) if reply.status < 300 && problem(&reply.body).is_none() => {}
                Ok(reply) => outcome.trouble.push(format!("{method} {at} {body}: {}", reply.body)),
                Err(error) => outcome.trouble.push(format!("{method} {at} {body}: {error}")),
            }
        }
    }

    /// Checks that the peers continue: a new value passes through their connections in each round.
    fn peers(&mut self, outcome: &mut Outcome) {
        self.rounds += 1;
        let (value, sum) =
            (format!("value={}", self.rounds), format!("wanted={}", 3 * self.rounds));
        for arguments in
            [&["call", "sensor", "set", &value][..], &["start", "--wait", "fuser", "watch", &sum]]
        {
            let done = self.peer.ctl(arguments);
            if done.code != Some(0) {
                outcome.trouble.push(format!("the peer: {arguments:?}: {}", done.err));
            }
        }
        // The line contains the number of samples lost so far.
        let lost = self.flow.line_from_now();
        if lost != self.lost {
            outcome.trouble.push(format!("the flow {lost}"));
            self.lost = lost;
        }
    }

    /// Removes what nobody cleaned up, so that the next point starts clean.
    fn clear(&self) {
        for file in self.left() {
            let _ = std::fs::remove_file(file);
        }
    }

    /// Files that belong to no peer.
    fn left(&self) -> Vec<PathBuf> {
        let of_flow = |file: &PathBuf| {
            let name = file.to_string_lossy();
            self.its.iter().any(|id| name.contains(id))
        };
        let files = self.memory.files().into_iter();
        files.filter(|file| !self.theirs.contains(file) && !of_flow(file)).collect()
    }

    /// Number of periods that tasks of the peers missed so far.
    #[must_use]
    pub fn missed(&self) -> u64 {
        ["sensor", "fuser"].iter().map(|name| self.peer.missed(name)).sum()
    }

    /// Ends the peers. Returns the files that are left.
    #[must_use]
    pub fn end(self) -> Vec<PathBuf> {
        self.flow.signal("TERM");
        self.flow.finish().expect_code(0);
        let (finished, _) = self.peer.stop("TERM");
        finished.expect_code(0);
        self.memory.files()
    }
}

fn problem(reply: &Value) -> Option<&Value> {
    let all = reply["middlewares"].as_array()?;
    all.iter().find_map(|one| one.get("problem"))
}

/// Starts a peer. Returns it with its identities.
fn start(program: &Path, role: &str, memory: &Memory) -> (Running, Vec<String>) {
    let mut command = Command::new(program);
    command.arg("--peer").arg(role).arg(memory.prefix()).arg(memory.root());
    let running = Running::start(&mut command);
    let line = running.line();
    let ids = line.strip_prefix("ready ").expect("it is ready");
    let ids = ids.split(' ').map(str::to_owned).collect();
    (running, ids)
}
