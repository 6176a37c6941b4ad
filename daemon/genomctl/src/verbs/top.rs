//! `genomctl top`: shows activity live.

use std::io::{self, IsTerminal as _};
use std::time::Duration;

use genom_drawing::top::text;
use serde_json::json;

use crate::failure::Failure;
use crate::session::Session;
use crate::top;

/// Show tasks, activities and ports live, until q.
///
/// Without a terminal, or with --once, the table is printed once, from two readings.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Print the table once.
    #[arg(long)]
    once: bool,
    /// Seconds between two readings.
    #[arg(long, short, value_name = "SECONDS", default_value_t = 1.0)]
    delay: f64,
}

/// Width of the printed table, in columns.
const WIDTH: u16 = 100;

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let delay = Duration::try_from_secs_f64(args.delay).ok().filter(|delay| !delay.is_zero());
    let Some(delay) = delay else {
        return Err(Failure::usage(format!("--delay {}: no time", args.delay), "try 1"));
    };
    if !session.json && !args.once && io::stdout().is_terminal() && io::stdin().is_terminal() {
        return top::run(session, delay).await;
    }
    let first = top::take(session).await?;
    if session.json {
        return session.print(&format!("{}\n", json!(first.data())));
    }
    // Rates are computed from two readings.
    tokio::time::sleep(delay).await;
    let now = top::take(session).await?;
    session.print(&text(&now, Some(&first), terminal_width().unwrap_or(WIDTH)))
}

fn terminal_width() -> Option<u16> {
    io::stdout().is_terminal().then(crossterm::terminal::size)?.ok().map(|(width, _)| width.max(20))
}
