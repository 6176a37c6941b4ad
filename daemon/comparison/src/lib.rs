//! One application on several middlewares, side by side: for `genomctl bench`, which asks the
//! daemons.
//!
//! A [`Way`] says which middleware each port is on, and makes the configuration of its daemon.
//! [`process`] weighs processes, [`pairing`] finds which sample that was read is which one that was
//! written, and [`report`] is what comes out: data, rows of tables, and a [`chart`].

#![forbid(unsafe_code)]

pub mod chart;
mod configuration;
mod figures;
pub mod floor;
pub mod pairing;
pub mod process;
pub mod report;
mod way;

pub use configuration::NoConfiguration;
pub use figures::Figures;
pub use way::{NoWay, Way};
