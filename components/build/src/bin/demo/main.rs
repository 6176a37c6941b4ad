//! `cargo demo`: builds everything, runs the demo component in genomd, moves it, and shows the
//! movement.
//!
//! It uses the daemon as a user does, through genomctl. The exit status is 0 only if the axis is at
//! the goal and the daemon stopped cleanly.

#![forbid(unsafe_code)]

mod axis;
mod daemon;
mod failure;

use std::io::Write as _;
use std::process::ExitCode;
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::Duration;

use clap::Parser;
use serde_json::{Value, json};

use axis::{Axis, State};
use daemon::Daemon;
use failure::Failure;
use genom_components::{Paths, Purpose, build_all, build_programs};

/// Speed of the axis, m/s.
const SPEED: f64 = 0.5;
/// Goal of the axis, m.
const GOAL: f64 = 1.0;
/// Limit of the movement, which takes 2.3 s, in case the daemon never ends it.
const PATIENCE: Duration = Duration::from_secs(60);

/// Builds genomd and the components, runs the demo, and shows it moving.
#[derive(Parser)]
#[command(name = "demo", bin_name = "cargo demo --")]
struct Arguments {
    /// Which demo: `demo`, with codels in C, or `demo-rs`, with codels in Rust.
    #[arg(default_value = "demo", value_parser = ["demo", "demo-rs"])]
    component: String,
    /// Middleware of its ports and services.
    #[arg(long, default_value = "local")]
    backend: String,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            let _ = writeln!(std::io::stderr(), "cargo demo: {failure}");
            ExitCode::FAILURE
        }
    }
}

/// An event during the movement.
enum Event {
    /// A sample on port `position`.
    Sample(String),
    /// The activity ended: output of genomctl, or the error.
    Ended(Result<String, Failure>),
}

fn run(arguments: &Arguments) -> Result<(), Failure> {
    say("Building genomd, genomctl and the components of this repository");
    let paths = Paths::of_workspace()?;
    let [genomd, genomctl] = build_programs(&paths, ["genomd", "genomctl"], Purpose::Use)?;
    let components = build_all(&paths, Purpose::Use)?;
    let library = components
        .into_iter()
        .find(|artifact| artifact.name == arguments.component)
        .map(|artifact| artifact.library)
        .ok_or(Failure::Unexpected { what: "the list of components", found: String::new() })?;

    say(&format!("$ genomd --backend {} {}", arguments.backend, library.display()));
    let daemon = Daemon::start(&genomd, &genomctl, &arguments.backend, &library)?;

    say(&format!("$ genomctl call demo set_speed '{{\"velocity\": {SPEED}}}'"));
    daemon.ask(&["call", "demo", "set_speed", &json!({ "velocity": SPEED }).to_string()])?;

    say(&format!("$ genomctl start demo goto '{{\"goal\": {GOAL}}}'"));
    let position = go(&daemon)?.position;

    daemon.stop()?;
    if position != GOAL {
        return Err(Failure::Elsewhere { position, goal: GOAL });
    }
    say(&format!("The axis is at {position} m, and genomd has stopped."));
    Ok(())
}

/// Starts `goto`, shows the axis until the activity ends, and returns the final position.
fn go(daemon: &Daemon) -> Result<State, Failure> {
    let axis = Axis::new(GOAL);
    let (events, happened) = mpsc::channel();
    let mut echo = daemon.echo("demo/position", 30)?;
    let samples = echo.lines();
    thread::scope(|scope| {
        let sample = events.clone();
        scope.spawn(move || {
            for line in samples.map_while(Result::ok) {
                let _ = sample.send(Event::Sample(line));
            }
        });
        scope.spawn(move || {
            let goal = json!({ "goal": GOAL }).to_string();
            let end = daemon.ask(&["start", "demo", "goto", &goal, "--wait"]);
            let _ = events.send(Event::Ended(end));
        });
        let end = watch(&axis, &happened, daemon).and_then(|()| rest(daemon));
        // The stream does not end by itself.
        echo.end();
        if let Ok(state) = &end {
            axis.show(state);
        }
        axis.finish();
        end
    })
}

/// The final position. It is read separately, because the stream limits its rate and may skip the
/// last sample.
fn rest(daemon: &Daemon) -> Result<State, Failure> {
    let reply = daemon.ask(&["call", "demo", "get_position"])?;
    let outcome: Value = serde_json::from_str(&reply).unwrap_or_default();
    outcome["result"].to_string().parse()
}

/// Shows samples until the activity ends.
fn watch(axis: &Axis, happened: &Receiver<Event>, daemon: &Daemon) -> Result<(), Failure> {
    loop {
        match happened.recv_timeout(PATIENCE) {
            Ok(Event::Sample(line)) => axis.show(&line.parse()?),
            Ok(Event::Ended(end)) => return end.map(drop),
            Err(_) => {
                // Whoever waits for the daemon's answer gets an error instead.
                daemon.abandon();
                return Err(Failure::Never { seconds: PATIENCE.as_secs() });
            }
        }
    }
}

/// Prints a line on standard output; a closed pipe is not an error.
fn say(line: &str) {
    let _ = writeln!(std::io::stdout(), "{line}");
}
