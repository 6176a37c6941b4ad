//! A writing and a reading process in lockstep: one value at a time, over each transport in turn.
//!
//! Through a pipe the writer announces which transport it will use; the reader replies that it is
//! polling it, and later when the value arrived. Both read the same clock. Because the transports
//! alternate, a disturbance on the machine affects all of them alike.

use std::io::{self, Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use crate::clock;
use crate::error::FloorError;

/// Time in ns after which a value counts as lost.
const PATIENCE: u64 = 200_000_000;

/// Time in ns that two processes may take until the first value arrives.
const MEETING: u64 = 20_000_000_000;

/// Values sent over each transport before measuring begins.
const WARM_UP: usize = 100;

/// Number of polls between two calls of `yield`.
const LOOKS: usize = 16;

/// Sent instead of a time when nothing arrived.
const LOST: u64 = u64::MAX;

/// The writing end of one transport.
pub trait Send {
    /// Sends one value.
    ///
    /// # Errors
    /// The middleware refuses.
    fn send(&mut self) -> Result<(), FloorError>;
}

/// The reading end.
pub trait Receive {
    /// Whether a value arrived. If so, it has been copied into the reader's memory.
    ///
    /// # Errors
    /// The middleware refuses.
    fn arrived(&mut self) -> Result<bool, FloorError>;
}

/// What became of the values sent over one transport.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hops {
    /// Durations of those that arrived, in nanoseconds.
    pub durations: Vec<f64>,
    /// How many did not.
    pub lost: usize,
}

/// The reading process, as the writing one sees it.
#[derive(Debug)]
pub struct Reader {
    process: Child,
    to: ChildStdin,
    from: ChildStdout,
    /// When the last value was sent, in ns. The next is sent a whole number of periods later, as a
    /// periodic task would.
    date: u64,
}

impl Reader {
    /// Starts this program again with these arguments, as the reading process.
    ///
    /// # Errors
    /// It cannot be started.
    pub fn start(arguments: &[&str]) -> Result<Self, FloorError> {
        let mut process = Command::new(std::env::current_exe()?)
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let ends = process.stdin.take().zip(process.stdout.take());
        let (to, from) = ends.ok_or(io::Error::from(io::ErrorKind::BrokenPipe))?;
        Ok(Self { process, to, from, date: clock::now() })
    }

    fn ask(&mut self, number: u64) -> io::Result<u64> {
        self.to.write_all(&number.to_le_bytes())?;
        self.to.flush()?;
        self.hear()
    }

    fn hear(&mut self) -> io::Result<u64> {
        let mut answer = [0; 8];
        self.from.read_exact(&mut answer)?;
        Ok(u64::from_le_bytes(answer))
    }

    /// Makes the reading process open its ends for values of `bytes` bytes.
    ///
    /// # Errors
    /// The process is gone.
    pub fn open(&mut self, bytes: usize) -> Result<(), FloorError> {
        self.ask(bytes as u64)?;
        Ok(())
    }

    /// Sends a value once the reader is polling. Returns its latency in ns; `None` if it was lost.
    fn hop(
        &mut self,
        way: usize,
        end: &mut dyn Send,
        period: u64,
    ) -> Result<Option<u64>, FloorError> {
        self.ask(way as u64)?;
        let passed = clock::now().saturating_sub(self.date);
        self.date += (passed / period + 1) * period;
        clock::sleep_until(self.date);
        let sent = clock::now();
        end.send()?;
        let arrived = self.hear()?;
        Ok((arrived != LOST).then(|| arrived.saturating_sub(sent)))
    }

    /// Measures each transport with the given number of values, sent one `period` in nanoseconds
    /// apart, for as long as `goes_on` says so.
    ///
    /// # Errors
    /// No value arrives, the reading process is gone, the middleware refuses, or `goes_on` ended it.
    pub fn measure(
        &mut self,
        ends: &mut [Box<dyn Send>],
        rounds: usize,
        period: u64,
        goes_on: impl Fn() -> bool,
    ) -> Result<Vec<Hops>, FloorError> {
        let period = period.max(1);
        let mut all = vec![Hops::default(); ends.len()];
        let given_up = clock::now().saturating_add(MEETING);
        // Middlewares need time to connect.
        for (way, end) in ends.iter_mut().enumerate() {
            while self.hop(way, &mut **end, period)?.is_none() {
                if clock::now() > given_up {
                    return Err(FloorError::Silent(MEETING / 1_000_000_000));
                }
            }
        }
        let ways = ends.len();
        for round in 0..WARM_UP.min(rounds) + rounds {
            for turn in 0..ways {
                if !goes_on() {
                    return Err(FloorError::Interrupted);
                }
                // Alternate the order, so that each transport comes after each other one and finds
                // caches alike.
                let step = if round % 2 == 0 { turn } else { ways - turn };
                let way = (round / 2 + step) % ways;
                let Some((end, hops)) = ends.get_mut(way).zip(all.get_mut(way)) else { continue };
                let took = self.hop(way, &mut **end, period)?;
                if round >= WARM_UP.min(rounds) {
                    match took {
                        Some(took) => hops.durations.push(took as f64),
                        None => hops.lost += 1,
                    }
                }
            }
        }
        self.ask(u64::MAX)?;
        Ok(all)
    }

    /// Ends the reading process.
    ///
    /// # Errors
    /// It failed.
    pub fn finish(self) -> Result<(), FloorError> {
        let Self { mut process, to, from, .. } = self;
        drop((to, from));
        let status = process.wait()?;
        if status.success() {
            return Ok(());
        }
        Err(io::Error::other(status.to_string()).into())
    }
}

fn ask() -> io::Result<Option<u64>> {
    let mut question = [0; 8];
    match io::stdin().read_exact(&mut question) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(None),
        other => other.map(|()| Some(u64::from_le_bytes(question))),
    }
}

fn tell(number: u64) -> io::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(&number.to_le_bytes())?;
    out.flush()
}

/// The reading process: opens ends for each size it is asked for, and reports when values arrive.
///
/// # Errors
/// The writing process ended unexpectedly, or the middleware refuses.
pub fn serve(
    mut open: impl FnMut(usize) -> Result<Vec<Box<dyn Receive>>, FloorError>,
) -> Result<(), FloorError> {
    while let Some(bytes) = ask()? {
        let mut ends = open(usize::try_from(bytes).unwrap_or(usize::MAX))?;
        tell(0)?;
        loop {
            let Some(way) = ask()? else { return Ok(()) };
            let end = usize::try_from(way).ok().and_then(|way| ends.get_mut(way));
            let Some(end) = end else { break };
            while end.arrived()? {}
            tell(0)?;
            tell(look(&mut **end)?)?;
        }
        tell(0)?;
    }
    Ok(())
}

fn look(end: &mut dyn Receive) -> Result<u64, FloorError> {
    let start = clock::now();
    loop {
        for _ in 0..LOOKS {
            if end.arrived()? {
                return Ok(clock::now());
            }
        }
        if clock::now().saturating_sub(start) > PATIENCE {
            return Ok(LOST);
        }
        std::thread::yield_now();
    }
}
