//! `genomctl stats`: shows statistics of tasks and codels.

use clap_complete::engine::ArgValueCompleter;
use genom_protocol::{CodelStatistics, RunningCodel, Statistics, Unpaused, routes};

use crate::complete::Names;
use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;
use genom_drawing::units::duration;

/// Show the statistics of the tasks of a component, or of its codels.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of the component.
    #[arg(add = ArgValueCompleter::from(Names::Components))]
    component: String,
    /// Show its codels: how long calls took, and what they returned how often.
    #[arg(long)]
    codels: bool,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let reply = session.ask(routes::statistics(&args.component)).await?;
    session.show_table(&reply, if args.codels { codels } else { render })?;
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

fn codels(reply: &Statistics) -> Table {
    let row = |codel: &CodelStatistics| {
        let of = &codel.durations;
        let yielded = codel.yielded.iter().map(|one| format!("{} {}", one.event, one.count));
        vec![
            codel.name.clone(),
            codel.owner.clone(),
            of.count.to_string(),
            duration(of.min_ns),
            duration(of.mean_ns),
            duration(of.max_ns),
            codel.wcet_ns.map_or_else(|| "-".to_owned(), duration),
            codel.above_wcet.to_string(),
            yielded.collect::<Vec<_>>().join(", "),
        ]
    };
    let header =
        vec!["CODEL", "OF", "CALLS", "SHORTEST", "MEAN", "LONGEST", "WCET", "ABOVE", "YIELDED"];
    Table { header, rows: reply.codels.iter().map(row).collect() }
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

    #[test]
    fn a_codel_is_one_line_with_what_it_returned() {
        let durations = json!({"count": 7, "last_ns": 900, "mean_ns": 900, "p50_ns": 900,
            "p99_ns": 900, "min_ns": 20, "max_ns": 3_000});
        let reply = serde_json::from_value(json!({"tasks": [], "codels": [{
            "name": "servo", "owner": "goto", "durations": durations, "wcet_ns": 2_000,
            "above_wcet": 1,
            "yielded": [{"event": "pause::main", "count": 6}, {"event": "ether", "count": 1}],
        }], "lost_changes": 0}));
        expect![[r#"
            CODEL  OF    CALLS  SHORTEST  MEAN    LONGEST   WCET      ABOVE  YIELDED
            servo  goto  7      20 ns     900 ns  3.000 us  2.000 us  1      pause::main 6, ether 1
        "#]]
        .assert_eq(&codels(&reply.unwrap()).text(crate::terminal::Terminal::default()));
    }
}
