//! What the black box of a process hears: it is attached to a supervisor, and some changes make
//! it write a file, as often as they may.

use std::sync::Arc;
use std::time::Instant;

use genom_blackbox::Memory;
use genom_configuration::BlackBoxReason;
use genom_ports::dates::Dates;
use genom_supervisor::Supervisor;
use genom_supervisor::bus::{Bus, Heard};
use serde_json::Value;

use super::boxes::{Attached, BlackBoxes};
use super::lease::Lease;
use super::write::Why;

/// Changes that count as reports of supervision.
const SUPERVISION: [&str; 4] =
    ["codel_stuck", "codel_spins", "component_failed", "supervision_violated"];

impl BlackBoxes {
    /// Keeps what this process does from now on: of a daemon in a memory of its own, and it writes
    /// files; of a cell in the memory that came with its lease. To be called once, before anything
    /// is loaded.
    pub fn attach(self: &Arc<Self>, supervisor: &Arc<Supervisor>, lease: Option<&mut Lease>) {
        let dates = Dates::of(&supervisor.clock);
        let _ = self.daemon.set(Attached { supervisor: Arc::downgrade(supervisor), dates });
        if !self.section.enabled {
            return;
        }
        let (is_cell, lent) = (lease.is_some(), lease.and_then(|lease| lease.memory.take()));
        let memory = match (is_cell, lent) {
            (true, None) => return,
            (_, Some(lent)) => Ok(lent),
            (false, None) => Memory::new(self.section.bytes),
        };
        let kept = memory.and_then(|memory| {
            supervisor.keep_in(&memory, &self.section)?;
            Ok(memory)
        });
        match kept {
            Ok(memory) if !is_cell => {
                self.with(|all| all.insert(None, Arc::new(memory)));
                tokio::spawn(Arc::clone(self).watch(Arc::clone(&supervisor.bus)));
            }
            // Held open for a daemon that comes after this one.
            Ok(memory) => _ = self.lent.set(memory),
            Err(error) => tracing::error!("the black box keeps nothing of this process: {error}"),
        }
    }

    /// Writes a file for each change that is a reason to, but no second one within the time that a
    /// file reaches back: what happens in between is in the next.
    async fn watch(self: Arc<Self>, bus: Arc<Bus>) {
        let mut changes = bus.listen(None);
        while let Some(heard) = changes.next().await {
            let Heard::Told(change) = heard else { continue };
            let Some(why) = self.reason(&change.data) else { continue };
            if !self.is_due(Instant::now()) {
                tracing::info!(
                    "black box: no file for {}: {}; the last one is less than {} s old",
                    why.reason,
                    why.detail,
                    self.section.seconds
                );
                continue;
            }
            if let Err(error) = self.save_for(why).await {
                tracing::error!("black box: {error}");
            }
        }
    }

    fn is_due(&self, now: Instant) -> bool {
        let mut reasons = self.reasons();
        let soon = reasons.last.is_some_and(|last| now - last < self.section.time());
        match soon {
            true => reasons.skipped += 1,
            false => reasons.last = Some(now),
        }
        !soon
    }

    fn reason(&self, change: &Value) -> Option<Why> {
        let text = |key: &str| change.get(key).and_then(Value::as_str);
        let kind = text("event")?;
        let component = text("component").unwrap_or_default();
        let (reason, on, detail) = match kind {
            "service_exception" => {
                let (service, exception) = (text("service")?, text("exception")?);
                let detail = format!("{component}/{service}: {exception}");
                ("exception", BlackBoxReason::Exception, detail)
            }
            kind if SUPERVISION.contains(&kind) => {
                let what = text("what").or_else(|| text("codel")).or_else(|| text("why"));
                let what = what.map_or_else(String::new, |what| format!(": {what}"));
                ("supervision", BlackBoxReason::Supervision, format!("{kind} of {component}{what}"))
            }
            _ => return None,
        };
        self.section.is_on(on).then_some(Why { reason, detail, cell: None })
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use genom_configuration::BlackBoxSection;
    use serde_json::json;

    use super::*;

    #[test]
    fn what_comes_within_the_time_of_a_file_is_counted_and_not_written() {
        let section = BlackBoxSection {
            enabled: true,
            seconds: 5.0,
            on: vec![BlackBoxReason::Exception],
            ..BlackBoxSection::default()
        };
        let boxes = BlackBoxes::new(&section);
        let change = json!({
            "event": "service_exception", "component": "arm", "service": "go", "exception": "e",
        });
        assert_eq!(boxes.reason(&change).unwrap().detail, "arm/go: e");
        assert!(boxes.reason(&json!({"event": "codel_stuck", "component": "arm"})).is_none());
        let now = Instant::now();
        let due = [0, 1, 4, 5, 9, 11].map(|after| boxes.is_due(now + Duration::from_secs(after)));
        assert_eq!(due, [true, false, false, true, false, true]);
        assert_eq!(boxes.told(Vec::new()).skipped, 3);
    }
}
