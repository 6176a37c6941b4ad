//! Tells middlewares what components of this process log, and how their tasks fare (ROS 2: `/rosout`,
//! `/diagnostics`).

use std::collections::HashMap;
use std::sync::{Arc, Weak};
use std::time::Duration;

use genom_middleware::{Diagnosis, Health, LogEntry, LogLevel, Middleware, Part};
use genom_protocol::{Level, LogEntry as Kept};
use genom_runtime::TaskStatistics;
use genom_supervisor::Supervisor;
use genom_supervisor::bus::{Heard, Listener};
use genom_supervisor::components::Hosted;
use serde::Deserialize as _;
use tokio::runtime::Handle;
use tokio::time::{MissedTickBehavior, interval};

use crate::logs;

/// Longest message that is told, in bytes; the rest is left out.
const LONGEST: usize = 8 << 10;

/// Whom to tell of what.
#[derive(Clone)]
struct Telling {
    on: Weak<dyn Middleware>,
    of: Weak<Supervisor>,
}

/// From now on, each middleware whose tools show it is told while it is open.
pub fn tell_middlewares(supervisor: &Arc<Supervisor>) {
    let (of, runtime) = (Arc::downgrade(supervisor), Handle::current());
    supervisor.backends.on_open(move |on: &Arc<dyn Middleware>| {
        if !on.takes_reports() {
            return;
        }
        let telling = Telling { on: Arc::downgrade(on), of: of.clone() };
        runtime.spawn(telling.clone().log(logs::past().listen(None)));
        runtime.spawn(telling.diagnose());
    });
}

impl Telling {
    fn ends(&self) -> Option<(Arc<dyn Middleware>, Arc<Supervisor>)> {
        self.on.upgrade().zip(self.of.upgrade())
    }

    /// Tells entries of the log. Those that this comes too late for are left out.
    async fn log(self, mut listener: Listener) {
        while let Some(heard) = listener.next().await {
            let Some((on, supervisor)) = self.ends() else { return };
            let Heard::Told(told) = heard else { continue };
            let Ok(kept) = Kept::deserialize(&*told.data) else { continue };
            // Those of cells arrive here, too, but each process tells its own.
            if let Some(name) = kept.component.as_deref()
                && supervisor.components.get(name).is_some()
            {
                on.log(&entry(&kept, name));
            }
        }
    }

    async fn diagnose(self) {
        let mut rounds = interval(Diagnosis::ROUND);
        rounds.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut missed = HashMap::new();
        loop {
            rounds.tick().await;
            let Some((on, supervisor)) = self.ends() else { return };
            let before = std::mem::take(&mut missed);
            let mut told = Vec::new();
            let all = supervisor.components.all();
            for hosted in all.iter().filter(|hosted| is_on(hosted, on.name())) {
                for task in hosted.figures().tasks {
                    let key = (hosted.name.clone(), task.name.clone());
                    let known = before.get(&key).copied().unwrap_or(task.overruns);
                    told.push(diagnosis(&hosted.name, &task, task.overruns.saturating_sub(known)));
                    missed.insert(key, task.overruns);
                }
            }
            if !told.is_empty() {
                on.diagnose(&told);
            }
        }
    }
}

/// Whether a component is on a middleware, with its services or a port.
fn is_on(hosted: &Hosted, name: &str) -> bool {
    let bindings = &hosted.ties.bindings;
    bindings.component().has(name) || bindings.ports().values().any(|names| names.has(name))
}

fn entry(kept: &Kept, instance: &str) -> LogEntry {
    let mut message = kept.message.clone();
    if message.len() > LONGEST {
        let end = (0..=LONGEST).rev().find(|&end| message.is_char_boundary(end));
        message.truncate(end.unwrap_or_default());
    }
    #[allow(clippy::cast_possible_truncation, reason = "a date: to the microsecond, until 2262")]
    let time = (kept.time * 1e9) as i64;
    LogEntry {
        instance: instance.to_owned(),
        time,
        level: match kept.level {
            Level::Error => LogLevel::Error,
            Level::Warn => LogLevel::Warn,
            Level::Info => LogLevel::Info,
            Level::Debug | Level::Trace => LogLevel::Debug,
        },
        place: kept.origin.clone(),
        file: kept.file.clone().unwrap_or_default(),
        line: kept.line.unwrap_or_default(),
        message,
    }
}

/// How a task fares that missed so many periods since it was told last.
fn diagnosis(instance: &str, task: &TaskStatistics, missed: u64) -> Diagnosis {
    let (health, message) = match (&task.stuck, missed) {
        (Some(codel), _) => {
            let seconds = Duration::from_nanos(codel.for_ns).as_secs_f64();
            let told = format!("codel {} has not returned for {seconds:.1} s", codel.codel);
            (Health::Stuck, told)
        }
        (None, 0) => (Health::Good, "in time".to_owned()),
        (None, 1) => (Health::Late, "missed a period".to_owned()),
        (None, missed) => (Health::Late, format!("missed {missed} periods")),
    };
    let microseconds = |ns: u64| (ns / 1000).to_string();
    let values = [
        ("missed periods", task.overruns.to_string()),
        ("cycles", task.cycles.count.to_string()),
        ("work, 99 %, us", microseconds(task.cycles.p99_ns)),
        ("work, longest, us", microseconds(task.cycles.max_ns)),
        ("lateness, 99 %, us", microseconds(task.lateness.p99_ns)),
        ("lateness, longest, us", microseconds(task.lateness.max_ns)),
        ("real-time priority", task.real_time.to_string()),
    ];
    let values = values.map(|(name, value)| (name.to_owned(), value)).to_vec();
    let (instance, of) = (instance.to_owned(), Part::Task(task.name.clone()));
    Diagnosis { instance, of, health, message, values }
}

#[cfg(test)]
mod tests {
    use genom_runtime::Durations;

    use super::*;

    #[test]
    fn a_long_message_is_cut_between_two_characters() {
        let kept = Kept {
            time: 1.5,
            level: Level::Trace,
            origin: "genomd".to_owned(),
            file: Some("src/main.rs".to_owned()),
            line: Some(7),
            component: Some("demo".to_owned()),
            message: "é".repeat(LONGEST),
        };
        let told = entry(&kept, "demo");
        assert_eq!((told.time, told.level), (1_500_000_000, LogLevel::Debug));
        assert_eq!((told.file.as_str(), told.line), ("src/main.rs", 7));
        assert_eq!(told.message.len(), LONGEST);
    }

    #[test]
    fn periods_missed_since_the_last_time_are_a_warning() {
        let task = TaskStatistics {
            name: "main".to_owned(),
            period_ns: Some(1_000_000),
            real_time: true,
            cycles: Durations::default(),
            lateness: Durations::default(),
            overruns: 7,
            stuck: None,
            unpaused: None,
        };
        let told = |missed| diagnosis("demo", &task, missed);
        assert_eq!((told(0).health, told(0).message.as_str()), (Health::Good, "in time"));
        assert_eq!((told(2).health, told(2).message.as_str()), (Health::Late, "missed 2 periods"));
        assert_eq!(told(0).values[0], ("missed periods".to_owned(), "7".to_owned()));
    }
}
