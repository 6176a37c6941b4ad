//! A daemon that is part of a program: a simulator, a notebook, a test. The program starts it with a
//! socket as its standard input, and holds the other end. Over that it steps the clock, and opens
//! ports, each as memory that both have; one step takes in all that the program wrote, and shows all
//! that codels wrote (`wire` documents the messages, `memory` the memory).
//!
//! Nobody else has that end, so that no name, token or right is needed. All else that can be asked of
//! a daemon goes over its control plane.
//!
//! Its cells are stepped in the same way: each has an end of a socket from its daemon, answers as a
//! daemon does, and its ports have their memory from it, which goes to the program as it is. A step
//! asks each cell once, however many ports it has.

#![forbid(unsafe_code)]

mod far;
mod memory;
mod open;
mod places;
mod port;
mod program;
mod session;
mod short;
mod who;
mod wire;

pub use program::{NoProgram, Program};
