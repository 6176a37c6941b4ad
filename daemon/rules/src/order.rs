//! Orders become automata.

use genom_protocol::supervision::Order as Steps;
use genom_runtime::{Happening, Order, Rule};

use crate::{Compiler, NoSuchRule};

impl Compiler<'_> {
    pub(crate) fn order(&self, steps: &Steps) -> Result<Rule, NoSuchRule> {
        let states = steps.states();
        let mut events: Vec<(String, Vec<Happening>)> = Vec::new();
        let mut walked = Vec::new();
        for step in &steps.steps {
            let happening = self.happening(&step.event)?;
            let known = events.iter().position(|(_, other)| *other == happening);
            let by = known.unwrap_or_else(|| {
                events.push((step.event.to_string(), happening));
                events.len() - 1
            });
            let place = |name: &str| states.iter().position(|state| *state == name);
            let (Some(from), Some(to)) = (place(&step.from), place(&step.to)) else { continue };
            if walked.iter().any(|&(other, way, _)| (other, way) == (from, by)) {
                let (event, from) = (&step.event, &step.from);
                return self.idle(format!("{event} leads two ways from state {from}"));
            }
            walked.push((from, by, to));
        }
        let states = states.into_iter().map(str::to_owned).collect();
        match Order::new(states, events, &walked) {
            Ok(order) => Ok(Rule::Order(order)),
            Err(why) => self.idle(why.to_string()),
        }
    }
}
