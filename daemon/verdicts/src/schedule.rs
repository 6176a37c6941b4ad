//! How long the cycles of tasks may take, as JSON; and for all components of one machine also for
//! people.

use genom_formal::{Cause, Change, OnMachine, Schedule, Scheduled};
use serde_json::{Value, json};

use crate::measured::Measured;
use crate::sums;

/// What was found of the components of one machine.
#[derive(Debug)]
pub struct Told {
    /// Processors that they share.
    pub processors: usize,
    /// The tasks that were looked at.
    pub tasks: Vec<OnMachine>,
    /// What would make tasks be in time.
    pub changes: Vec<Change>,
    /// Components that were left out, each with the reason.
    pub left_out: Vec<(String, String)>,
    /// What was measured, by the name of the component.
    pub measured: Vec<(String, Measured)>,
}

impl Told {
    /// For people.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::new();
        for (name, measured) in &self.measured {
            text.push_str(&format!("{name}, measured:\n{}", measured.text()));
        }
        let plural = if self.processors == 1 { "" } else { "s" };
        text.push_str(&format!("{} processor{plural}\n", self.processors));
        for one in &self.tasks {
            text.push_str(&sums::placed(one));
        }
        for (name, why) in &self.left_out {
            text.push_str(&format!(
                "{name}: no bound: {why}; the others are told as if it were not there\n"
            ));
        }
        for change in &self.changes {
            text.push_str(&format!("{}\n", sums::change(change)));
        }
        text
    }

    /// The same as JSON.
    #[must_use]
    pub fn data(&self) -> Value {
        let one = |one: &OnMachine| {
            let mut data = task(&one.task);
            data["component"] = one.component.clone().into();
            data["cpus"] = json!(one.cpus);
            data["late"] = matches!(one.task.response, Err(Cause::Late(_))).into();
            data
        };
        let left_out = |(name, why): &(String, String)| json!({ "component": name, "why": why });
        let codels =
            |(name, one): &(String, Measured)| json!({ "component": name, "codels": one.data() });
        json!({
            "processors": self.processors,
            "tasks": self.tasks.iter().map(one).collect::<Vec<_>>(),
            "left_out": self.left_out.iter().map(left_out).collect::<Vec<_>>(),
            "changes": self.changes.iter().map(change).collect::<Vec<_>>(),
            "measured": self.measured.iter().map(codels).collect::<Vec<_>>(),
        })
    }
}

fn change(change: &Change) -> Value {
    match change {
        Change::Order(tasks) => json!({ "priorities": tasks }),
        Change::Processor { task, cpu } => json!({ "task": task, "cpu": cpu }),
        Change::Time { codel, below, task } => {
            json!({ "codel": codel, "below_ns": below, "task": task })
        }
    }
}

/// Whether a task may be late.
#[must_use]
pub fn is_late(task: &Scheduled) -> bool {
    matches!(task.response, Err(Cause::Late(_)))
}

/// The tasks of one component as JSON.
#[must_use]
pub fn data(name: &str, schedule: &Schedule) -> Value {
    let tasks: Vec<Value> = schedule.tasks.iter().map(task).collect();
    json!({ "component": name, "tasks": tasks, "without_period": schedule.others })
}

fn task(task: &Scheduled) -> Value {
    let pairs = |key: &str, value: &str, all: &[(String, u64)]| {
        let one = |(name, ns): &(String, u64)| json!({ key: name, value: ns });
        all.iter().map(one).collect::<Vec<_>>()
    };
    let called = task.called.iter().map(|called| {
        let waits = called.waits.iter();
        let waits =
            waits.map(|one| json!({ "of": one.of, "codel": one.codel, "most_ns": one.most }));
        json!({
            "codel": called.codel, "activity": called.activity, "most_ns": called.most,
            "waits": waits.collect::<Vec<_>>(),
        })
    });
    json!({
        "task": task.name,
        "period_ns": task.period,
        "response_ns": task.response.as_ref().ok(),
        "why": task.response.as_ref().err().map(sums::cause),
        "work_ns": task.work,
        "called": called.collect::<Vec<_>>(),
        "preempted_by": pairs("task", "work_ns", &task.preempted_by),
        "needed": pairs("codel", "below_ns", &task.needed),
    })
}
