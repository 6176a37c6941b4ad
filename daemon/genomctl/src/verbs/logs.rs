//! `genomctl logs`: prints the daemon's log.

use clap_complete::engine::ArgValueCompleter;
use genom_protocol::{Level, LogEntry, LogParameters, Logs, routes};
use tokio::signal::unix::{SignalKind, signal};

use crate::complete::Names;
use crate::failure::Failure;
use crate::session::Session;
use crate::terminal::{Terminal, Tone};

/// Print the latest entries of the daemon's log, on all components or on one.
///
/// Entries that `genomd --log` filters out are not included, nor is what codels print: that goes
/// directly to the standard output and error of genomd, so that codels never wait for a reader.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of a component, for entries about it only.
    #[arg(add = ArgValueCompleter::from(Names::Components))]
    component: Option<String>,
    /// Only entries of this level and more severe ones.
    #[arg(long, value_enum, default_value_t = Level::Trace)]
    level: Level,
    /// Maximum number of entries; the latest ones are printed.
    #[arg(short = 'n', long, value_name = "COUNT")]
    last: Option<usize>,
    /// Continue with new entries, until Ctrl-C.
    #[arg(short, long)]
    follow: bool,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let level = Some(args.level.to_string());
    let mut query = LogParameters { level, component: args.component, last: args.last };
    if !args.follow {
        let reply = session.ask(routes::logs().with(&query)).await?;
        return session.show(&reply, |reply: &Logs| {
            reply.logs.iter().map(|entry| render(entry, session.terminal)).collect()
        });
    }
    // All entries that the daemon keeps, then new ones.
    query.last.get_or_insert(1024);
    // Before anything is printed: a reader of the first line may send the interrupt at once.
    let mut interrupt = signal(SignalKind::interrupt())?;
    let mut stream = session.client.stream(&routes::log_stream().with(&query)).await?;
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
            session.print(&render(&session.reply(data)?.content, session.terminal))?;
        }
    }
}

/// `12:34:56.789 WARN  demo: message`, in UTC as in the daemon's own log.
fn render(entry: &LogEntry, terminal: Terminal) -> String {
    let time = entry.time_of_day();
    let component = entry.component.as_ref().map_or_else(String::new, |name| format!("{name}: "));
    let level = format!("{:<5}", entry.level.to_string().to_uppercase());
    let tone = Tone::of(entry.level.into()).filter(|_| terminal.colour);
    let level = tone.map_or(level.clone(), |tone| tone.paint(&level));
    format!("{time} {level} {component}{}\n", entry.message)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entry_is_one_line_with_its_time_and_component() {
        let entry = LogEntry {
            time: 86_399.25,
            level: Level::Warn,
            origin: "genomd".into(),
            file: None,
            line: None,
            component: Some("demo".into()),
            message: "odd".into(),
        };
        assert_eq!(render(&entry, Terminal::default()), "23:59:59.250 WARN  demo: odd\n");
    }
}
