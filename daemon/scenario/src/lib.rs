//! Scenario tests of components on the stepped clock: for `genomctl test`, which starts the daemons.
//!
//! A file ([`Suite`]) has scenarios, each with what it runs ([`Setup`]) and steps ([`Step`]).
//! [`play`] does the steps of one on a [`Daemon`] and says how it went; [`Report`] collects that, and
//! is written as text, JSON or JUnit XML. Nothing in a report depends on the machine's clock, so two
//! runs give the same bytes.

#![forbid(unsafe_code)]

mod compare;
pub mod duration;
mod find;
mod model;
mod play;
mod read;
pub mod report;
mod setup;
mod source;

pub use find::{NoSuite, find};
pub use model::{
    Action, Codels, Ended, Expected, Fault, Harm, Run, Scenario, Setup, Step, Suite, Takes,
};
pub use play::{Daemon, Progress, Trouble, play};
pub use report::{Outcome, Played, Report, ScenarioReport, Unmet};
pub use setup::{NoSetup, Overrides};
pub use source::{Mistakes, Place};
