//! What to do about a finding, in the words of the daemon (`genomctl why`) and of
//! `genomctl doctor` alike.

/// A task that missed ticks.
#[must_use]
pub fn overruns(component: &str) -> String {
    format!(
        "`genomctl stats {component}`; a longer period, shorter codels, or a real-time priority"
    )
}

/// A codel that yields again and again without `pause::`.
#[must_use]
pub fn unpaused(codel: &str) -> String {
    format!("let {codel} yield `pause::` and the state, or end")
}
