//! What users can do about a problem; both the daemon (`genomctl why`) and `genomctl doctor` print
//! these sentences.

use crate::Rule;

/// Advice for a task that missed ticks.
#[must_use]
pub fn overruns(component: &str) -> String {
    format!(
        "`genomctl stats {component}`; a longer period, shorter codels, or a real-time priority"
    )
}

/// Advice for a codel that yields again and again without `pause::`.
#[must_use]
pub fn unpaused(codel: &str) -> String {
    format!("let {codel} yield `pause::` and the state, or end")
}

/// A rule of supervision that a component broke.
#[must_use]
pub fn broken_rule(component: &str, rule: &Rule) -> String {
    let Rule { rule, kind, violations, .. } = rule;
    let times = if *violations == 1 { "once".to_owned() } else { format!("{violations} times") };
    format!("{component} broke a rule of its {} supervision {times}: {rule}", kind.name())
}

/// Advice for one.
#[must_use]
pub fn after_broken_rule(component: &str) -> String {
    format!("`genomctl logs` tells when; mend the codel, or the rule of {component}")
}
