//! genomctl as a program: what it prints, asks and refuses.

mod check_library;
mod descriptions;
mod hostile_daemon;
mod pictures;
mod refusals;
mod terminal;
mod transcripts;
