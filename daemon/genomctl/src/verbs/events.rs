//! `genomctl events`: prints changes in the daemon as they happen.

use genom_protocol::{AnyChange, routes};
use tokio::signal::unix::{SignalKind, signal};

use crate::escape;
use crate::failure::Failure;
use crate::session::Session;

/// Print changes in the daemon as they happen, one per line, until Ctrl-C.
///
/// If the output is read too slowly, old changes are lost; `missed changes=COUNT` is printed in
/// their place.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Stop after this many events.
    #[arg(short = 'n', long, value_name = "COUNT")]
    count: Option<u64>,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let mut events = session.client.stream(&routes::events()).await?;
    // Before anything is printed: a reader of the first line may send the interrupt at once.
    let mut interrupt = signal(SignalKind::interrupt())?;
    let mut left = args.count.unwrap_or(u64::MAX);
    // Number of the last event, if the stream can be resumed after it.
    let mut last = None;
    while left > 0 {
        let event = tokio::select! {
            event = events.next() => event?,
            _ = interrupt.recv() => return Ok(()),
        };
        let Some(event) = event else {
            // The daemon drops readers that are blocked for long. After reconnecting, the events in
            // between are received.
            let after = last.take().ok_or_else(|| session.client.lost())?;
            let resumed = session.client.resume(&routes::events(), Some(after)).await;
            events = resumed.map_err(|_| session.client.lost())?;
            continue;
        };
        let text = if session.json { format!("{}\n", event.data) } else { render(&event.data) };
        session.print(&text)?;
        last = event.id;
        left -= 1;
    }
    Ok(())
}

/// The kind of event, then its members as `key=value`.
fn render(data: &str) -> String {
    let Ok(AnyChange { event: mut line, members }) = serde_json::from_str(data) else {
        return format!("{}\n", escape::line(data));
    };
    for (key, value) in &members {
        let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        line.push_str(&format!(" {key}={value}"));
    }
    escape::line(&line) + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_event_is_one_line() {
        let data = r#"{"event":"activity_ended","component":"demo","activity":3}"#;
        assert_eq!(render(data), "activity_ended component=demo activity=3\n");
    }
}
