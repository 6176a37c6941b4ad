//! Periods, delays and the clock that serves them all (genom3.md 3.5 P9 to P12, 4.7).

use std::time::Duration;

use super::Checker;
use super::state::BodyId;
use crate::diagnostic::Diagnostic;

/// Greatest difference between a period and a whole number of clock ticks, in ticks.
const TOLERANCE: f64 = 1e-6;

impl Checker {
    pub(super) fn check_tasks_timing(&mut self, id: BodyId) {
        let mut errors = Vec::new();
        for task in self.bodies[id].tasks.values() {
            match (task.period, task.delay) {
                (None, Some((_, span))) => {
                    let message = format!("task `{}` has a delay and no period", task.name);
                    errors.push(Diagnostic::error("E0509", span, message));
                }
                (Some((period, other)), Some((delay, span))) if delay >= period => {
                    let message = "the delay must be less than the period";
                    errors
                        .push(Diagnostic::error("E0510", span, message).note(other, "the period"));
                }
                _ => {}
            }
        }
        self.diagnostics.extend(errors);
    }

    /// The clock of a component, given or computed.
    pub(super) fn clock_rate(&mut self, id: BodyId) -> Option<Duration> {
        let body = &self.bodies[id];
        let timed = body.tasks.values().filter_map(|task| Some((task, task.period?)));
        let times: Vec<_> = timed
            .flat_map(|(task, period)| {
                let delay = task.delay.filter(|(delay, _)| *delay > 0.0);
                let delay = delay.map(|(delay, span)| (task, "delay", delay, span));
                std::iter::once((task, "period", period.0, period.1)).chain(delay)
            })
            .collect();
        if let Some((rate, span)) = body.clock_rate {
            let mut errors = Vec::new();
            for (task, what, seconds, place) in &times {
                let ticks = seconds / rate;
                if rate > 0.0 && (ticks - ticks.round()).abs() <= TOLERANCE && ticks >= 0.5 {
                    continue;
                }
                let message =
                    format!("the {what} of task `{}` is no multiple of clock-rate", task.name);
                errors.push(
                    Diagnostic::error("E0511", *place, message).note(span, "clock-rate is here"),
                );
            }
            if rate <= 0.0 && times.is_empty() {
                errors.push(Diagnostic::error("E0508", span, "clock-rate must be positive"));
            }
            self.diagnostics.extend(errors);
            return Duration::try_from_secs_f64(rate).ok().filter(|rate| !rate.is_zero());
        }
        let mut rate = 1_000_000u64;
        for (task, what, seconds, place) in &times {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let micros = (seconds * 1e6).round() as u64;
            if micros == 0 {
                let message = format!(
                    "the {what} of task `{}` is below a microsecond: no clock can serve it",
                    task.name
                );
                let error = Diagnostic::error("E0512", *place, message);
                self.push(error);
                return None;
            }
            rate = gcd(rate, micros);
        }
        (!times.is_empty()).then(|| Duration::from_micros(rate))
    }
}

fn gcd(mut a: u64, mut b: u64) -> u64 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// Converts seconds to a duration; 0 when they are out of range.
pub(super) fn duration(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).unwrap_or_default()
}
