//! An instance on a staged clock, as whoever moves the clock sees it.

use crate::clock::OnStage;
use crate::engine::Engine;

impl OnStage for Engine {
    fn blocked(&self) -> Vec<usize> {
        self.shared.exclusion.blocked()
    }

    fn serving(&self) -> usize {
        let control = self.lock();
        control.serving + control.ready.len()
    }

    fn missed(&self) -> Vec<u64> {
        let now = self.shared.clock.now();
        let tasks = self.shared.tasks.iter();
        tasks.map(|task| task.figures.overruns.read(task.timing, now)).collect()
    }
}
