//! `genomctl crashes`: how cells ended that nobody asked to end.

use clap_complete::engine::ArgValueCompleter;
use genom_protocol::{Crash, CrashReport, Crashes, routes};

use crate::complete::Names;
use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;

/// List the reports of cells whose process crashed, or print one: signal, codel, inputs, backtrace,
/// statistics of its tasks, and the end of its log.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The report to print: its name, or its number in the list, 1 for the newest.
    #[arg(value_name = "CRASH", add = ArgValueCompleter::from(Names::Crashes))]
    crash: Option<String>,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let name = match args.crash.as_deref().map(|typed| (typed, typed.parse::<usize>())) {
        None => {
            let reply = session.ask(routes::crashes()).await?;
            return session.show_table(&reply, render);
        }
        Some((typed, Ok(number))) => {
            let all = session.ask(routes::crashes()).await?.content.crashes;
            let found = number.checked_sub(1).and_then(|at| all.into_iter().nth(at));
            found.map_or_else(|| typed.to_owned(), |crash| crash.name)
        }
        Some((typed, Err(_))) => typed.to_owned(),
    };
    let reply = session.ask(routes::crash(&name)).await?;
    session.show(&reply, |report: &CrashReport| report.to_string())
}

fn render(reply: &Crashes) -> Table {
    let row = |(at, crash): (usize, &Crash)| {
        vec![
            (at + 1).to_string(),
            crash.name.clone(),
            crash.cell.clone(),
            crash.end.clone(),
            crash.codel.clone().unwrap_or_else(|| "-".to_owned()),
        ]
    };
    let rows = reply.crashes.iter().enumerate().map(row).collect();
    Table { header: vec!["#", "NAME", "CELL", "END", "CODEL"], rows }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crashes_are_numbered_from_the_newest() {
        let crash = |name: &str, codel: Option<&str>| Crash {
            name: name.into(),
            time: 0.0,
            cell: "arm".into(),
            end: "signal 9 (SIGKILL)".into(),
            codel: codel.map(str::to_owned),
        };
        let crashes = vec![crash("crash-2-arm", Some("go")), crash("crash-1-arm", None)];
        let table = render(&Crashes { directory: None, crashes });
        assert_eq!(table.rows[0], ["1", "crash-2-arm", "arm", "signal 9 (SIGKILL)", "go"]);
        assert_eq!(table.rows[1], ["2", "crash-1-arm", "arm", "signal 9 (SIGKILL)", "-"]);
    }
}
