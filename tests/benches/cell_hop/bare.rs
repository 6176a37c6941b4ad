//! The same exchange with bare iceoryx2: what `tests/fixtures/hop` does, in two processes that sleep
//! and poll as its codels do, on the same processors.

use std::hint::black_box;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Duration;

use genom_bench::{Figures, clock};
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use rustix::thread::{CpuSet, sched_setaffinity, sched_yield};

/// Octets of a value: its number, its time, and the rest.
pub(crate) const BYTES: usize = 64;
/// Values before measuring begins, polls between two looks at the clock, and for how long: those of
/// the fixture.
const WARM_UP: u64 = 100;
const LOOKS: usize = 16;
const PATIENCE: u64 = Duration::from_secs(1).as_nanos() as u64;

type Kind = ipc_threadsafe::Service;

/// One end of the exchange.
struct End {
    out: Publisher<Kind, [u8], ()>,
    from: Subscriber<Kind, [u8], ()>,
    /// Where values are copied from and to, as ports have memory of their own.
    sent: [u8; BYTES],
    got: [u8; BYTES],
    _node: Node<Kind>,
}

/// A number and a time in nanoseconds.
type Value = (u64, u64);

impl End {
    fn open(place: &Path, [to, from]: [&str; 2]) -> Self {
        let name = place.file_name().expect("a name").to_string_lossy().replace('.', "");
        let mut config = Config::default();
        config.global.prefix = FileName::new(format!("hop{name}_").as_bytes()).expect("a name");
        let root = place.join("bare").display().to_string();
        config.global.set_root_path(&iceoryx2::prelude::Path::new(root.as_bytes()).expect("short"));
        let node = NodeBuilder::new().config(&config).create::<Kind>().expect("a node");
        let service = |name: &str| {
            let name = ServiceName::new(name).expect("a name");
            let service = node.service_builder(&name).publish_subscribe::<[u8]>();
            // As ports are opened: readers hold one value, the newest.
            service.subscriber_max_buffer_size(1).open_or_create().expect("a service")
        };
        let out = service(to).publisher_builder().initial_max_slice_len(BYTES).create();
        let from = service(from).subscriber_builder().create().expect("a reader");
        Self { out: out.expect("a writer"), from, sent: [0; BYTES], got: [0; BYTES], _node: node }
    }

    fn send(&mut self, (number, time): Value) {
        self.sent[..8].copy_from_slice(&number.to_ne_bytes());
        self.sent[8..16].copy_from_slice(&time.to_ne_bytes());
        let sample = self.out.loan_slice_uninit(BYTES).expect("memory");
        sample.write_from_slice(black_box(&self.sent)).send().expect("it is sent");
    }

    /// Polls until a value other than number `last` is there.
    fn next(&mut self, last: u64) -> Option<Value> {
        let begin = clock::now();
        loop {
            for _ in 0..LOOKS {
                let Some(sample) = self.from.receive().expect("it is open") else { continue };
                self.got.copy_from_slice(sample.payload());
                let got = black_box(&self.got);
                let word = |at: usize| got[at..at + 8].try_into().map(u64::from_ne_bytes);
                let value = (word(0).expect("8 octets"), word(8).expect("8 octets"));
                if value.0 != last {
                    return Some(value);
                }
            }
            sched_yield();
            if clock::now() - begin > PATIENCE {
                return None;
            }
        }
    }
}

/// The pair of them.
pub(crate) struct Pair {
    ping: End,
    process: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
}

impl Pair {
    /// Starts this program again as the echo, with `arguments` and the place.
    pub(crate) fn start(place: &Path, word: &str, [own, other]: [usize; 2]) -> Self {
        let ping = End::open(place, ["there", "back"]);
        let mut process = Command::new(std::env::current_exe().expect("this program"))
            .arg(word)
            .arg(place)
            .arg(other.to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("this program starts again");
        stay_on(own);
        let to = process.stdin.take().expect("a pipe");
        let from = BufReader::new(process.stdout.take().expect("a pipe"));
        let mut pair = Self { ping, process, to, from };
        pair.hear();
        pair
    }

    fn hear(&mut self) {
        let mut line = String::new();
        self.from.read_line(&mut line).expect("the echo goes on");
    }

    /// As the codel `hop_ping`.
    pub(crate) fn measure(&mut self, rounds: u64, period: u64) -> Figures {
        writeln!(self.to, "{rounds}").expect("the echo goes on");
        let (mut date, mut last) = (clock::now(), 0);
        let mut ages = Vec::new();
        for round in 1..=rounds + WARM_UP {
            date += period;
            clock::sleep_until(date);
            self.ping.send((round, clock::now()));
            let Some((number, age)) = self.ping.next(last) else { break };
            last = number;
            if round > WARM_UP {
                ages.push(age as f64);
            }
        }
        self.hear();
        Figures::of(ages).expect("values arrived")
    }

    pub(crate) fn end(self) {
        let Self { mut process, to, .. } = self;
        drop(to);
        assert!(process.wait().expect("it ends").success(), "the echo failed");
    }
}

/// The other process, as the codel `hop_echo`.
pub(crate) fn echo(place: &Path, processor: usize) {
    let mut end = End::open(place, ["back", "there"]);
    stay_on(processor);
    let tell = || println!("done");
    tell();
    for line in std::io::stdin().lines() {
        let rounds: u64 = line.expect("a line").parse().expect("a number");
        let mut last = 0;
        for _ in 0..rounds + WARM_UP {
            let Some((number, sent)) = end.next(last) else { continue };
            last = number;
            end.send((number, clock::now() - sent));
        }
        tell();
    }
}

fn stay_on(processor: usize) {
    let mut set = CpuSet::new();
    set.set(processor);
    sched_setaffinity(None, &set).expect("this processor is there");
}
