//! What happens to a run at the beginning of a pass (R4, R14; genom3.md 7.4, step 2).

use crate::action::End;
use crate::state::{Life, Mode, Place, Run};
use crate::system::System;
use crate::variant::Variant;

impl System {
    /// R4: a run starts, stops or resumes. Stop requests count in every pass, starts and the ends
    /// of pauses only in those of ticks.
    pub(super) fn prepare(&self, run: &mut Run, tick: bool) {
        let machine = &self.machines[usize::from(run.machine)];
        let looks = tick || self.variant != Some(Variant::StopOnTicks);
        match run.life {
            Life::Cancelled => run.end = Some(End::Interrupted),
            Life::Init if tick && run.at_stop => {
                run.life = Life::Stop;
                self.enter(run, machine.stop);
            }
            Life::Init if tick => {
                run.life = Life::Run;
                self.enter(run, machine.start);
            }
            Life::Run if run.asked && looks => {
                run.life = Life::Stop;
                self.enter(run, machine.stop);
                if run.end.is_some() && machine.service.is_some() {
                    run.end = Some(End::Interrupted);
                }
            }
            Life::Run | Life::Stop if tick => {
                let paused = run.places.iter_mut().filter(|place| place.mode == Mode::Paused);
                paused.for_each(|place| place.mode = Mode::Ready);
            }
            Life::Init | Life::Run | Life::Stop => {}
        }
    }

    /// A state becomes the only active one; if it has no codel, the run ends.
    fn enter(&self, run: &mut Run, state: u16) {
        run.places.clear();
        if self.machines[usize::from(run.machine)].codel(state).is_some() {
            run.places.push(Place { state, mode: Mode::Ready });
        } else {
            run.end = Some(End::Success);
        }
    }

    /// R14: an external event puts a ready place in its state, beside those that do not sleep.
    pub(super) fn receive(&self, run: &mut Run, state: u16) {
        let active = matches!(run.life, Life::Run | Life::Stop) && run.end.is_none();
        if !active || self.machines[usize::from(run.machine)].codel(state).is_none() {
            return;
        }
        run.places.retain(|place| place.mode != Mode::Asleep);
        match run.places.iter_mut().find(|place| place.state == state) {
            Some(place) => place.mode = Mode::Ready,
            None => run.places.push(Place { state, mode: Mode::Ready }),
        }
    }
}
