//! Execution tasks.

use super::Checker;
use super::room;
use super::state::{BodyId, Role, Task, add_throws};
use crate::diagnostic::Diagnostic;
use crate::syntax::{self, PropertyKind};

impl Checker {
    pub(super) fn task(&mut self, id: BodyId, dcl: &syntax::Task) {
        let new = || Task::new(dcl.name.text.clone(), dcl.name.span);
        let known = self.bodies[id].tasks.get_mut(&dcl.name.text);
        let mut task = known.map_or_else(new, |known| std::mem::replace(known, new()));
        for property in &dcl.properties {
            self.task_property(id, &mut task, property);
        }
        self.reserve(room::task(&task), dcl.name.span);
        let (rank, _) = self.bodies[id].tasks.insert_full(dcl.name.text.clone(), task);
        self.bodies[id].touched_tasks.insert(rank);
    }

    // genom3.md 3.5 P2, P3.
    fn task_property(&mut self, id: BodyId, task: &mut Task, property: &syntax::Property) {
        use PropertyKind as K;
        let keyword = &property.keyword;
        self.check_colon(id, property);
        match &property.kind {
            K::Doc(text) => task.docs.push(text.text.clone()),
            K::Period(quantity) => {
                if let Some(seconds) = self.seconds(quantity, "period") {
                    self.give(&mut task.period, seconds, keyword);
                }
            }
            K::Delay(quantity) => {
                if let Some(seconds) = self.seconds(quantity, "delay") {
                    self.give(&mut task.delay, seconds, keyword);
                }
            }
            K::Priority(value) => {
                if let Some(priority) = self.positive_u32(value) {
                    self.give(&mut task.priority, priority, keyword);
                }
            }
            K::RealTime => self.give(&mut task.real_time, (), keyword),
            K::Stack(value, unit) => {
                if let Some(bytes) = self.positive(value) {
                    self.give(&mut task.stack, bytes.saturating_mul(*unit), keyword);
                }
            }
            K::Throws(list) => {
                let fresh = self.throws(id, list);
                add_throws(&mut task.throws, &fresh);
            }
            K::Codel(codel) if codel.machine.is_none() => {
                let message = format!(
                    "task `{}` runs a state machine: `{}` has no state",
                    task.name, codel.name.text
                );
                self.push(
                    Diagnostic::error("E0503", codel.name.span, message)
                        .help(format!("write `codel<STATE> {}(...) yield ...`", codel.name.text)),
                );
            }
            K::Codel(codel) => {
                if self.is_new_codel(codel, task.codels.iter())
                    && let Some(state) = self.codel(id, None, codel, Role::Machine, None)
                {
                    task.codels.push(state);
                }
            }
            K::Local(..) => {
                let message = "local variables belong to functions and activities";
                self.push(Diagnostic::error("E0616", keyword.span, message));
            }
            _ => {
                let message = format!("`{}` is no property of tasks", keyword.text);
                self.push(Diagnostic::error("E0502", keyword.span, message));
            }
        }
    }
}
