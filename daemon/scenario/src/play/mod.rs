//! Plays a scenario, step by step, on a daemon.

mod act;
mod daemon;
mod expect;
mod fault;
mod history;
mod pace;
mod player;
mod relay;
mod time;
mod why;

use std::cell::Cell;

pub use daemon::{Daemon, Trouble};

use crate::duration::short;
use crate::model::{Action, Expected, Scenario, Step};
use crate::report::{Outcome, Played, Unmet};
use player::Player;
use why::Why;

/// How far a scenario that is being played got, for who ends it.
#[derive(Debug, Default)]
pub struct Progress(Cell<Played>);

impl Progress {
    /// How it stands if it is not played on: the step that was under way did not end.
    #[must_use]
    pub fn given_up(&self, scenario: &Scenario, why: &str) -> (Outcome, Played) {
        let played = self.0.get();
        let outcome = scenario.steps.get(played.steps).map_or(Outcome::Passed, |step| {
            let expected = "that the step ends".to_owned();
            Outcome::Error(unmet(step, played.nanoseconds, expected, why.to_owned(), None))
        });
        (outcome, played)
    }
}

/// Plays a scenario on a daemon that has its setup, up to the first step that does not hold.
pub async fn play<D: Daemon>(
    scenario: &Scenario,
    daemon: &D,
    progress: &Progress,
) -> (Outcome, Played) {
    let mut player = Player::new(daemon);
    for (steps, step) in scenario.steps.iter().enumerate() {
        progress.0.set(Played { steps, nanoseconds: player.now });
        let Err(why) = player.act(&step.action).await else { continue };
        let unmet = |expected, came, help| unmet(step, player.now, expected, came, help);
        let outcome = match why {
            Why::Unmet { expected, came } => Outcome::Failed(unmet(expected, came, None)),
            Why::Trouble(Trouble::Refused(reason)) => {
                let came = format!("refused: {}", reason.message);
                Outcome::Failed(unmet("that it is done".to_owned(), came, reason.help))
            }
            Why::Trouble(Trouble::Gone(why)) => {
                Outcome::Error(unmet("an answer of the daemon".to_owned(), why, None))
            }
        };
        return (outcome, Played { steps, nanoseconds: player.now });
    }
    let steps = scenario.steps.len();
    (Outcome::Passed, Played { steps, nanoseconds: player.now })
}

fn unmet(
    step: &Step,
    nanoseconds: u64,
    expected: String,
    came: String,
    help: Option<String>,
) -> Unmet {
    let (line, step) = (step.place.line, told(&step.action));
    Unmet { line, step, nanoseconds, expected, came, help }
}

/// A step in a few words.
fn told(action: &Action) -> String {
    match action {
        Action::Load(request) => format!("load {}", request.instance()),
        Action::Unload(component) => format!("unload {component}"),
        Action::Connect(request) => format!("connect {} to {}", request.inport, request.outport),
        Action::Disconnect(port) => format!("disconnect {port}"),
        Action::Advance(span) => format!("step {}", short(*span)),
        Action::Publish { port, .. } => format!("publish {port}"),
        Action::Call { service, .. } => format!("call {service}"),
        Action::Start { service, .. } => format!("start {service}"),
        Action::Abort(of) => format!("abort {of}"),
        Action::Wait { of, .. } => format!("wait {of}"),
        Action::Fire { component, event } => format!("fire {component}/{event}"),
        Action::Expect(Expected::Port { port, .. }) => format!("expect {port}"),
        Action::Expect(Expected::Activity { of, .. }) => format!("expect {of}"),
        Action::Expect(Expected::Component { name, .. }) => format!("expect {name}"),
        Action::Fault(fault) => format!("fault {}", fault.port),
        Action::Repair(port) => format!("repair {port}"),
        Action::Kill(cell) => format!("kill {cell}"),
    }
}

#[cfg(test)]
mod tests;
