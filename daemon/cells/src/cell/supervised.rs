//! What is to be done of other components when one in a cell breaks a rule of its supervision.

use std::time::Instant;

use genom_configuration::{Deployment, LoadRequest, Reaction, SupervisionEntry};
use genom_protocol::routes;
use serde_json::Value;

use super::Cell;
use crate::end::End;
use crate::policy::First;
use crate::setup::{Cause, Failure, Told};

/// The event that tells a broken rule.
pub(super) const VIOLATED: &str = "supervision_violated";

/// Broken rules of one cell for which something is done of other components, in a second.
const MOST_A_SECOND: u32 = 64;

impl Cell {
    /// Why its process ended, if that was for a broken rule; tells that and has done what is to be
    /// done.
    pub(super) async fn for_a_rule(&self, end: End) -> End {
        let Some((why, change)) = self.place.taken_broken_rule() else { return end };
        if change["event"] == VIOLATED {
            self.supervised(&change).await;
            self.setup.tell(Told::Change(change, None));
        }
        End::Supervised(why)
    }

    /// Has done what the broken rule asks for, but for what concerns components in this cell: it
    /// does that itself.
    pub(super) async fn supervised(&self, change: &Value) {
        let seen = Instant::now();
        let (Some(component), Some(index)) =
            (change["component"].as_str(), change["index"].as_u64())
        else {
            return;
        };
        // Whoever writes into this stream cannot have others called without end.
        match self.with(|state| state.rules_told.allows(MOST_A_SECOND, seen)) {
            Ok(()) => {}
            Err(First(false)) => return,
            Err(First(true)) => {
                let name = &self.name;
                tracing::error!(
                    "cell {name} breaks more than {MOST_A_SECOND} rules of supervision in a second: \
                     nothing is done for further ones"
                );
                return;
            }
        }
        let index = usize::try_from(index).unwrap_or(usize::MAX);
        let written = self.journal.read().unwrap_or_default();
        let rule = match rule_of(&written, component, index) {
            Some(rule) => Some(rule),
            // Loaded just now, and not written down yet.
            None => match self.client.ask(&routes::dump()).await {
                Ok(dumped) => rule_of(&dumped.deployment.runs, component, index),
                Err(_) => None,
            },
        };
        let Some(rule) = rule else { return };
        let elsewhere =
            |reaction: &&Reaction| reaction.deed().is_ok_and(|deed| !self.holds(&deed.component));
        let reactions: Vec<Reaction> = rule.others().filter(elsewhere).cloned().collect();
        if !reactions.is_empty() {
            let component = component.to_owned();
            let cause = Cause::BrokenRule;
            let failure = Failure { component, reactions, seen, cause, under_way: None };
            self.setup.tell(Told::Failed(failure));
        }
    }
}

fn rule_of(held: &Deployment, component: &str, index: usize) -> Option<SupervisionEntry> {
    let of = |one: &&LoadRequest| one.instance() == component;
    held.component.iter().find(of)?.supervision.get(index).cloned()
}
