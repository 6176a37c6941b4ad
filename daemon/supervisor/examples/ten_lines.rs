//! A robot without the daemon: starts the demo and calls services of it.
//!
//! ```sh
//! cargo demo
//! cargo run -p genom-supervisor --example ten_lines target/components/demo/demo.so
//! ```

#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, reason = "it is a program")]

use std::error::Error;
use std::path::PathBuf;

use genom_supervisor::{LoadRequest, Settings, Supervisor};
use serde_json::json;

fn main() -> Result<(), Box<dyn Error>> {
    let library = std::env::args().nth(1).ok_or("usage: ten_lines LIBRARY")?;
    println!("{}", run(library.into())?);
    Ok(())
}

/// Moves the axis of the demo, and returns a sentence with the position reached.
pub(crate) fn run(library: PathBuf) -> Result<String, Box<dyn Error>> {
    let supervisor = Supervisor::new(Settings::default());
    let demo = supervisor.load(&LoadRequest { library, ..LoadRequest::default() })?;
    demo.call("set_speed", &json!({ "velocity": 2.0 }))?;
    demo.call("goto", &json!({ "goal": 0.1 }))?;
    let position = demo.call("get_position", &json!({}))?;
    drop(demo);
    supervisor.unload("demo")?;
    Ok(format!("{position:?}"))
}
