//! Tells middlewares what components of this process log (ROS 2: `/rosout`).

use std::sync::Arc;

use genom_middleware::{LogEntry, LogLevel, Middleware};
use genom_protocol::{Level, LogEntry as Kept};
use genom_supervisor::Supervisor;
use genom_supervisor::bus::{Heard, Listener};
use serde::Deserialize as _;
use tokio::runtime::Handle;

use crate::logs;

/// Longest message that is told, in bytes; the rest is left out.
const LONGEST: usize = 8 << 10;

/// From now on, each middleware that takes the log gets it while it is open.
pub fn tell_middlewares(supervisor: &Arc<Supervisor>) {
    let (weak, runtime) = (Arc::downgrade(supervisor), Handle::current());
    supervisor.backends.on_open(move |on: &Arc<dyn Middleware>| {
        if !on.takes_log() {
            return;
        }
        let (on, weak) = (Arc::downgrade(on), weak.clone());
        // Those of cells arrive here, too, but each process tells its own.
        let tell = move |kept: &Kept| {
            let (Some(on), Some(supervisor)) = (on.upgrade(), weak.upgrade()) else { return false };
            if let Some(name) = kept.component.as_deref()
                && supervisor.components.get(name).is_some()
            {
                on.log(&entry(kept, name));
            }
            true
        };
        runtime.spawn(follow(logs::past().listen(None), tell));
    });
}

/// Entries that this comes too late for are left out.
async fn follow(mut listener: Listener, tell: impl Fn(&Kept) -> bool) {
    while let Some(heard) = listener.next().await {
        let Heard::Told(told) = heard else { continue };
        if Kept::deserialize(&*told.data).is_ok_and(|kept| !tell(&kept)) {
            return;
        }
    }
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
        message,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_message_is_cut_between_two_characters() {
        let kept = Kept {
            time: 1.5,
            level: Level::Trace,
            origin: "genomd".to_owned(),
            component: Some("demo".to_owned()),
            message: "é".repeat(LONGEST),
        };
        let told = entry(&kept, "demo");
        assert_eq!((told.time, told.level), (1_500_000_000, LogLevel::Debug));
        assert_eq!(told.message.len(), LONGEST);
    }
}
