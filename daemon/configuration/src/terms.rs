//! Converts options of tasks, ports and connections to the types of the runtime and the
//! middlewares.

use std::time::Duration;

use genom_middleware as middleware;
use genom_protocol::{Policy, PortQos, TaskEntry};
use genom_runtime::TaskOptions;

use crate::error::NoPeriod;

/// Options of a task, for the runtime.
///
/// # Errors
/// The period is not positive and finite.
pub fn task_options(entry: &TaskEntry) -> Result<TaskOptions, NoPeriod> {
    let period = match entry.period_ms {
        None => None,
        Some(ms) => {
            let period = Duration::try_from_secs_f64(ms / 1e3).ok();
            let period = period.filter(|period| !period.is_zero());
            Some(period.ok_or(NoPeriod(ms))?)
        }
    };
    Ok(TaskOptions {
        period,
        priority: entry.priority.map(u32::from),
        real_time: entry.real_time,
        cpus: entry.cpus.clone(),
    })
}

/// Quality of service of a port, for the middleware.
#[must_use]
pub fn quality(of: &PortQos) -> middleware::Quality {
    let PortQos { reliable, depth, transient_local } = *of;
    middleware::Quality { reliable, depth, transient_local }
}

/// Policy of a connection, for the middleware.
#[must_use]
pub fn policy(of: Policy) -> middleware::Policy {
    match of {
        Policy::Latest => middleware::Policy::Latest,
        Policy::Queue(most) => middleware::Policy::Queue(most),
        Policy::Ring(most) => middleware::Policy::Ring(most),
    }
}

/// Policy of a connection, for the control plane.
#[must_use]
pub fn told_policy(of: middleware::Policy) -> Policy {
    match of {
        middleware::Policy::Latest => Policy::Latest,
        middleware::Policy::Queue(most) => Policy::Queue(most),
        middleware::Policy::Ring(most) => Policy::Ring(most),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_period_must_be_one() {
        let entry = |ms| TaskEntry { period_ms: Some(ms), ..TaskEntry::default() };
        let period = task_options(&entry(2.5)).unwrap().period;
        assert_eq!(period, Some(Duration::from_micros(2500)));
        for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(task_options(&entry(wrong)).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_policy_is_told_as_it_was_asked_for() {
        for asked in [Policy::Latest, Policy::Queue(3), Policy::Ring(9)] {
            assert_eq!(told_policy(policy(asked)), asked);
        }
    }
}
