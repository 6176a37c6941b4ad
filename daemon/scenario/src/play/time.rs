//! Steps of the clock, in slices where something has to happen in between.

use genom_protocol::{StepRequest, routes};

use super::daemon::Daemon;
use super::pace::Pace;
use super::player::Player;
use super::why::Why;

impl<D: Daemon> Player<'_, D> {
    /// Advances by `span` nanoseconds.
    pub(super) async fn advance(&mut self, span: u64) -> Result<(), Why> {
        let target = self.now.saturating_add(span);
        let pace = self.pace().await?;
        if self.relays.is_empty() && !pace.cells {
            self.step(span).await?;
            return Ok(());
        }
        // What is due now comes first: the slices that follow end where a period does.
        let mut slice = 0;
        loop {
            self.step(slice).await?;
            self.relay().await?;
            slice = self.slice(pace.period, target);
            if self.now >= target {
                return Ok(());
            }
        }
    }

    /// Nanoseconds to the end of the present period, or to `target` if that is before.
    pub(super) fn slice(&self, period: Option<u64>, target: u64) -> u64 {
        let left = target.saturating_sub(self.now);
        period.map_or(left, |period| left.min(period - self.now % period))
    }

    async fn step(&mut self, span: u64) -> Result<(), Why> {
        let mut left = span;
        loop {
            let nanoseconds = left.min(StepRequest::LONGEST);
            let clock = self.daemon.send(routes::step(), &StepRequest { nanoseconds }).await?;
            self.now = clock.now;
            left -= nanoseconds;
            if left == 0 {
                return Ok(());
            }
        }
    }

    /// How the clock is stepped with what runs now.
    pub(super) async fn pace(&mut self) -> Result<Pace, Why> {
        if let Some(known) = self.pace {
            return Ok(known);
        }
        let mut pace = Pace { period: None, cells: false };
        for component in self.daemon.ask(routes::components()).await?.components {
            pace.cells |= component.cell.is_some();
            // One that is down has no tasks.
            let asked = self.daemon.ask(routes::statistics(&component.name)).await;
            let Ok(statistics) = asked else { continue };
            let periods = statistics.tasks.iter().filter_map(|task| task.period_ns);
            pace.period = periods.chain(pace.period).filter(|period| *period > 0).min();
        }
        self.pace = Some(pace);
        Ok(pace)
    }
}
