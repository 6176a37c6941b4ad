//! `genomctl logs`: what the daemon logged, and what it logs.

use clap_complete::engine::ArgValueCompleter;
use serde::Deserialize;
use tokio::signal::unix::{SignalKind, signal};

use crate::complete::Names;
use crate::failure::Failure;
use crate::names::encode;
use crate::session::Session;
use crate::terminal::{Terminal, Tone};

/// Print what the daemon logged lately, of all components or of one.
///
/// What `genomd --log` leaves out is not there, nor is what codels print themselves: that goes
/// straight to genomd's own standard output and error, so that no codel waits for a reader.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of a component: only what is about it.
    #[arg(add = ArgValueCompleter::from(Names::Components))]
    component: Option<String>,
    /// This level and graver ones.
    #[arg(long, value_enum, default_value_t = Level::Trace)]
    level: Level,
    /// At most this many entries, the latest.
    #[arg(short = 'n', long, value_name = "COUNT")]
    last: Option<usize>,
    /// Go on as the daemon logs, until Ctrl-C.
    #[arg(short, long)]
    follow: bool,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Level {
    Error,
    Warn,
    Info,
    Debug,
    Trace,
}

impl Level {
    fn name(self) -> &'static str {
        match self {
            Level::Error => "error",
            Level::Warn => "warn",
            Level::Info => "info",
            Level::Debug => "debug",
            Level::Trace => "trace",
        }
    }
}

#[derive(Debug, Deserialize)]
struct Reply {
    logs: Vec<Entry>,
}

#[derive(Debug, Deserialize)]
struct Entry {
    time: f64,
    level: String,
    #[serde(default)]
    component: Option<String>,
    message: String,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let mut query = format!("?level={}", args.level.name());
    if let Some(component) = &args.component {
        query.push_str(&format!("&component={}", encode(component)));
    }
    if let Some(last) = args.last {
        query.push_str(&format!("&last={last}"));
    }
    if !args.follow {
        let reply = session.get(&format!("/logs{query}")).await?;
        return session.show(reply, |reply: &Reply| {
            reply.logs.iter().map(|entry| render(entry, session.terminal)).collect()
        });
    }
    if args.last.is_none() {
        // All that is kept, then what comes.
        query.push_str("&last=1024");
    }
    // Before anything is said: who reads a line may interrupt at once.
    let mut interrupt = signal(SignalKind::interrupt())?;
    let mut stream = session.client.stream(&format!("/logs/stream{query}")).await?;
    loop {
        let event = tokio::select! {
            event = stream.next() => event?,
            _ = interrupt.recv() => return Ok(()),
        };
        let Some(event) = event else { return Err(session.client.lost()) };
        if session.json {
            session.print(&format!("{}\n", event.data))?;
        } else {
            let data = serde_json::from_str(&event.data).unwrap_or_default();
            session.print(&render(&session.read(data)?, session.terminal))?;
        }
    }
}

/// `12:34:56.789 WARN  demo: message`, in UTC as the daemon's own log.
fn render(entry: &Entry, terminal: Terminal) -> String {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a date")]
    let milliseconds = (entry.time * 1e3) as u64;
    let (seconds, rest) = (milliseconds / 1000, milliseconds % 1000);
    let (hour, minute, second) = (seconds / 3600 % 24, seconds / 60 % 60, seconds % 60);
    let component = entry.component.as_ref().map_or_else(String::new, |name| format!("{name}: "));
    let level = format!("{:<5}", entry.level.to_uppercase());
    let tone = Tone::of(&entry.level).filter(|_| terminal.colour);
    let level = tone.map_or(level.clone(), |tone| tone.paint(&level));
    format!("{hour:02}:{minute:02}:{second:02}.{rest:03} {level} {component}{}\n", entry.message)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entry_is_one_line_with_its_time_and_component() {
        let entry = Entry {
            time: 86_399.25,
            level: "warn".into(),
            component: Some("demo".into()),
            message: "odd".into(),
        };
        assert_eq!(render(&entry, Terminal::default()), "23:59:59.250 WARN  demo: odd\n");
    }
}
