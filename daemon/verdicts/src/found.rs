//! What was found of one component.

use genom_formal::{Report, System, TimedReport};

/// What was found of one component.
#[derive(Debug)]
pub struct Found {
    /// The component.
    pub system: System,
    /// What holds whatever time codels take.
    pub report: Report,
    /// What was found about ticks.
    pub ticks: Ticks,
}

/// What was found about ticks.
#[derive(Debug)]
pub enum Ticks {
    /// Nobody asked.
    Unasked,
    /// They were not looked at: the property that was asked for, and the reason.
    Unknown(&'static str, String),
    /// They were looked at.
    Seen(Box<TimedReport>),
}
