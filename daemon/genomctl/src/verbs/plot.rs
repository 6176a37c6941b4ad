//! `genomctl plot`: plots numbers of ports.

use std::io::{self, IsTerminal as _, Write as _};
use std::time::Duration;

use clap_complete::engine::ArgValueCompleter;
use genom_drawing::plot::text;
use tokio::signal::unix::{SignalKind, signal};

use crate::complete::Names;
use crate::failure::Failure;
use crate::plot::{self, Samples};
use crate::session::Session;
use crate::times::seconds;

/// Plot numbers of ports in the terminal, live, until q.
///
/// Every sample counts: each column of dots shows the least and the greatest value of its time, so
/// that no peak is missed at any rate. Without a terminal, or with --once, the plot is printed once,
/// after the time that it shows; with `--json`, as numbers.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// What to plot: COMPONENT/PORT[.MEMBER] or COMPONENT/PORT/ELEMENT[.MEMBER], with members such as
    /// velocity, pose.x or samples.0; without one, all numbers of the port, 8 at most.
    #[arg(required = true, value_name = "PORT", add = ArgValueCompleter::from(Names::Ports))]
    ports: Vec<String>,
    /// Seconds that the plot shows.
    #[arg(long, short, value_name = "SECONDS", default_value = "10", value_parser = seconds)]
    span: Duration,
    /// Print the plot once.
    #[arg(long)]
    once: bool,
}

/// Size of the printed plot, in characters.
const SIZE: (u16, u16) = (100, 24);

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let span = u64::try_from(args.span.as_nanos()).unwrap_or(u64::MAX);
    if span == 0 {
        return Err(Failure::usage("--span 0: no time", "try 10"));
    }
    let mut interrupt = signal(SignalKind::interrupt())?;
    let chosen = plot::choose(session, &args.ports).await?;
    let (mut samples, mut plot) = Samples::begin(session, chosen, span).await?;
    if !session.json && !args.once && io::stdout().is_terminal() && io::stdin().is_terminal() {
        return plot::run(&mut samples, &mut plot).await;
    }
    let told = format!("plotting for {} s; Ctrl-C ends it\n", args.span.as_secs_f64());
    io::stderr().lock().write_all(told.as_bytes())?;
    let mut over = std::pin::pin!(tokio::time::sleep(args.span));
    loop {
        tokio::select! {
            biased;
            () = &mut over => break,
            _ = interrupt.recv() => break,
            more = samples.next(&mut plot) => if !more? { break },
        }
    }
    if session.json {
        return session.print(&format!("{}\n", plot.data()));
    }
    let size = io::stdout().is_terminal().then(crossterm::terminal::size);
    let (width, height) = size.and_then(Result::ok).unwrap_or(SIZE);
    session.print(&text(&plot, width.max(20), height.saturating_sub(1).max(8)))
}
