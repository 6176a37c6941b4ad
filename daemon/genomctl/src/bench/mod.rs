//! Runs a deployment in several ways, each with a daemon of its own, and measures it.

mod measure;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use genom_apart::Private;
use genom_comparison::Way;
use genom_comparison::floor::{Floor, Load, Measuring};
use genom_comparison::report::{Report, Run, Runs};

use crate::apart::{Apart, Genomd};
use crate::failure::Failure;
use crate::session::Session;

/// How often to look for what has no event to wait for.
const LOOK: Duration = Duration::from_millis(20);
/// How long values are sent over a bare middleware, at most.
const FLOOR: Duration = Duration::from_secs(2);

/// In the names of what daemons use alone.
const PURPOSE: &str = "bench";

/// What is to be compared.
pub(crate) struct Plan {
    /// The program.
    pub(crate) genomd: Genomd,
    /// The deployment file.
    pub(crate) file: PathBuf,
    pub(crate) ways: Vec<Way>,
    pub(crate) seconds: Duration,
    pub(crate) warm_up: Duration,
    pub(crate) runs: u32,
    pub(crate) isolated: bool,
    /// Whether to measure bare middlewares, too.
    pub(crate) floor: bool,
}

impl Plan {
    /// Runs all ways, in turns if there are several runs, so that a slow change of the machine
    /// affects all of them alike. What was started has ended when this returns or is dropped.
    pub(crate) async fn compare(&self, session: &Session) -> Result<Report, Failure> {
        let deployment = self.genomd.deployment(&self.file)?;
        let mut all: Vec<Runs> = self.ways.iter().map(|way| Runs::of(&way.to_string())).collect();
        let total = self.ways.len() * self.runs as usize;
        for number in 0..total {
            let rank = number % self.ways.len();
            let (Some(way), Some(runs)) = (self.ways.get(rank), all.get_mut(rank)) else { break };
            session.tell(&format!("{}/{total} {way}", number + 1))?;
            let run = self.run(number, way, &deployment).await;
            if let Err(why) = &run {
                session.tell(&format!("{way}: {why}"))?;
            }
            runs.add(run);
        }
        let mut report = Report {
            deployment: self.file.display().to_string(),
            genomd: self.genomd.version()?,
            processors: std::thread::available_parallelism().map_or(1, usize::from),
            seconds: self.seconds.as_secs_f64(),
            warm_up: self.warm_up.as_secs_f64(),
            runs: self.runs,
            isolated: self.isolated,
            ways: all.into_iter().map(Runs::report).collect(),
        };
        if self.floor {
            self.measure_floors(session, &mut report).await?;
        }
        Ok(report)
    }

    /// One run of a way: a daemon that nobody else knows, from its start to its end.
    async fn run(&self, number: usize, way: &Way, deployment: &str) -> Result<Run, String> {
        let text = |error: &dyn std::error::Error| error.to_string();
        let private = Private::new(PURPOSE, number).map_err(|error| text(&error))?;
        let table = way.configuration(deployment, self.isolated).map_err(|error| text(&error))?;
        let mut daemon = Apart::start(&self.genomd, private, table).await?;
        tokio::time::sleep(self.warm_up).await;
        let run = measure::run(&daemon.session, daemon.program.id(), self.seconds).await;
        // An end of the daemon explains more than that it does not answer.
        run.map_err(|failure| daemon.program.ended().unwrap_or_else(|| failure.to_string()))
    }

    /// Measures the bare middleware with what each connection carried.
    async fn measure_floors(&self, session: &Session, report: &mut Report) -> Result<(), Failure> {
        let mut known: BTreeMap<Load, Result<Floor, String>> = BTreeMap::new();
        for one in report.ways.iter_mut().flat_map(|way| &mut way.connections) {
            let Some(load) = one.load() else { continue };
            if !known.contains_key(&load) {
                let Load { backend, bytes, .. } = &load;
                session.tell(&format!("bare {backend} with {bytes} bytes"))?;
                let floor = self.floor_of(known.len(), &load).await?;
                known.insert(load.clone(), floor);
            }
            match known.get(&load) {
                Some(Ok(floor)) => one.floor_us = Some(*floor),
                Some(Err(why)) => one.floor_error = Some(why.clone()),
                None => {}
            }
        }
        Ok(())
    }

    async fn floor_of(&self, number: usize, load: &Load) -> Result<Result<Floor, String>, Failure> {
        // Other names than those of the daemons.
        let private = Private::new(PURPOSE, self.ways.len() * self.runs as usize + number)?;
        let time = self.seconds.min(FLOOR);
        let mut measuring = Measuring::start(self.genomd.path(), &private.place(), load, time)?;
        loop {
            if let Some(told) = measuring.look() {
                return Ok(told);
            }
            tokio::time::sleep(LOOK).await;
        }
    }
}
