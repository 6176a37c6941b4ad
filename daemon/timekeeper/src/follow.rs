//! The thread that steps the clock.

use std::sync::{Arc, Weak};
use std::time::{Duration, Instant};
use std::{io, thread};

use genom_cells::Cells;
use genom_protocol::StepRequest;
use genom_runtime::{Clock, VirtualClock, nanos};
use genom_supervisor::Supervisor;
use tokio::runtime::Handle;

use crate::course::{Course, Move};
use crate::source::{Source, TOPIC};

/// How often it looks whether the daemon is stopping, and for dates that were not told.
const ROUND: Duration = Duration::from_millis(100);
/// The same on a middleware that does not tell when a date arrives.
const UNTOLD: Duration = Duration::from_millis(1);
/// Without a date for so long from the start on, the log says so.
const SILENCE: Duration = Duration::from_secs(5);
/// So many lines about dates go to the log in a second: a program that publishes wrong ones is not
/// told each time.
const LINES: u32 = 8;

/// From now on, the virtual clock of a daemon and its cells goes on as the dates of `source` say.
///
/// # Errors
/// The system cannot create a thread.
pub fn follow(
    source: Source,
    supervisor: &Arc<Supervisor>,
    cells: &Arc<Cells>,
    runtime: Handle,
) -> io::Result<()> {
    let Clock::Virtual(clock) = supervisor.clock.clone() else { return Ok(()) };
    let follower = Follower {
        source,
        clock,
        supervisor: Arc::downgrade(supervisor),
        cells: Arc::downgrade(cells),
        runtime,
        course: Course::default(),
        second: Instant::now(),
        lines: 0,
    };
    thread::Builder::new().name("genomd-clock".to_owned()).spawn(move || follower.run())?;
    Ok(())
}

struct Follower {
    source: Source,
    clock: Arc<VirtualClock>,
    supervisor: Weak<Supervisor>,
    cells: Weak<Cells>,
    runtime: Handle,
    course: Course,
    /// Begin of the second in which the log was told so many lines.
    second: Instant,
    lines: u32,
}

impl Follower {
    fn run(mut self) {
        tracing::info!("the clock follows {TOPIC} of ROS 2");
        let wakes = self.source.wakes(thread::current());
        let begin = Instant::now();
        let (mut begun, mut silent) = (false, false);
        while self.supervisor.upgrade().is_some_and(|supervisor| !supervisor.stopping()) {
            match self.source.next() {
                Ok(Some(date)) => {
                    begun = true;
                    self.go(date);
                }
                Ok(None) => {
                    if !begun && !silent && begin.elapsed() > SILENCE {
                        silent = true;
                        tracing::warn!(
                            "nothing was published on {TOPIC} so far: time of components stands \
                             still (start the simulator, or `genomctl doctor`)"
                        );
                    }
                    thread::park_timeout(if wakes { ROUND } else { UNTOLD });
                }
                Err(why) => self.tell(&format!("a date on {TOPIC} is left out: {why}")),
            }
        }
    }

    fn go(&mut self, date: Duration) {
        let from_here = "time of components goes on from here";
        match self.course.at(date) {
            Move::Begin => {
                tracing::info!("the time on {TOPIC} is {:.3} s: it goes on", date.as_secs_f64());
            }
            Move::Stay => {}
            Move::Step(passed) => self.step(passed),
            Move::Back(by) => self.tell(&format!(
                "the time on {TOPIC} was set back by {by:?}: {from_here} (a simulation that starts \
                 again, or two programs that publish it)"
            )),
            Move::Ahead(by) => {
                self.tell(&format!("the time on {TOPIC} jumped ahead by {by:?}: {from_here}"));
            }
        }
    }

    /// Cells first, as a step that is asked for does it.
    fn step(&mut self, passed: Duration) {
        let Some(cells) = self.cells.upgrade() else { return };
        let request = StepRequest { nanoseconds: nanos(passed) };
        if let Err(error) = self.runtime.block_on(cells.step(&request)) {
            self.tell(&format!("a cell did not take the step: {error}"));
        }
        self.clock.step(passed);
    }

    /// Tells the log, unless it was told much already.
    fn tell(&mut self, what: &str) {
        if self.second.elapsed() > Duration::from_secs(1) {
            (self.second, self.lines) = (Instant::now(), 0);
        }
        self.lines += 1;
        match self.lines {
            ..LINES => tracing::warn!("{what}"),
            LINES => tracing::warn!("{what}; more in this second is not told"),
            _ => {}
        }
    }
}
