//! What a component can do, whatever its codels yield and its clients ask: a transition system with
//! the same rules as the runtime, made from the same [`Plan`](genom_runtime::Plan).
//!
//! `docs/verify.md` lists the rules with the numbers that comments here cite (`R4`), and says what
//! they leave out. A [`System`] is a component in arrays; a [`State`] is where it is between two
//! steps; an [`Action`] is a step. Tests hold the rules against the runtime, step by step.

#![forbid(unsafe_code)]

mod action;
mod apart;
mod bounds;
mod codels;
mod enabled;
mod explore;
mod flat;
mod hints;
mod large;
mod ltl;
mod machines;
mod monitor;
mod pack;
mod played;
mod property;
mod rules;
mod schedule;
mod searches;
mod services;
mod state;
mod system;
mod timed;
mod variant;
mod words;

pub use action::{Action, Answer, End, Target, Told};
pub use bounds::Bounds;
pub use explore::{Explored, Looked};
pub use flat::{Flat, FlatState, FlatStep, FlatTo};
pub use genom_timing::{Conflicts, Limit, Limits, Lock, Period, duration};
pub use hints::{Hint, hints};
pub use ltl::{Atom, Formula, FormulaError, Join, Term};
pub use machines::Machine as StateMachine;
pub use monitor::{Fires, Trace};
pub use played::{Call, Course, Event, Happening};
pub use property::{Finding, Property, Report, Verdict};
pub use schedule::{
    Called, Cause, Change, Machine, Meanwhile, OnMachine, Placed, Processors, Schedule, Scheduled,
    Threads, Waits,
};
pub use services::{Service, Work};
pub use state::{At, Life, Mode, Pc, Pending, Phase, Place, Run, State, Step, Task, Worker};
pub use system::System;
pub use timed::{
    Dated, Duration, Longest, Overrun, Response, Seen, Spent, TaskReport, Timed, TimedReport, Times,
};
pub use variant::{Variant, conflicts};
pub use words::Line;
