//! Cost of plots: a component with 50 out ports that a task of 1 kHz writes, with nobody looking and
//! with all of them plotted on a page, side by side: processor time of the daemon, periods that the
//! task missed, how late it was, and whether any sample is missing.
//!
//! `cargo bench -p genom-tests --bench plots [-- SECONDS]`. The programs are built with `--release`.

#![forbid(unsafe_code)]
#![allow(
    clippy::expect_used,
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a benchmark, which measures for a time"
)]

use std::fmt::Write as _;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use genom_tests::{Daemon, Home, Running, path, processor_time, program, release};
use serde_json::Value;

const PORTS: usize = 50;
/// Columns in a second: those of a plot of 800 pixels and 20 s.
const COLUMNS: u32 = 40;

fn main() {
    let mut words = std::env::args().skip(1).filter_map(|word| word.parse().ok());
    let time = Duration::from_secs(words.next().unwrap_or(10));
    let _ = release();
    let made = tempfile::tempdir().expect("a directory");
    let description = scope(made.path());
    let daemon = Home::new().start(&["--web", &description]);
    println!(
        "{:24} {:>12} {:>8} {:>14} {:>10} {:>10} {:>8} {:>10}",
        "", "processor", "missed", "lateness 99 %", "samples/s", "lost", "skipped", "kB/s"
    );
    // Twice, in turn: what else the machine does falls on both.
    for _ in 0..2 {
        measure(&daemon, "nobody looks", time, |_| Seen::default());
        let url = sign_in_link(&daemon);
        measure(&daemon, "50 ports are plotted", time, |over| watch(&url, over));
    }
}

/// What a page received.
#[derive(Default)]
struct Seen {
    samples: u64,
    lost: u64,
    skipped: u64,
    bytes: usize,
}

fn measure(
    daemon: &Daemon,
    name: &str,
    time: Duration,
    page: impl FnOnce(&AtomicBool) -> Seen + Send,
) {
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let page = scope.spawn(|| page(&over));
        std::thread::sleep(Duration::from_secs(1));
        let task = || daemon.home().get("/components/scope/tasks")["tasks"][0].clone();
        let missed = |task: &Value| task["overruns"].as_u64().expect("a number");
        let (before, begin) = (missed(&task()), Instant::now());
        let processor = processor_time(daemon.process().id());
        std::thread::sleep(time);
        let used = processor_time(daemon.process().id()).saturating_sub(processor);
        let took = begin.elapsed().as_secs_f64();
        let after = task();
        over.store(true, Ordering::Relaxed);
        let seen = page.join().expect("the page");
        println!(
            "{name:24} {:>10.2} % {:>8} {:>11.1} µs {:>10.0} {:>10} {:>8} {:>10.1}",
            100.0 * used.as_secs_f64() / took,
            missed(&after) - before,
            after["lateness"]["p99_ns"].as_f64().expect("a number") / 1e3,
            seen.samples as f64 / (took + 1.0),
            seen.lost,
            seen.skipped,
            seen.bytes as f64 / (took + 1.0) / 1e3,
        );
    });
}

/// A link to sign in to the console.
fn sign_in_link(daemon: &Daemon) -> String {
    let made = daemon.json(&["web", "--rights", "read"]);
    made["url"].as_str().expect("a link").to_owned()
}

