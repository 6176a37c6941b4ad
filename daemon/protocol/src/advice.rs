//! What users can do about a problem; both the daemon (`genomctl why`) and `genomctl doctor` print
//! these sentences.

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
