//! Components: what they can be, and what they may do to a daemon.

mod bounds;
mod crashes;
mod cxx;
mod demo;
mod faults;
mod hangs;
mod others;
mod overruns;
mod papers;
mod spins;
mod table;
mod trials;
mod vision;
