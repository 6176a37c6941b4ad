//! Hostile bytes from the network, sent to the gateways of a daemon: what becomes of them, of the
//! ports that they serve, and of a component at 1 kHz beside them.

mod dice;
mod flow;
mod forger;
mod rtps;
mod stage;
mod zenoh;

use std::fmt::Write as _;
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::{Footprint, WATCHDOG, until};
use dice::Dice;
use flow::Flow;
use rtps::Attacker;
use stage::{BOTH, NEIGHBOURS, Stage};

/// Datagrams that are sent at once, and the pause after them.
const BURST: (usize, Duration) = (10, Duration::from_millis(5));

/// Within this time ports are to flow again.
pub const GOAL: Duration = Duration::from_secs(1);

/// What is to be done.
#[derive(Clone, Copy, Debug)]
pub struct Siege {
    /// How long bytes by chance are sent, after the three datagrams.
    pub bytes: Duration,
    /// How often a gateway is ended by SIGKILL then.
    pub kills: usize,
    /// Another one gives other bytes.
    pub seed: u64,
}

/// What became of one gateway.
#[derive(Clone, Debug)]
pub struct Besieged {
    /// Its middleware.
    pub on: &'static str,
    /// How often it ended under hostile bytes.
    pub ends: u64,
    /// The longest time without a new sample meanwhile.
    pub pause: Duration,
    /// Its resident memory before and after, in KiB, and the peak.
    pub memory: [u64; 3],
    /// Of each kill: until a sample came through again.
    pub back: Vec<Duration>,
}

/// What became of all.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// How long bytes by chance were sent.
    pub bytes: Duration,
    /// Datagrams of RTPS, connections to zenoh, and sessions that were open for a while.
    pub sent: [usize; 3],
    /// The gateways.
    pub gateways: Vec<Besieged>,
    /// How often the cell of components ended.
    pub cell_ends: u64,
    /// Periods that were missed in the daemon, in a cell, and in a daemon apart: in quiet, under
    /// hostile bytes, and under kills, each with how long that took.
    pub missed: [(Duration, [u64; 3]); 3],
}

impl Siege {
    /// Does it.
    ///
    /// # Panics
    /// If the daemon ends, or ports do not flow again.
    #[must_use]
    pub fn lay(self) -> Outcome {
        let stage = Stage::new();
        let flows = BOTH.map(|on| stage.flow(on));
        let quiet = self.bytes.clamp(Duration::from_secs(1), Duration::from_secs(10));
        let in_quiet = missed_while(&stage, || thread::park_timeout(quiet));
        let pids = BOTH.map(|on| stage.gateway(on).expect("it runs"));
        let before = pids.map(|pid| Footprint::of(pid).resident);
        for flow in &flows {
            flow.longest();
        }
        let (cell, starts) = (stage.starts(NEIGHBOURS[1]), BOTH.map(|on| starts(&stage, on)));
        let mut sent = [0; 3];
        let under_bytes = missed_while(&stage, || {
            self.deadly(&stage);
            self.by_chance(&stage, &mut sent);
            BOTH.iter().zip(&flows).for_each(|(on, flow)| flows_again(&stage, on, flow));
        });
        let pauses = flows.each_ref().map(Flow::longest);
        let mut gateways: Vec<Besieged> = Vec::new();
        for (at, on) in BOTH.into_iter().enumerate() {
            let now = Footprint::of(stage.gateway(on).expect("it runs"));
            let ends = starts_since(&stage, on, starts[at]);
            let memory = [before[at], now.resident, now.peak];
            gateways.push(Besieged { on, ends, pause: pauses[at], memory, back: Vec::new() });
        }
        let under_kills = missed_while(&stage, || {
            for round in 0..self.kills {
                let at = round % BOTH.len();
                gateways[at].back.push(killed(&stage, BOTH[at], &flows[at]));
            }
        });
        let cell_ends = stage.starts(NEIGHBOURS[1]) - cell;
        drop(flows);
        let Stage { near, far, apart } = stage;
        for daemon in [far, near, apart] {
            daemon.stop("TERM").0.expect_code(0);
        }
        let missed = [in_quiet, under_bytes, under_kills];
        Outcome { bytes: self.bytes, sent, gateways, cell_ends, missed }
    }

    /// The three datagrams, until the daemon tells that it refused what is in them, or until its
    /// gateway has ended.
    fn deadly(self, stage: &Stage) {
        let mut attacker = attacker(stage);
        let starts = starts(stage, "ros2");
        until("the datagrams have arrived", || {
            attacker.announce();
            for datagram in attacker.deadly() {
                stage.udp().into_iter().for_each(|to| attacker.send(&datagram, to));
            }
            let told = stage.near.ctl(&["doctor"]).out;
            let refused = told.contains("more sequence numbers than a writer can hold")
                && told.contains("greatest_sample");
            refused || starts_since(stage, "ros2", starts) > 0
        });
    }

    fn by_chance(self, stage: &Stage, sent: &mut [usize; 3]) {
        let (mut dice, mut attacker) = (Dice::new(self.seed), attacker(stage));
        let (mut udp, mut tcp) = (stage.udp(), stage.tcp());
        let (begin, mut looked) = (Instant::now(), Instant::now());
        while begin.elapsed() < self.bytes {
            // Another process has other ports.
            if looked.elapsed() > GOAL {
                (udp, tcp, looked) = (stage.udp(), stage.tcp(), Instant::now());
                attacker.announce();
            }
            for _ in 0..BURST.0 {
                let datagram = attacker.next(&mut dice);
                udp.iter().for_each(|to| attacker.send(&datagram, *to));
                sent[0] += udp.len();
            }
            for to in &tcp {
                let (bytes, open) = zenoh::strike(*to, &mut dice);
                sent[1] += usize::from(bytes > 0);
                sent[2] += usize::from(open);
            }
            thread::park_timeout(BURST.1);
        }
    }
}

