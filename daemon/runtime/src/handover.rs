//! Hands what an instance is over to another one, which goes on with it between two ticks.
//!
//! The heir has run its start codels and is held. At a moment at which the instance rests and has
//! served every tick that was due, its state goes to the heir, and the heir goes on. A tick that is due
//! meanwhile waits, in the heir, until that is done: none is lost, and none is served twice.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use genom_description::model::{Ix as _, Owner};
use genom_types::Record;

use crate::body::Body;
use crate::control::{Afterwards, interrupted};
use crate::engine::Engine;
use crate::exclusion::PiLock;
use crate::freeze::FreezeError;
use crate::frozen::{Frozen, Resume, Resumed};
use crate::rest::NoRest;
use crate::still::Still;

/// Calls a function with the IDS of the heir, while no codel of it runs.
pub type HeirIds<'a> = dyn Fn(&mut dyn FnMut(&mut Record)) + 'a;

/// Ticks of the heir wait while this lives.
struct Window<'a>(&'a Engine);

impl<'a> Window<'a> {
    fn open(heir: &'a Engine) -> Self {
        let turnstile: &PiLock = &heir.shared.turnstile;
        turnstile.lock();
        heir.shared.takes_over.store(true, Ordering::Release);
        Self(heir)
    }
}

impl Drop for Window<'_> {
    fn drop(&mut self) {
        self.0.shared.takes_over.store(false, Ordering::Release);
        self.0.shared.turnstile.unlock();
    }
}

impl Engine {
    /// Waits for the moment, at most for `limit`, and hands over; from then on this instance shuts
    /// down, until `deadline`. `convert` makes what the heir takes, and may change the IDS of that before;
    /// `exchange` gives the ports to it. Nothing is done if there is no such moment, or `convert`
    /// fails.
    pub(crate) fn hand_over<E>(
        self: &Arc<Self>,
        heir: &Self,
        (limit, deadline): (Duration, Instant),
        convert: impl FnOnce(Frozen, &HeirIds<'_>) -> Result<Resume, E>,
        exchange: impl FnOnce(&dyn Body, &dyn Body),
    ) -> Result<Result<(), E>, NoRest> {
        let mut steps = Some((convert, exchange));
        let work = |still: &mut Still<'_>, early| {
            // Ticks of the heir wait before the date is read: those that did not wait are earlier.
            let window = Window::open(heir);
            let (date, all) = still.served(&self.shared.tasks, self.shared.clock.now());
            if !all && early {
                return None;
            }
            let (convert, exchange) = steps.take()?;
            heir.shared.served_before.store(date, Ordering::Release);
            Some(self.hand_over_now(window, still, convert, exchange))
        };
        let done = self.still_at_rest(limit, work)??;
        if done.is_ok() {
            if self.driven.is_some() {
                self.drive_shutdown(deadline);
            }
            self.shared.wake_control();
        }
        Ok(done)
    }

    /// The same, at this moment.
    fn hand_over_now<E>(
        &self,
        window: Window<'_>,
        still: &mut Still<'_>,
        convert: impl FnOnce(Frozen, &HeirIds<'_>) -> Result<Resume, E>,
        exchange: impl FnOnce(&dyn Body, &dyn Body),
    ) -> Result<Result<(), E>, NoRest> {
        let (heir, begin) = (window.0, Instant::now());
        let frozen = self.frozen_now(still, &mut || {}).map_err(|error| match error {
            FreezeError::Busy(held_up) => NoRest::HeldUp(held_up),
            FreezeError::Stopping { instance } => NoRest::Stops { instance },
        })?;
        let ids = |change: &mut dyn FnMut(&mut Record)| {
            let _gates: Vec<_> = heir.gates.iter().map(|gate| gate.lock()).collect();
            heir.change_ids(change);
        };
        let mut resume = match convert(frozen, &ids) {
            Ok(resume) => resume,
            Err(why) => return Ok(Err(why)),
        };
        resume.hold = true;
        let moved = self.give_replies(&mut resume);
        let next = self.lock().next_id;
        heir.renumber(next);
        heir.resume(resume);
        exchange(self.shared.body.as_ref(), heir.shared.body.as_ref());
        heir.go_on();
        drop(window);
        tracing::info!(instance = self.name, "handed over in {:?}", begin.elapsed());
        self.retire(still, &moved);
        self.stop_activities(None);
        Ok(Ok(()))
    }

    /// Gives the replies of activities that go on to `resume`. Returns all that it goes on with.
    fn give_replies(&self, resume: &mut Resume) -> Vec<u32> {
        let mut control = self.lock();
        let mut moved = Vec::new();
        let of_service = |one: &&mut Resumed| matches!(one.activity.owner, Owner::Service(_));
        for resumed in resume.activities.iter_mut().filter(of_service) {
            let id = resumed.activity.id;
            moved.push(id);
            if resumed.goes_on
                && let Some(entry) = control.entries.iter_mut().find(|entry| entry.id == id)
            {
                resumed.reply = entry.reply.take();
            }
        }
        moved
    }

    /// Gives the permanent activities the numbers from this one on: those below are of activities that
    /// go on.
    fn renumber(&self, next: u32) {
        self.lock().next_id = next;
        for task in self.shared.tasks.places() {
            let mut inside = self.gates[task].lock();
            let mut control = self.lock();
            let id = control.new_id();
            if let Some(run) = inside.core.run_of(task.index()) {
                let entries = control.entries.iter_mut();
                entries.filter(|entry| entry.id == run.id).for_each(|entry| entry.id = id);
                run.id = id;
            }
        }
    }

    /// Takes away the activities that go on elsewhere, and puts all others to sleep, until they are
    /// asked to stop.
    fn retire(&self, still: &mut Still<'_>, moved: &[u32]) {
        still.tasks.iter_mut().for_each(|inside| inside.core.retire(moved));
        let mut after = Afterwards::default();
        {
            let mut control = self.lock();
            for entry in control.entries.iter_mut().filter(|entry| moved.contains(&entry.id)) {
                if let Some(reply) = entry.reply.take() {
                    let refused = crate::api::Outcome::Exception(interrupted("reload"));
                    after.replies.push((reply, crate::api::Progress::Ended(refused)));
                }
            }
            control.entries.retain(|entry| !moved.contains(&entry.id));
        }
        self.finish_off(after);
    }
}
