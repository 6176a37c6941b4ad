//! Execution tasks: the rules, the runner that applies them, and the thread that drives it.

pub(crate) mod call;
pub(crate) mod core;
#[cfg(test)]
mod core_tests;
pub(crate) mod driven;
pub(crate) mod gate;
pub(crate) mod hurry;
pub(crate) mod pace;
pub(crate) mod rhythm;
pub(crate) mod run;
pub(crate) mod runner;
pub(crate) mod scheduling;
pub(crate) mod thread;
pub(crate) mod timing;
