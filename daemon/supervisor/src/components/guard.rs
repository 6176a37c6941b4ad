//! What is done when a component breaks a rule of its supervision.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use genom_bus::withheld::Withheld;
use genom_configuration::{OwnResponse, Reaction, SupervisionEntry};
use genom_protocol::{Broken, Kind, Rule};
use genom_runtime::Violation;

use crate::reactor::{Asked, Reactions};
use genom_bus::{Bus, Change};

/// Time between two violations of a rule that are told and acted upon, in nanoseconds of the
/// component's clock. Those between are counted, and interrupt activities.
const AGAIN: u64 = 1_000_000_000;

/// The rules of one component.
pub struct Guard {
    component: String,
    bus: Arc<Bus>,
    reactions: Arc<Reactions>,
    withheld: Arc<Withheld>,
    rules: Vec<Ruled>,
}

/// A rule.
struct Ruled {
    entry: SupervisionEntry,
    /// In words.
    text: String,
    kind: Kind,
    responses: Vec<String>,
    /// When a violation was told last.
    told: Mutex<Option<u64>>,
    /// The last violation, whether it was told or not.
    last: Mutex<Option<Broken>>,
}

impl Guard {
    /// The rules of a request, which are valid.
    pub(crate) fn new(
        component: &str,
        bus: &Arc<Bus>,
        (reactions, withheld): (&Arc<Reactions>, &Arc<Withheld>),
        rules: &[SupervisionEntry],
    ) -> Self {
        let ruled = |entry: &SupervisionEntry| {
            let condition = entry.condition().ok()?;
            Some(Ruled {
                text: condition.to_string(),
                kind: condition.kind(),
                responses: entry.responses().iter().map(ToString::to_string).collect(),
                entry: entry.clone(),
                told: Mutex::default(),
                last: Mutex::default(),
            })
        };
        Self {
            component: component.to_owned(),
            bus: Arc::clone(bus),
            reactions: Arc::clone(reactions),
            withheld: Arc::clone(withheld),
            rules: rules.iter().filter_map(ruled).collect(),
        }
    }

    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.rules.is_empty()
    }

    /// The rules, with how often each was broken.
    pub(super) fn told(&self, counts: Vec<u64>) -> Vec<Rule> {
        let rules = self.rules.iter().zip(counts).map(|(ruled, violations)| Rule {
            rule: ruled.text.clone(),
            kind: ruled.kind,
            reactions: ruled.responses.clone(),
            violations,
            last: ruled.last.lock().unwrap_or_else(PoisonError::into_inner).clone(),
        });
        rules.collect()
    }

    /// A rule was broken: tells it, and does what is to be done; the instance has interrupted
    /// activities itself.
    pub(crate) fn violated(&self, violation: &Violation) {
        let seen = Instant::now();
        let Some(rule) = self.rules.get(violation.rule) else { return };
        rule.keep(violation);
        if !rule.is_due(violation.date) {
            return;
        }
        let Violation { what, count, .. } = violation;
        let (kind, text, responses) = (rule.kind, &rule.text, rule.responses.join(", "));
        let again = if *count > 1 { format!(" ({count} times so far)") } else { String::new() };
        tracing::warn!(
            instance = self.component,
            "{what}: {} supervision, {text}{again}; {responses}",
            kind.name()
        );
        let told = Change::SupervisionViolated {
            component: self.component.clone(),
            index: violation.rule,
            rule: text.clone(),
            kind,
            what: what.clone(),
            activity: violation.activity.map(u64::from),
            violations: *count,
            reactions: rule.responses.clone(),
        };
        let reactor = || self.reactions.get();
        if rule.entry.does(OwnResponse::Restart)
            && let Some(reactor) = reactor()
        {
            // Whoever sees the end does the rest.
            let why = format!("{} supervision of {}: {what}", kind.name(), self.component);
            return reactor.restart(&told, &why, violation.thread);
        }
        if rule.entry.responses().iter().any(|one| !one.is(OwnResponse::Log)) {
            self.bus.tell(&told);
        }
        if rule.entry.does(OwnResponse::Withhold) {
            let why = format!("{} supervision of {}: {what}", kind.name(), self.component);
            self.withheld.withhold(&self.component, why);
        }
        let mut reactions: Vec<Reaction> = rule.entry.others().cloned().collect();
        if rule.entry.does(OwnResponse::Kill) {
            let call = Some(format!("{}/kill", self.component));
            reactions.push(Reaction { call, ..Reaction::default() });
        }
        if !reactions.is_empty()
            && let Some(reactor) = reactor()
        {
            reactor.react(Asked { component: self.component.clone(), reactions, seen });
        }
    }
}

impl Ruled {
    fn keep(&self, violation: &Violation) {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let last = Broken {
            what: violation.what.clone(),
            unix_ms: u64::try_from(since.as_millis()).unwrap_or(u64::MAX),
            activity: violation.activity.map(u64::from),
            value: violation.value,
            bound: violation.bound,
        };
        *self.last.lock().unwrap_or_else(PoisonError::into_inner) = Some(last);
    }

    /// Whether a violation at this date is told.
    fn is_due(&self, date: u64) -> bool {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        let due = told.is_none_or(|told| date.saturating_sub(told) >= AGAIN);
        if due {
            *told = Some(date);
        }
        due
    }
}
