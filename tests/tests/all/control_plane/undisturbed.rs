//! Attackers who can reach the control plane do not disturb the components.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::Instant;

use genom_tests::{Daemon, Home, Running, WATCHDOG, component, path, program, request};
use serde_json::Value;

/// A connection on either listener.
trait Wire: Read + Write + Send {}
impl<T: Read + Write + Send> Wire for T {}

/// Where a daemon can be reached, and with which token.
#[derive(Clone)]
struct Doors {
    socket: PathBuf,
    tcp: SocketAddr,
    token: String,
}

impl Doors {
    /// Number 0 is the socket, 1 is TCP.
    fn open(&self, number: usize) -> Box<dyn Wire> {
        if number == 0 {
            let stream = UnixStream::connect(&self.socket).expect("the daemon listens");
            stream.set_read_timeout(Some(WATCHDOG)).unwrap();
            stream.set_write_timeout(Some(WATCHDOG)).unwrap();
            return Box::new(stream);
        }
        let stream = TcpStream::connect(self.tcp).expect("the daemon listens");
        stream.set_read_timeout(Some(WATCHDOG)).unwrap();
        stream.set_write_timeout(Some(WATCHDOG)).unwrap();
        Box::new(stream)
    }

    fn head(&self, request: &str) -> String {
        format!("{request} HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer {}\r\n", self.token)
    }
}

/// The demo with a task at 1 kHz, reachable by socket and by TCP.
fn start(extra: &str, arguments: &[&str]) -> (Daemon, Doors) {
    let home = Home::new();
    let mut command = Command::new(program("genomctl"));
    command.current_dir(home.path());
    command.args(["token", "foe", "--rights", "admin", "--into", "tokens.toml"]);
    Running::start(&mut command).finish().expect_code(0);
    let text = std::fs::read_to_string(home.path().join("tokens.toml")).unwrap();
    let token = text.lines().find_map(|line| line.strip_prefix("token = ")).unwrap();
    let token = token.trim_matches('"').to_owned();
    let demo = component("demo");
    let config = format!(
        "{extra}\n[[component]]\nlibrary = {:?}\n[component.tasks.main]\nperiod_ms = 1.0\n",
        path(&demo.library)
    );
    let tcp = ["--listen", "127.0.0.1:0", "--token-file", "tokens.toml"];
    let daemon = home.configured(&config).start(&[&tcp, arguments].concat());
    let socket = daemon.home().socket();
    let about = request(&socket, "GET", "/", "").body;
    let tcp = about["listen"].as_str().unwrap().parse().unwrap();
    (daemon, Doors { socket, tcp, token })
}

/// Attacks that must not disturb, repeated until told to end; each at least once.
struct Foes<'a> {
    doors: &'a Doors,
    enough: AtomicBool,
    attacks: AtomicU64,
}

impl Foes<'_> {
    /// Bytes that are not HTTP; with a fixed seed, so that failures can be reproduced.
    fn noise(&self, door: usize) {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64 + door as u64;
        self.again(|round| {
            let length = 1 + round * 97 % 4096;
            let bytes: Vec<u8> = std::iter::repeat_with(|| {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                state.to_le_bytes()[0]
            })
            .take(length)
            .collect();
            let mut wire = self.doors.open(door);
            // The daemon may hang up in the middle.
            let _ = wire.write_all(&bytes);
        });
    }

    /// Incomplete heads and bodies on connections that stay open; few, so that legitimate clients
    /// can still connect.
    fn halves(&self, door: usize) {
        let mut open = std::collections::VecDeque::new();
        self.again(|round| {
            let mut wire = self.doors.open(door);
            let request = self.doors.head("POST /components/demo/services/goto");
            let half = if round % 2 == 0 { "Content-Le" } else { "Content-Length: 99\r\n\r\n{" };
            let _ = wire.write_all(format!("{request}{half}").as_bytes());
            open.push_back(wire);
            if open.len() > 16 {
                open.pop_front();
            }
        });
    }

    /// Streams that nobody reads.
    fn deaf(&self, door: usize) {
        let mut open = std::collections::VecDeque::new();
        self.again(|round| {
            let mut wire = self.doors.open(door);
            let path = ["/events", "/components/demo/ports/position/stream?rate=1000"][round % 2];
            let request = self.doors.head(&format!("GET {path}"));
            let _ = wire.write_all(format!("{request}\r\n").as_bytes());
            open.push_back(wire);
            if open.len() > 8 {
                open.pop_front();
            }
        });
    }

    /// Bodies beyond any limit: one with a declared length, one without an end.
    fn large(&self, door: usize) {
        self.again(|round| {
            let mut wire = self.doors.open(door);
            let request = self.doors.head("POST /components/demo/services/goto");
            if round % 2 == 0 {
                let _ = wire
                    .write_all(format!("{request}Content-Length: 999999999999\r\n\r\n").as_bytes());
            } else {
                let _ = wire
                    .write_all(format!("{request}Transfer-Encoding: chunked\r\n\r\n").as_bytes());
                let chunk = format!("10000\r\n{}\r\n", " ".repeat(0x10000));
                let mut sent = 0;
                while wire.write_all(chunk.as_bytes()).is_ok() {
                    sent += chunk.len();
                    assert!(sent < 64 << 20, "the daemon reads on and on");
                }
            }
            // Refused for its length, or because the others have all connections, or cut off while
            // being sent.
            let mut status = [0; 12];
            if wire.read_exact(&mut status).is_ok() {
                let told = String::from_utf8_lossy(&status);
                assert!(["HTTP/1.1 413", "HTTP/1.1 503"].contains(&&*told), "{told}");
            }
        });
    }

    fn again(&self, mut attack: impl FnMut(usize)) {
        for round in 0.. {
            if round >= 4 && self.enough.load(Ordering::Relaxed) {
                return;
            }
            attack(round);
            self.attacks.fetch_add(1, Ordering::Relaxed);
            // There are many attackers on one machine, and the daemon must still get the processor.
            thread::yield_now();
        }
    }
}

