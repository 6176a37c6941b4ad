//! The writing process: sends at a rate.

use std::error::Error;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;
use std::time::Duration;

use genom_bench::pair::Send;
use genom_bench::{bare, clock, octets};
use genom_middleware::Middleware;

use crate::ends::writer;
use crate::reading::topic;
use crate::{FLOWS, Flow, READER, Way, ours, usage};

/// Nanoseconds between two samples on each topic until all readers have got one.
const MEETING: u64 = 50_000_000;

/// Nanoseconds that all readers may take until they have got one.
const PATIENCE: u64 = 20_000_000_000;

/// The reading process.
pub(crate) struct Reader {
    process: Child,
    to: ChildStdin,
    lines: Receiver<String>,
}

impl Reader {
    pub(crate) fn start(name: &str, place: &Path, what: &str) -> Result<Self, Box<dyn Error>> {
        let mut command = Command::new(std::env::current_exe()?);
        Self::of(command.args([READER, name]).arg(place).arg(what))
    }

    /// A process that answers as a reading one does.
    pub(crate) fn of(command: &mut Command) -> Result<Self, Box<dyn Error>> {
        let mut process = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let ends = process.stdin.take().zip(process.stdout.take());
        let (to, from) = ends.ok_or("no pipes")?;
        let (heard, lines) = channel();
        let listen = |from: ChildStdout| BufReader::new(from).lines().map_while(Result::ok);
        thread::spawn(move || listen(from).try_for_each(|line| heard.send(line)));
        Ok(Self { process, to, lines })
    }

    /// Whether it has said that it is connected.
    pub(crate) fn is_connected(&self) -> Result<bool, Box<dyn Error>> {
        Ok(self.line()?.is_some())
    }

    /// A line that it has said.
    fn line(&self) -> Result<Option<String>, Box<dyn Error>> {
        match self.lines.try_recv() {
            Ok(line) => Ok(Some(line)),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err("the other process has ended".into()),
        }
    }

    pub(crate) fn connected(&self) -> Result<(), Box<dyn Error>> {
        Ok(self.lines.recv().map(drop)?)
    }

    /// Samples since it was asked last, and its processor time so far.
    pub(crate) fn ask(&mut self) -> Result<(u64, Duration), Box<dyn Error>> {
        self.tell()?;
        figures(&self.lines.recv()?)
    }

    /// Asks, and does not wait.
    pub(crate) fn tell(&mut self) -> Result<(), Box<dyn Error>> {
        Ok(writeln!(self.to)?)
    }

    /// What it was asked, if it has answered.
    pub(crate) fn answer(&mut self) -> Result<Option<(u64, Duration)>, Box<dyn Error>> {
        self.line()?.map(|line| figures(&line)).transpose()
    }

    pub(crate) fn give_up(mut self) -> Result<(), Box<dyn Error>> {
        self.process.kill()?;
        self.process.wait()?;
        Ok(())
    }

    pub(crate) fn finish(self) -> Result<(), Box<dyn Error>> {
        let Self { mut process, to, .. } = self;
        drop(to);
        process.wait()?;
        Ok(())
    }
}

fn figures(line: &str) -> Result<(u64, Duration), Box<dyn Error>> {
    let (samples, time) = line.split_once(' ').ok_or("no figures")?;
    Ok((samples.parse()?, Duration::from_millis(time.parse()?)))
}

fn ports(of: &dyn Middleware, flow: &Flow) -> Vec<Box<dyn Send>> {
    let value = octets::sequence(flow.bytes);
    (0..flow.topics).map(|number| writer(of, &topic(number), value.clone())).collect()
}

/// What became of what was sent.
pub(crate) struct Outcome {
    pub(crate) sent: u64,
    pub(crate) arrived: u64,
    pub(crate) passed: Duration,
    /// Processor time of both processes.
    pub(crate) busy: Duration,
}

impl Outcome {
    pub(crate) fn print(&self, name: &str, what: &str, way: &str) {
        let Self { sent, arrived, passed, busy } = self;
        println!(
            "{name:>9} {what:>18} {way:>6} {sent:>8} {arrived:>8} {:>9.0} {:>8.1}%",
            *arrived as f64 / passed.as_secs_f64(),
            100.0 * busy.as_secs_f64() / passed.as_secs_f64(),
        );
    }
}

pub(crate) fn flow(name: &str, flow: &Flow, way: Way, seconds: u32) -> Result<(), Box<dyn Error>> {
    let place = tempfile::tempdir()?;
    let number = FLOWS.iter().position(|other| other.name == flow.name).unwrap_or_default();
    let what = format!("{} {number}", way.word());
    // Held until the end: ports and writers do not live longer.
    let bare = match way {
        Way::Bare => Some(
            bare::open(ours::carrier(name), place.path(), false)?.ok_or("not between processes")?,
        ),
        Way::Ports => None,
    };
    let middleware = bare.is_none().then(|| ours::open(name, place.path(), false));
    let mut ends: Vec<Box<dyn Send>> = match (&bare, &middleware) {
        (Some(bare), _) => {
            let ends = (0..flow.topics).map(|topic| bare.writer(flow.bytes + topic));
            ends.collect::<Result<_, _>>()?
        }
        (_, Some(middleware)) => ports(&**middleware, flow),
        _ => return Err("neither way".into()),
    };
    let mut reader = Reader::start(name, place.path(), &what)?;
    if !meet(&mut reader, &mut ends)? {
        println!("{name:>9} {:>18} {:>6} nothing arrives", flow.name, way.word());
        return reader.give_up();
    }
    send(&mut reader, &mut ends, flow, seconds)?.print(name, flow.name, way.word());
    reader.finish()
}

/// Sends until a sample has come on each topic; whether it has.
pub(crate) fn meet(
    reader: &mut Reader,
    ends: &mut [Box<dyn Send>],
) -> Result<bool, Box<dyn Error>> {
    let given_up = clock::now() + PATIENCE;
    while !reader.is_connected()? {
        if clock::now() > given_up {
            return Ok(false);
        }
        ends.iter_mut().try_for_each(|end| end.send())?;
        clock::sleep_until(clock::now() + MEETING);
    }
    Ok(true)
}

/// Sends at the rate of the flow.
pub(crate) fn send(
    reader: &mut Reader,
    ends: &mut [Box<dyn Send>],
    flow: &Flow,
    seconds: u32,
) -> Result<Outcome, Box<dyn Error>> {
    let (_, before) = reader.ask()?;
    let (begun, ours) = (clock::now(), usage::processor());
    let rounds = u64::from(flow.rate) * u64::from(seconds);
    for round in 0..rounds {
        clock::sleep_until(begun + round * 1_000_000_000 / u64::from(flow.rate));
        ends.iter_mut().try_for_each(|end| end.send())?;
    }
    let passed = Duration::from_nanos(clock::now() - begun);
    let (arrived, after) = reader.ask()?;
    let busy = usage::processor().saturating_sub(ours) + after.saturating_sub(before);
    Ok(Outcome { sent: rounds * flow.topics as u64, arrived, passed, busy })
}
