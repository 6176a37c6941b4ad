//! `/diagnostics`, as aggregators and rqt_runtime_monitor read it: a status for each task of the
//! components that are nodes here, `NODE: TASK`, and one for each process that has a component,
//! `NODE: cell CELL`, also when it has ended and the node is gone.

use genom_middleware::{Diagnosis, Health, Part};
use ros2_client::builtin_interfaces::Time;
use serde::Serialize;

use crate::names;
use crate::own_topic::OwnTopic;
use crate::ros::Ros;

/// Levels of `diagnostic_msgs/msg/DiagnosticStatus`.
const OK: u8 = 0;
const WARN: u8 = 1;
const ERROR: u8 = 2;

/// Statuses of one message. A status of a task takes some 400 bytes; so many fit into one datagram.
const MOST: usize = 128;

/// The topic.
#[derive(Default)]
pub(crate) struct Diagnostics(OwnTopic);

/// `diagnostic_msgs/msg/DiagnosticArray`, with its header.
#[derive(Serialize)]
struct DiagnosticArray<'a> {
    stamp: Time,
    frame_id: &'a str,
    status: &'a [DiagnosticStatus<'a>],
}

/// `diagnostic_msgs/msg/DiagnosticStatus`. A `KeyValue` is two strings.
#[derive(Serialize)]
struct DiagnosticStatus<'a> {
    level: u8,
    name: String,
    message: &'a str,
    hardware_id: &'a str,
    values: &'a [(String, String)],
}

impl Diagnostics {
    /// Publishes how components fare that are nodes here, or were until their process ended.
    pub(crate) fn put(&self, ros: &Ros, all: &[Diagnosis]) {
        let nodes = ros.rmw.nodes();
        let of_node = all.iter().filter_map(|one| {
            let node = ros.names.node(&one.instance);
            let shown = matches!(one.of, Part::Cell(_)) || nodes.contains(&node);
            shown.then(|| status(names::split(&node).1, one))
        });
        let all: Vec<_> = of_node.collect();
        for status in all.chunks(MOST) {
            let message = DiagnosticArray { stamp: Time::now(), frame_id: "", status };
            self.0.put(ros, ("diagnostics", "diagnostic_msgs", "DiagnosticArray"), false, &message);
        }
    }
}

fn status<'a>(node: &str, one: &'a Diagnosis) -> DiagnosticStatus<'a> {
    DiagnosticStatus {
        level: match one.health {
            Health::Good => OK,
            Health::Late => WARN,
            Health::Stuck | Health::Ended => ERROR,
        },
        name: match &one.of {
            Part::Task(task) => format!("{node}: {task}"),
            Part::Cell(cell) => format!("{node}: cell {cell}"),
        },
        message: &one.message,
        hardware_id: "",
        values: &one.values,
    }
}