/// Runs `work` while a daemon is attacked by socket and by TCP. Returns the number of attacks.
fn under_attack(doors: &Doors, work: impl FnOnce()) -> u64 {
    let foes = Foes { doors, enough: AtomicBool::new(false), attacks: AtomicU64::new(0) };
    thread::scope(|scope| {
        for door in [0, 1] {
            for attack in [Foes::noise, Foes::halves, Foes::deaf, Foes::large] {
                let foes = &foes;
                scope.spawn(move || attack(foes, door));
            }
        }
        // Ends the attackers even if the work panics.
        let _end = End(&foes.enough);
        work();
    });
    foes.attacks.into_inner()
}

struct End<'a>(&'a AtomicBool);

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

fn ask(socket: &Path, method: &str, path: &str, body: &str) -> Value {
    let reply = request(socket, method, path, body);
    assert!((200..300).contains(&reply.status), "{method} {path}: {reply:?}");
    reply.body
}

/// Cycles and overruns of the demo's task.
fn ticks(socket: &Path) -> (u64, u64) {
    let stats = ask(socket, "GET", "/components/demo/tasks", "");
    let task = &stats["tasks"][0];
    (task["cycles"]["count"].as_u64().unwrap(), task["overruns"].as_u64().unwrap())
}

#[test]
fn under_a_stepped_clock_every_tick_is_as_without_the_attack() {
    /// Steps of 1 ms, with a request in each.
    fn drive(socket: &Path) -> Vec<String> {
        ask(socket, "POST", "/components/demo/services/goto", r#"{"goal":0.1}"#);
        let mut told = Vec::new();
        for _ in 0..300 {
            ask(socket, "POST", "/clock", r#"{"nanoseconds":1000000}"#);
            let at = ask(socket, "POST", "/components/demo/services/get_position", "{}");
            told.push(format!("{} {:?}", at["result"], ticks(socket)));
        }
        told
    }
    let clock = ["--clock", "virtual"];
    let (alone, _) = start("", &clock);
    let expected = drive(&alone.home().socket());
    let (attacked, doors) = start("", &clock);
    let mut found = Vec::new();
    let attacks = under_attack(&doors, || found = drive(&attacked.home().socket()));
    assert_eq!(found, expected, "{attacks} attacks");
    let (cycles, overruns) = ticks(&attacked.home().socket());
    assert!(cycles >= 300 && overruns == 0, "{cycles} cycles, {overruns} overruns");
}

#[test]
fn a_task_of_1_khz_goes_on_and_every_request_is_answered() {
    let ((alone, _), (attacked, doors)) = (start("", &[]), start("", &[]));
    let (one, other) = (alone.home().socket(), attacked.home().socket());
    let (before_alone, before) = (ticks(&one), ticks(&other));
    let begin = Instant::now();
    let mut asked = 0;
    let attacks = under_attack(&doors, || {
        // For as long as the daemon that is not attacked needs for one second of its time, however
        // busy the machine is.
        while ticks(&one).0 < before_alone.0 + 1000 {
            let speed = 0.25 + f64::from(asked % 2) / 4.0;
            let body = format!(r#"{{"velocity":{speed}}}"#);
            ask(&other, "POST", "/components/demo/services/set_speed", &body);
            let told = ask(&other, "POST", "/components/demo/services/get_speed", "{}");
            assert_eq!(told["result"]["velocity"], speed);
            asked += 1;
            assert!(begin.elapsed() < WATCHDOG, "neither of the two gets on");
        }
    });
    let ran = ticks(&one).0 - before_alone.0;
    let (cycles, overruns) = ticks(&other);
    let undisturbed = cycles - before.0;
    eprintln!(
        "{attacks} attacks and {asked} requests: {ran} ticks alone, {undisturbed} under attack \
         with {overruns} overruns ({before:?} before)"
    );
    // Both run on one machine under the same load. A task that waited for the control plane would
    // stand still; a factor of 4 allows for the scheduler.
    assert!(undisturbed * 4 >= ran, "{undisturbed} ticks under attack, {ran} alone");
    // Both end normally.
    attacked.stop("TERM").0.expect_code(0);
}

#[test]
fn half_open_connections_that_fill_the_daemon_are_closed_in_time() {
    let (daemon, doors) = start("[rpc]\nmax_connections = 4", &[]);
    for door in [0, 1] {
        let mut open = Vec::new();
        for half in ["", "GET / HT", "GET / HTTP/1.1\r\nHost: x\r\n", "body"] {
            let mut wire = doors.open(door);
            let request = doors.head("POST /connections");
            let half = half.replace("body", &format!("{request}Content-Length: 99\r\n\r\n{{"));
            wire.write_all(half.as_bytes()).unwrap();
            open.push(wire);
        }
        // No further connection is possible until they are given up.
        let mut friend = doors.open(door);
        let request = format!("{}Connection: close\r\n\r\n", doors.head("GET /components"));
        friend.write_all(request.as_bytes()).unwrap();
        let mut reply = String::new();
        friend.read_to_string(&mut reply).expect("it has its turn");
        assert!(reply.starts_with("HTTP/1.1 200"), "{reply}");
        // The daemon closed each of them: reading ends.
        for mut wire in open {
            let mut rest = Vec::new();
            wire.read_to_end(&mut rest).expect("the daemon hung up");
        }
    }
    daemon.ctl(&["list"]).expect_code(0);
}
