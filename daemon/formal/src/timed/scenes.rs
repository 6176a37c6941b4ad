//! Ticks of the task at which walks begin: with activities that were requested in an order in which hardly
//! any asks another one to stop.

use super::explore::Timed;
use super::seek::is_first;
use super::walks::{Now, Walks};
use crate::action::{Action, Answer};
use crate::codels::small;

/// Steps before the first request, at most; or before each one.
const BEFORE: (usize, usize) = (60, 12);
/// Steps of a request, and steps until the tick.
const STEPS: (usize, usize) = (30, 100);
/// How often, out of eight times, an activity of the task itself is requested, and one of another task.
const OFTEN: (usize, usize) = (7, 4);
/// The same where the task has what it needs to be late.
const SELDOM: (usize, usize) = (0, 1);

impl Walks<'_> {
    /// Some requests, and what happens until the tick; walks may begin there if the cycle may be late.
    pub(super) fn scene(&mut self) -> Option<()> {
        let task = self.potential.task;
        let mut from = self.pick(2)?;
        let (mut now, mut steps) = (self.places[from].now.clone(), Vec::new());
        let once = self.random.below(2) == 0;
        let requests = self.requested(if self.places[from].level == 0 { OFTEN } else { SELDOM });
        for (service, number) in requests.into_iter().zip(0..) {
            let most = if once { BEFORE.0 } else { BEFORE.1 };
            let before = if once && number > 0 { 0 } else { self.random.below(most) };
            for _ in 0..before {
                self.pass(&mut now, &mut steps)?;
            }
            self.ask(&mut now, &mut steps, service);
            if now.most >= self.potential.period && self.random.below(3) == 0 {
                from = self.keep(now.clone(), 1, (from, std::mem::take(&mut steps)));
            }
        }
        let tick = Action::Tick(task);
        for _ in 0..STEPS.1 {
            if now.most < self.potential.period {
                break;
            }
            if self.random.below(2) == 0
                && Timed::is_late(&now.state, tick).is_none()
                && self.possible(&now.state).contains(&tick)
                && let Some((next, taken)) = self.own(&now, tick)
            {
                if self.may_be_late(&next, from) {
                    steps.extend(taken);
                    self.keep(next, 2, (from, steps));
                    return Some(());
                }
                break;
            }
            self.pass(&mut now, &mut steps)?;
        }
        // What happened may be of use before other requests.
        if self.random.below(4) == 0 {
            let level = usize::from(now.most >= self.potential.period);
            self.keep(now, level, (from, steps));
        }
        Some(())
    }

    /// Services of activities, at random; who interrupts another one comes before it, if there is such an
    /// order.
    fn requested(&mut self, (own, other): (usize, usize)) -> Vec<u16> {
        let (system, task) = (self.potential.system, self.potential.task);
        let mut left = Vec::new();
        for (service, facts) in (0..small(system.services.len())).zip(&system.services) {
            let of = facts.machine.map(|machine| system.machines[usize::from(machine)].task);
            let often = of.map_or(0, |of| if of == task { own } else { other });
            if system.clients[usize::from(service)] && self.random.below(8) < often {
                left.push(service);
            }
        }
        let mut all = Vec::new();
        while !left.is_empty() {
            let before = |own: u16, other: u16| own != other && system.interrupts(own, other);
            let is_first = |at: &usize| !left.iter().any(|one| before(*one, left[*at]));
            let first: Vec<usize> = (0..left.len()).filter(is_first).collect();
            let at = if first.is_empty() {
                self.random.below(left.len())
            } else {
                *self.random.one(&first)
            };
            all.push(left.remove(at));
        }
        all
    }

    /// A step that nobody asks for.
    fn pass(&mut self, now: &mut Now, steps: &mut Vec<Action>) -> Option<()> {
        let mut actions = self.possible(&now.state);
        actions.retain(|action| match action {
            Action::Request(_) | Action::Abort(..) | Action::Return(_, Answer::Fail) => false,
            _ => Timed::is_late(&now.state, *action) != Some(self.potential.task),
        });
        while !actions.is_empty() {
            let action = actions.swap_remove(self.random.below(actions.len()));
            if let Some(next) = self.step(now, action) {
                *now = next;
                steps.push(action);
                return Some(());
            }
        }
        None
    }

    /// A request, if it is possible, until it is answered.
    fn ask(&mut self, now: &mut Now, steps: &mut Vec<Action>, service: u16) {
        let mut action = Action::Request(service);
        if !self.possible(&now.state).contains(&action) {
            return;
        }
        for _ in 0..STEPS.0 {
            let Some(next) = self.step(now, action) else { return };
            *now = next;
            steps.push(action);
            let mut actions = self.possible(&now.state);
            actions.retain(|action| match action {
                Action::Return(context, Answer::Ok) => !self.potential.system.is_task(*context),
                _ => is_first(action),
            });
            if actions.is_empty() {
                return;
            }
            action = *self.random.one(&actions);
        }
    }
}