fn attacker(stage: &Stage) -> Attacker {
    let memory = stage.near.home().memory();
    let namespace = memory.prefix().trim_end_matches('_');
    let domain = u16::try_from(memory.domain()).expect("a domain");
    Attacker::new(domain, format!("rt/{namespace}/on_ros2/parameter"))
}

fn starts(stage: &Stage, on: &str) -> u64 {
    stage.starts(&format!("gateway-{on}"))
}

/// How often a gateway was started since.
fn starts_since(stage: &Stage, on: &str, before: u64) -> u64 {
    starts(stage, on).saturating_sub(before)
}

fn missed_while(stage: &Stage, act: impl FnOnce()) -> (Duration, [u64; 3]) {
    let (begin, before) = (Instant::now(), stage.missed());
    act();
    let after = stage.missed();
    (begin.elapsed(), std::array::from_fn(|at| after[at] - before[at]))
}

/// Waits for new samples; if there are none, says what both sides know of it.
fn flows_again(stage: &Stage, on: &str, flow: &Flow) {
    let before = flow.changes();
    let end = Instant::now() + WATCHDOG / 2;
    let what = format!("samples come through again on {on}");
    until(&what, || {
        let flows = flow.changes() > before + 1;
        assert!(flows || Instant::now() < end, "not {what}: {}", stage.told(on));
        flows
    });
}

/// Ends a gateway, and waits until the next one passes samples on.
fn killed(stage: &Stage, on: &str, flow: &Flow) -> Duration {
    let before = starts(stage, on);
    let begin = Instant::now();
    stage.kill(on);
    until("it is started again", || {
        starts_since(stage, on, before) > 0 && stage.gateway(on).is_some()
    });
    flows_again(stage, on, flow);
    begin.elapsed()
}

impl Outcome {
    /// What is not as it is to be.
    #[must_use]
    pub fn wrong(&self) -> Option<String> {
        let mut wrong = String::new();
        if self.cell_ends > 0 {
            let _ = writeln!(wrong, "the cell of components ended {} times", self.cell_ends);
        }
        for Besieged { on, pause, back, .. } in &self.gateways {
            let longest = back.iter().chain([pause]).max().filter(|longest| **longest > GOAL);
            if let Some(longest) = longest {
                let _ = writeln!(wrong, "{on} did not flow for {} ms", longest.as_millis());
            }
        }
        (!wrong.is_empty()).then_some(wrong)
    }

    /// As JSON.
    #[must_use]
    pub fn json(&self) -> Value {
        let gateway = |one: &Besieged| {
            json!({
                "gateway": one.on, "ends": one.ends, "longest_pause_ms": ms(one.pause),
                "memory_kib": one.memory, "back_ms": one.back.iter().map(|it| ms(*it)).collect::<Vec<_>>(),
            })
        };
        let missed = |(took, of): &(Duration, [u64; 3])| json!({ "seconds": took.as_secs_f64(), "missed": of });
        json!({
            "seconds": self.bytes.as_secs_f64(), "datagrams": self.sent[0],
            "connections": self.sent[1], "sessions": self.sent[2],
            "gateways": self.gateways.iter().map(gateway).collect::<Vec<_>>(),
            "cell_ends": self.cell_ends, "quiet": missed(&self.missed[0]),
            "under_bytes": missed(&self.missed[1]), "under_kills": missed(&self.missed[2]),
        })
    }

    /// For a reader.
    #[must_use]
    pub fn told(&self) -> String {
        let [datagrams, connections, sessions] = self.sent;
        let mut text = format!(
            "{} s of hostile bytes: {datagrams} datagrams of RTPS, {connections} connections to \
             zenoh ({sessions} of them in a session)\n",
            self.bytes.as_secs()
        );
        for one in &self.gateways {
            let [before, after, peak] = one.memory.map(|kib| kib >> 10);
            let _ = writeln!(
                text,
                "gateway of {}: ended {} times; no sample for at most {} ms; memory {before} MiB \
                 before, {after} after, {peak} at most",
                one.on,
                one.ends,
                ms(one.pause)
            );
            let mut back = one.back.clone();
            back.sort_unstable();
            if let Some(longest) = back.last() {
                let _ = writeln!(
                    text,
                    "gateway of {}: {} kills; samples again after p50 {} ms, at most {} ms",
                    one.on,
                    back.len(),
                    ms(back[back.len() / 2]),
                    ms(*longest)
                );
            }
        }
        let _ = writeln!(text, "the cell of components ended {} times", self.cell_ends);
        for (what, (took, [own, cell, apart])) in
            ["in quiet", "under bytes", "under kills"].iter().zip(&self.missed)
        {
            let _ = writeln!(
                text,
                "missed {what}, in {:.1} s at 1 kHz: {own} in the daemon's process, {cell} in a cell, \
                 {apart} in a daemon apart",
                took.as_secs_f64()
            );
        }
        text
    }
}

fn ms(time: Duration) -> u64 {
    u64::try_from(time.as_millis()).unwrap_or(u64::MAX)
}
