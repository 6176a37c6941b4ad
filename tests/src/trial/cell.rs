//! A fault in a cell: two others are beside it, one in the process of the daemon and one in a cell
//! of its own, and a component shares the cell and reads a port of the daemon's. Another daemon,
//! which has nothing to do with it, tells what tasks miss on this machine anyway.

use std::time::{Duration, Instant};

use serde_json::Value;

use super::{APART, FAST, Trial, daemon_apart, exception, grown, told};
use crate::faults::{Fault, Outcome, Seen};
use crate::{Daemon, Footprint, Home, component, request, until};

/// Name of the cell that is struck.
const STRUCK: &str = "struck";
/// Within this time a daemon has told what it looks for now and then.
const LOOKED_AT: Duration = Duration::from_secs(10);
/// The components that must miss no period.
const OTHERS: [&str; 2] = ["neighbour", "beside"];

impl Trial {
    pub(super) fn in_a_cell(&mut self, fault: &Fault, times: usize) {
        let daemon = self.with_cells(fault);
        let apart = daemon_apart();
        let wired = |daemon: &Daemon| is_wired(daemon.home(), fault);
        until("all is wired", || wired(&daemon));
        // Memory that the first end needs once, such as the names for its backtrace.
        let warm = if fault.outcome.goes_on() { 0 } else { 1 };
        let times = if fault.outcome.goes_on() { 1 } else { times };
        let (mut held, mut missed) = (None, [0; 3]);
        let misses = || {
            let [own, beside] = OTHERS.map(|name| daemon.missed(name));
            [own, beside, apart.missed(APART)]
        };
        let mut back = Vec::new();
        let mut seen = Seen { code: None, said: String::new() };
        for round in 0..warm + times {
            if round == warm {
                held = Some(Footprint::of(daemon.process().id()));
                missed = misses();
                back.clear();
            }
            let starts = cell(&daemon)["starts"].clone();
            let begin = Instant::now();
            seen = called(&daemon, fault);
            if !fault.outcome.goes_on() {
                until("it comes back", || cell(&daemon)["starts"] != starts && wired(&daemon));
                back.push(begin.elapsed());
            }
        }
        let [own, beside, anyway] = misses();
        self.neighbours = format!(
            "{}; in another cell {}; apart {}",
            own - missed[0],
            beside - missed[1],
            anyway - missed[2]
        );
        self.memory = grown(
            &held.expect("taken in the first round that counts"),
            &Footprint::of(daemon.process().id()),
        );
        self.happened = match (seen.code, fault.outcome.goes_on()) {
            (Some(0), true) => "goes on".to_owned(),
            (_, true) => format!("ends with {}", exception(&seen.said)),
            (_, false) => {
                format!("its cell ends, {}", cell(&daemon)["last_end"].as_str().unwrap_or("?"))
            }
        };
        self.back = percentiles(&mut back);
        daemon.ctl(&["call", "neighbour", "goto", "goal=0.01"]).expect_code(0);
        daemon.ctl(&["unload", fault.component]).expect_code(0);
        // Codels that closed standard descriptors are looked for now and then.
        let tells = |line: &str| line.contains(fault.told);
        let line = || daemon.process().error_line_within(LOOKED_AT, tells);
        let said = tells(&seen.said) || line().is_ok_and(|line| line.is_some());
        let (ended, home) = daemon.stop("TERM");
        ended.expect_code(0);
        let left = home.memory().files();
        self.left = told(&left);
        let fits = match fault.outcome {
            Outcome::GoesOn => self.happened == "goes on",
            Outcome::Exception(name) => self.happened == format!("ends with {name}"),
            // A process that stops in order answers first.
            Outcome::Stops(_) => true,
            Outcome::Ends(_) => exception(&seen.said) == "::genom::gone",
        };
        self.wrong = match (fits, said, left.is_empty()) {
            (false, ..) => Some(format!("{}; it is to be: {}", self.happened, fault.outcome)),
            (_, false, _) => Some(format!("nothing says `{}`", fault.told)),
            (.., false) => Some(format!("left behind: {left:?}")),
            _ => None,
        };
    }

    fn with_cells(&self, fault: &Fault) -> Daemon {
        let [demo, mission, faulty] =
            ["demo", "mission", fault.component].map(|name| component(name).library);
        let text = format!(
            "backend = {:?}\n[cells]\nrestart_most = 1000000\nrestart_delay = 0.0\n\
             [[component]]\nlibrary = {demo:?}\nname = \"neighbour\"\n{FAST}\
             [[component]]\nlibrary = {demo:?}\nname = \"beside\"\ncell = \"beside\"\n{FAST}\
             [[component]]\nlibrary = {faulty:?}\ncell = {STRUCK:?}\n\
             [[component]]\nlibrary = {mission:?}\ncell = {STRUCK:?}\n\
             [[connection]]\nin = \"mission/position\"\nout = \"neighbour/position\"\n",
            self.backend
        );
        Home::new().configured(&text).start(&[])
    }
}

/// The struck cell as the daemon tells it.
fn cell(daemon: &Daemon) -> Value {
    let cells = daemon.home().get("/cells");
    let mut all = cells["cells"].as_array().expect("cells").iter();
    all.find(|cell| cell["name"] == STRUCK).expect("the cell").clone()
}

/// Whether all that belongs into the struck cell runs, and is connected.
fn is_wired(home: &Home, fault: &Fault) -> bool {
    let port = home.get("/components/mission/ports/position");
    let faulty = home.get(&format!("/components/{}", fault.component));
    port["connected"] == "neighbour/position" && faulty["name"] == fault.component
}

/// Calls the service as `genomctl call` does, without the time to start a command.
fn called(daemon: &Daemon, fault: &Fault) -> Seen {
    let service = format!("/components/{}/services/{}?wait=true", fault.component, fault.service);
    let reply = request(&daemon.home().socket(), "POST", &service, "{}");
    let exception = reply.body["exception"].as_str();
    let said = exception.map(|name| format!("ended with {name} ")).unwrap_or_default();
    Seen {
        code: Some(i32::from(reply.status != 200 || exception.is_some())),
        said: said + &reply.body.to_string(),
    }
}

fn percentiles(times: &mut [Duration]) -> String {
    times.sort_unstable();
    let at = |part: usize| times[(times.len() - 1) * part / 100].as_millis();
    match times.len() {
        0 => "it was not gone".to_owned(),
        1 => format!("back after {} ms", at(50)),
        _ => format!("back after p50 {} ms, p99 {} ms", at(50), at(99)),
    }
}
