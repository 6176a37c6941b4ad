//! Spans of services reach an OpenTelemetry collector over HTTP.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

use genom_tests::{Home, WATCHDOG, component, path};
use serde_json::Value;

/// A collector that accepts everything.
struct Collector {
    address: String,
    requests: Receiver<(String, Value)>,
}

impl Collector {
    fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port is free");
        let address = listener.local_addr().unwrap().to_string();
        let (sender, requests) = channel();
        thread::spawn(move || {
            listener.incoming().map_while(Result::ok).try_for_each(|stream| take(stream, &sender))
        });
        Self { address, requests }
    }

    /// Waits for the next span of this name.
    fn span(&self, name: &str) -> Value {
        let mut seen = Vec::new();
        loop {
            let Ok((_, body)) = self.requests.recv_timeout(WATCHDOG) else {
                panic!("no span of {name} among {seen:?}");
            };
            let spans = body["resourceSpans"][0]["scopeSpans"][0]["spans"].clone();
            for span in spans.as_array().expect("spans") {
                if span["name"] == name {
                    return span.clone();
                }
                seen.push(span["name"].clone());
            }
        }
    }
}

/// Reads one request and accepts it; `None` if the test no longer listens.
fn take(stream: TcpStream, sender: &Sender<(String, Value)>) -> Option<()> {
    let mut reader = BufReader::new(stream);
    let (mut first, mut length) = (String::new(), 0);
    reader.read_line(&mut first).ok()?;
    loop {
        let mut line = String::new();
        reader.read_line(&mut line).ok()?;
        if let Some(value) = line.to_ascii_lowercase().strip_prefix("content-length:") {
            length = value.trim().parse().ok()?;
        }
        if line.trim().is_empty() {
            break;
        }
    }
    let mut body = vec![0; length];
    reader.read_exact(&mut body).ok()?;
    reader.get_mut().write_all(b"HTTP/1.1 200 OK\r\nContent-Length: 2\r\n\r\n{}").ok()?;
    sender.send((first, serde_json::from_slice(&body).expect("JSON"))).ok()
}

fn attribute<'a>(span: &'a Value, key: &str) -> &'a Value {
    let mut all = span["attributes"].as_array().expect("attributes").iter();
    &all.find(|one| one["key"] == key).unwrap_or_else(|| panic!("no {key} in {span}"))["value"]
}

#[test]
fn a_collector_gets_a_span_for_each_service_that_is_called() {
    let collector = Collector::start();
    let config = format!(
        "log = \"error,genomd::run=info\"\n[telemetry]\notlp = \"http://{}\"\n",
        collector.address
    );
    let demo = component("demo");
    let daemon = Home::new().configured(&config).start(&[path(&demo.library)]);

    daemon.ctl(&["call", "demo", "set_speed", "velocity=2"]).expect_code(0);
    let span = collector.span("demo/set_speed");
    assert_eq!(attribute(&span, "genom.service")["stringValue"], "set_speed");
    assert_eq!(span["status"]["code"], 1);
    assert_eq!(span["traceId"].as_str().unwrap().len(), 32);

    daemon.ctl(&["call", "demo", "goto", "goal=0.1"]).expect_code(0);
    let span = collector.span("demo/goto");
    let date = |key: &str| span[key].as_str().unwrap().parse::<u64>().unwrap();
    // 0.1 m at 2 m/s.
    assert!(date("endTimeUnixNano") - date("startTimeUnixNano") >= 50_000_000, "{span}");
    assert!(attribute(&span, "genom.activity")["intValue"].is_string());

    daemon.ctl(&["call", "demo", "goto", "goal=99"]).expect_code(1);
    let span = collector.span("demo/goto");
    assert_eq!(span["status"]["code"], 2);
    assert_eq!(span["status"]["message"], "::demo::OUT_OF_RANGE");

    // Activities that are running when the daemon stops are exported, too.
    daemon.ctl(&["start", "demo", "goto", "goal=-9"]).expect_code(0);
    let (stopped, _) = daemon.stop("TERM");
    stopped.expect_code(0);
    collector.span("demo/goto");
}

#[test]
fn a_collector_that_is_not_there_holds_up_nobody() {
    let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let config = format!("[telemetry]\notlp = \"http://{address}\"\n");
    let demo = component("demo");
    let daemon = Home::new().configured(&config).start(&[path(&demo.library)]);
    daemon.ctl(&["call", "demo", "get_speed"]).expect_code(0);
    let told = daemon.process().error_line_where(|line| line.contains("spans are not taken by"));
    assert!(told.is_some());
    let (stopped, _) = daemon.stop("TERM");
    stopped.expect_code(0);

    let home = Home::new().configured("[telemetry]\notlp = \"https://example.org\"\n");
    home.refused(&[]).expect_code(2).expect_err("telemetry.otlp: `https://example.org`");
}
