//! A daemon that is part of a program: a simulator, a notebook, a test. The program starts it with a
//! socket as its standard input, and holds the other end. Over that it steps the clock, and opens
//! ports, each as memory that both have; one step takes in all that the program wrote, and shows all
//! that codels wrote (`wire` documents the messages, `memory` the memory).
//!
//! Nobody else has that end, so that no name, token or right is needed. All else that can be asked of
//! a daemon goes over its control plane.

#![forbid(unsafe_code)]

mod memory;
mod port;
mod program;
mod session;
mod wire;

pub use program::{NoProgram, Program};
