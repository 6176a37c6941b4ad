//! `genomctl stats`: shows statistics of tasks.

use clap_complete::engine::ArgValueCompleter;
use genom_protocol::{RunningCodel, Statistics, Unpaused, routes};

use crate::complete::Names;
use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;
use crate::units::duration;

/// Show the statistics of the tasks of a component.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of the component.
    #[arg(add = ArgValueCompleter::from(Names::Components))]
    component: String,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let reply = session.ask(routes::statistics(&args.component)).await?;
    session.show_table(&reply, render)?;
    for task in &reply.content.tasks {
        if let Some(RunningCodel { codel, for_ns, .. }) = &task.stuck {
            let (name, time) = (&task.name, for_ns / 1_000_000_000);
            session.tell(&format!("task {name} is stuck in {codel} for {time} s"))?;
        }
        if let Some(Unpaused { codel, for_ns, .. }) = &task.unpaused {
            let (name, time) = (&task.name, for_ns / 1_000_000_000);
            session.tell(&format!("task {name} did not pause for {time} s, lately in {codel}"))?;
        }
    }
    Ok(())
}

fn render(reply: &Statistics) -> Table {
    let rows: Vec<_> = reply
        .tasks
        .iter()
        .map(|task| {
            vec![
                task.name.clone(),
                task.period_ns.map_or_else(|| "-".to_owned(), duration),
                if task.real_time { "yes" } else { "no" }.to_owned(),
                task.cycles.count.to_string(),
                task.overruns.to_string(),
                duration(task.cycles.mean_ns),
                duration(task.cycles.max_ns),
                duration(task.lateness.p99_ns),
            ]
        })
        .collect();
    let header = vec![
        "TASK",
        "PERIOD",
        "REAL-TIME",
        "CYCLES",
        "OVERRUNS",
        "WORK",
        "LONGEST",
        "LATENESS P99",
    ];
    Table { header, rows }
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;
    use serde_json::json;

    #[test]
    fn a_task_is_one_line() {
        let durations = |ns| json!({"count": 7, "last_ns": ns, "mean_ns": ns, "p50_ns": ns, "p99_ns": ns, "max_ns": ns});
        let reply = serde_json::from_value(json!({"tasks": [{
            "name": "main", "period_ns": 5_000_000, "real_time": false,
            "cycles": durations(900), "lateness": durations(85_000), "overruns": 0,
        }], "codels": [], "lost_changes": 0}));
        expect![[r#"
            TASK  PERIOD    REAL-TIME  CYCLES  OVERRUNS  WORK    LONGEST  LATENESS P99
            main  5.000 ms  no         7       0         900 ns  900 ns   85.000 us
        "#]]
        .assert_eq(&render(&reply.unwrap()).text(crate::terminal::Terminal::default()));
    }
}
