//! A writing process and its reading one, of the bare middleware or of ports: what threads of one
//! do, and how they are set up, is no part of the other's figures.

use std::cell::Cell;
use std::error::Error;
use std::io::{self, BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::Arc;

use genom_bench::FloorError;
use genom_bench::bare::{self, Bare};
use genom_bench::pair::{self, Reader, Receive, Send};
use genom_middleware::Middleware;

use crate::{BACKENDS, gateway, ours, ports};

/// Precede what the processes of a side are told.
pub(crate) const WRITES: &str = "--writes";
pub(crate) const READS: &str = "--reads";

/// Said before each round.
const TURN: &str = "ready";

/// What a sample goes through.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Way {
    Bare,
    Ports,
    /// Ports, with a gateway on each side.
    Gateways,
}

impl Way {
    const ALL: [Self; 3] = [Self::Bare, Self::Ports, Self::Gateways];

    /// On a command line.
    fn word(self) -> &'static str {
        match self {
            Self::Bare => "bare",
            Self::Ports => "ports",
            Self::Gateways => "gateways",
        }
    }

    pub(crate) fn of(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|way| way.word() == word)
    }
}

/// One side, as the process that prints sees it.
pub(crate) struct Side {
    process: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
}

impl Side {
    /// Starts its writing process, which starts the reading one.
    pub(crate) fn start(
        name: &str,
        way: Way,
        place: &Path,
        period: u64,
    ) -> Result<Self, Box<dyn Error>> {
        let mut process = Command::new(std::env::current_exe()?)
            .args([WRITES, name, way.word()])
            .arg(place)
            .arg(period.to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let ends = process.stdin.take().zip(process.stdout.take());
        let (to, from) = ends.ok_or("no pipes")?;
        Ok(Self { process, to, from: BufReader::new(from) })
    }

    /// Opens ends for values of so many bytes, and waits until values arrive.
    pub(crate) fn open(&mut self, bytes: usize, rounds: usize) -> Result<(), Box<dyn Error>> {
        writeln!(self.to, "{bytes} {rounds}")?;
        self.hear()?;
        Ok(())
    }

    /// Sends a value over each end. After the last round, returns the durations in ns by end.
    pub(crate) fn round(&mut self) -> Result<Option<Vec<Vec<f64>>>, Box<dyn Error>> {
        writeln!(self.to)?;
        let told = self.hear()?;
        if told == TURN {
            return Ok(None);
        }
        let numbers = |end: &str| end.split(' ').map(str::parse).collect::<Result<_, _>>();
        Ok(Some(told.split(';').map(numbers).collect::<Result<_, _>>()?))
    }

    fn hear(&mut self) -> io::Result<String> {
        let mut line = String::new();
        self.from.read_line(&mut line)?;
        match line.strip_suffix('\n') {
            Some(line) => Ok(line.to_owned()),
            None => Err(io::ErrorKind::UnexpectedEof.into()),
        }
    }

    pub(crate) fn finish(self) -> Result<(), Box<dyn Error>> {
        let Self { mut process, to, .. } = self;
        drop(to);
        match process.wait()?.success() {
            true => Ok(()),
            false => Err("a process that writes failed".into()),
        }
    }
}

/// The middleware in one of the two processes.
enum Open {
    Bare(Box<dyn Bare>),
    Ours(Arc<dyn Middleware>),
    Through(gateway::Through),
}

impl Open {
    fn of(name: &str, way: Way, place: &Path, reads: bool) -> Result<Self, Box<dyn Error>> {
        let known = BACKENDS.into_iter().find(|known| *known == name);
        let name = known.ok_or("no such backend")?;
        Ok(match way {
            Way::Bare => {
                let bare = bare::open(ours::carrier(name), place, reads)?;
                Self::Bare(bare.ok_or("no such middleware")?)
            }
            Way::Gateways if name != "shm" => {
                Self::Through(gateway::Through::open(name, place, reads))
            }
            Way::Ports | Way::Gateways => Self::Ours(ours::open(name, place, reads)),
        })
    }

    fn writers(&self, bytes: usize) -> Result<Vec<Box<dyn Send>>, FloorError> {
        Ok(match self {
            Self::Bare(bare) => vec![bare.writer(bytes)?],
            Self::Ours(ours) => ports::writers(&**ours, bytes).into(),
            Self::Through(gateway) => ports::writers(gateway.ours(), bytes).into(),
        })
    }

    fn readers(&self, bytes: usize) -> Result<Vec<Box<dyn Receive>>, FloorError> {
        Ok(match self {
            Self::Bare(bare) => vec![bare.reader(bytes)?],
            Self::Ours(ours) => ports::readers(&**ours, bytes).into(),
            Self::Through(gateway) => ports::readers(gateway.ours(), bytes).into(),
        })
    }
}

/// The writing process. It asks before each round, so that the rounds of both sides alternate.
pub(crate) fn write(name: &str, way: Way, place: &Path, period: u64) -> Result<(), Box<dyn Error>> {
    let open = Open::of(name, way, place, false)?;
    let at = place.display().to_string();
    let mut reader = Reader::start(&[READS, name, way.word(), &at])?;
    while let Some((bytes, rounds)) = told().and_then(|line| two(&line)) {
        let mut ends = open.writers(bytes)?;
        reader.open(bytes)?;
        let (turn, ways) = (Cell::new(0), ends.len());
        let goes_on = || {
            let begins = turn.replace((turn.get() + 1) % ways) == 0;
            if begins {
                println!("{TURN}");
            }
            !begins || told().is_some()
        };
        let measured = reader.measure(&mut ends, rounds, period, goes_on)?;
        let words = |durations: Vec<f64>| {
            durations.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
        };
        let words: Vec<_> = measured.into_iter().map(|hops| words(hops.durations)).collect();
        println!("{}", words.join(";"));
    }
    drop(open);
    Ok(reader.finish()?)
}

/// A line of standard input, until its end.
fn told() -> Option<String> {
    io::stdin().lines().next()?.ok()
}

fn two(line: &str) -> Option<(usize, usize)> {
    let (one, other) = line.split_once(' ')?;
    Some((one.parse().ok()?, other.parse().ok()?))
}

/// The reading process.
pub(crate) fn read(name: &str, way: Way, place: &Path) -> Result<(), Box<dyn Error>> {
    let open = Open::of(name, way, place, true)?;
    Ok(pair::serve(|bytes| open.readers(bytes))?)
}
