//! Shows the axis on the terminal: a bar from 0 to the goal.

use std::io::{IsTerminal as _, Write as _, stdout};
use std::str::FromStr;

use serde_json::Value;

use crate::failure::Failure;

/// Width of the bar, in characters.
const WIDTH: usize = 50;

/// A sample of port `position`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State {
    pub(crate) position: f64,
    velocity: f64,
}

impl FromStr for State {
    type Err = Failure;

    fn from_str(line: &str) -> Result<Self, Failure> {
        let value: Value = serde_json::from_str(line).unwrap_or_default();
        match (value["position"].as_f64(), value["velocity"].as_f64()) {
            (Some(position), Some(velocity)) => Ok(Self { position, velocity }),
            _ => Err(Failure::Unexpected { what: "a sample", found: line.to_owned() }),
        }
    }
}

/// Draws samples: on a terminal over one another, otherwise one per line.
pub(crate) struct Axis {
    goal: f64,
    terminal: bool,
}

impl Axis {
    pub(crate) fn new(goal: f64) -> Self {
        Self { goal, terminal: stdout().is_terminal() }
    }

    pub(crate) fn show(&self, state: &State) {
        let (start, end) = if self.terminal { ("\r", "") } else { ("", "\n") };
        let mut out = stdout().lock();
        let _ = write!(out, "{start}{}{end}", draw(state, self.goal));
        let _ = out.flush();
    }

    /// Moves to the line after the bar.
    pub(crate) fn finish(&self) {
        if self.terminal {
            let _ = writeln!(stdout());
        }
    }
}

fn draw(state: &State, goal: f64) -> String {
    let done = (state.position / goal).clamp(0.0, 1.0) * WIDTH as f64;
    let done = "=".repeat(done.round() as usize);
    format!("  [{done:<WIDTH$}] {:7.3} m {:6.3} m/s", state.position, state.velocity)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_is_drawn_between_the_origin_and_the_goal() {
        let half: State = r#"{"position":0.5,"velocity":0.25}"#.parse().unwrap();
        let bar = format!("[{}{}]", "=".repeat(25), " ".repeat(25));
        assert_eq!(draw(&half, 1.0), format!("  {bar}   0.500 m  0.250 m/s"));
        assert!("null".parse::<State>().is_err());
    }
}