/// Reads the live stream of a page with all plots, until it is over.
fn watch(url: &str, over: &AtomicBool) -> Seen {
    let (address, secret) =
        url.trim_start_matches("http://").split_once("/sign-in#").expect("a link");
    let ask = |request: String| {
        let mut stream = TcpStream::connect(address).expect("the console listens");
        stream.write_all(request.as_bytes()).expect("it reads");
        BufReader::new(stream)
    };
    let head = format!("HTTP/1.1\r\nHost: {address}\r\nOrigin: http://{address}\r\n");
    let body = format!("{{\"link\":\"{secret}\"}}");
    let mut reply = String::new();
    let signing_in = format!(
        "POST /session {head}Connection: close\r\nContent-Length: {}\r\n\r\n{body}",
        body.len()
    );
    ask(signing_in).read_to_string(&mut reply).expect("a reply");
    let cookie =
        reply.lines().find_map(|line| line.strip_prefix("set-cookie: ")).expect("a cookie");
    let cookie = cookie.split(';').next().expect("a cookie");
    let plots: String = (0..PORTS).map(|port| format!("%26plot=p{port}")).collect();
    let path = format!("/live?rate=10&watch=/components/scope/plots?columns={COLUMNS}{plots}");
    let mut lines = ask(format!("GET {path} {head}Cookie: {cookie}\r\n\r\n")).lines();
    let mut seen = Seen::default();
    let mut lost = vec![0; PORTS];
    while !over.load(Ordering::Relaxed) {
        let line = lines.next().expect("the stream goes on").expect("a line");
        seen.bytes += line.len();
        let Some(data) = line.strip_prefix("data: ") else { continue };
        let told: Value = serde_json::from_str(data).expect("JSON");
        let Some(plots) = told["told"]["plots"].as_array().filter(|_| told["kind"] == "columns")
        else {
            continue;
        };
        seen.skipped = told["told"]["skipped"].as_u64().expect("a number");
        for plot in plots {
            let number = plot["plot"].as_u64().expect("a number") as usize;
            lost[number] = plot["lost"].as_u64().expect("a number");
            let columns = plot["columns"].as_array().expect("columns");
            seen.samples += columns.iter().filter_map(|one| one["samples"].as_u64()).sum::<u64>();
        }
    }
    seen.lost = lost.iter().sum();
    seen
}

/// Builds the component in a directory; returns its description.
fn scope(into: &Path) -> String {
    let (mut ports, mut uses, mut parameters, mut writes) =
        (String::new(), String::new(), String::new(), String::new());
    for port in 0..PORTS {
        let mut add = || {
            writeln!(ports, "  port out signal p{port};")?;
            write!(uses, ", out p{port}")?;
            write!(parameters, "const scope_p{port} *p{port}, ")?;
            writeln!(writes, "  *p{port}->data(self) = (double)(*count % {});", port + 2)?;
            writeln!(writes, "  p{port}->write(self);")
        };
        add().expect("a string takes all");
    }
    let description = format!(
        "component scope {{\n  typedef double signal;\n  ids {{ unsigned long count; }};\n{ports}  task main {{\n    period 1 ms;\n    \
         codel<start> scope_step(inout count{uses}) yield pause::start;\n    \
         codel<stop> scope_end() yield ether;\n  }};\n}};\n"
    );
    let codels = format!(
        "#include \"scope_c_types.h\"\n\ngenom_event\nscope_step(uint32_t *count, {parameters}const genom_context self)\n\
         {{\n  ++*count;\n{writes}  return scope_pause_start;\n}}\n\n\
         genom_event\nscope_end(const genom_context self)\n{{\n  (void)self;\n  return scope_ether;\n}}\n"
    );
    let file = |name: &str| into.join(name);
    let write = |name: &str, text: &str| std::fs::write(file(name), text).expect("a file");
    write("scope.gen", &description);
    write("scope.c", &codels);
    let mut header = Command::new(program("genomctl"));
    let header = Running::start(header.arg("header").arg(file("scope.gen"))).finish();
    header.expect_code(0);
    write("scope_c_types.h", &header.out);
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c99", "-O2", "-g", "-fPIC", "-shared", "-I"]);
    compiler.arg(genom_tests::repository().join("plugin-api/include")).arg("-I").arg(into);
    compiler.arg(file("scope.c")).arg("-o").arg(file("scope.so"));
    Running::start(&mut compiler).finish().expect_code(0);
    path(&file("scope.gen")).to_owned()
}
