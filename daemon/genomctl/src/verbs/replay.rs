//! `genomctl replay`: publishes the samples of a recording to in ports.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::PathBuf;
use std::time::Duration;

use genom_protocol::{Address, Code, PortParameters, StepRequest, replay, routes};
use genom_recording::{MOST_APART, ReadError, Recorded, Recording, inport, same_type, samples_of};
use serde_json::json;
use tokio::time::Instant;

use crate::failure::Failure;
use crate::names::address;
use crate::session::Session;
use crate::table::Table;

/// Maximum number of bytes sent in one request.
const BATCH: usize = 256 << 10;

/// Publish the samples of a recording to in ports, with their original timing.
///
/// A recorded in port receives what it read during the recording. Use --to to publish the samples
/// of an out port to an in port. An in port that is connected to something else is refused:
/// disconnect it first.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// An MCAP file of `genomctl record`, or another one with CDR in it; or a bag of ROS 2.
    file: PathBuf,
    /// Publish a topic to an in port: /gps/pose=arm/target; may be repeated. Without this option,
    /// all recorded in ports that exist are used.
    #[arg(long, value_name = "TOPIC=PORT")]
    to: Vec<String>,
    /// Step the clock (`genomd --clock virtual`) from sample to sample, as fast as possible.
    #[arg(long)]
    step: bool,
    /// Speed relative to the recording: 2 is twice as fast.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, conflicts_with = "step")]
    rate: f64,
}

/// An in port to publish to.
struct Target {
    port: Address,
    published: u64,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    if !(args.rate > 0.0 && args.rate.is_finite()) {
        return Err(Failure::usage(format!("--rate {} is none", args.rate), "1 is as recorded"));
    }
    let failed = |error| Failure::file(&args.file, error);
    let file = samples_of(&args.file).map_err(|why| Failure::file(&args.file, why))?;
    let mut recording = Recording::open(&file).map_err(failed)?;
    if let Some((extent, messages)) = recording.cut {
        let file = args.file.display();
        tell(&format!(
            "{file} was not ended: {messages} messages are whole, and {} bytes at its end are \
             not; `genomctl recover` makes a whole file of it\n",
            extent.size - extent.whole
        ));
    }
    let mut targets = choose(&args, &recording, session).await?;
    let topic = |channel: &u16| {
        recording.channels().find(|(number, _)| number == channel).map(|(_, one)| one.topic.clone())
    };
    let topics = targets.keys().filter_map(topic).collect();
    recording.read(topics).map_err(failed)?;

    let mut pace = if args.step { Pace::stepped(session).await? } else { Pace::timed(args.rate) };
    let mut batch = Vec::new();
    let mut counts: BTreeMap<u16, u64> = BTreeMap::new();
    let mut last = None;
    while let Some(sample) = recording.next_sample().map_err(failed)? {
        if last
            .replace(sample.date)
            .is_some_and(|last| sample.date.saturating_sub(last) > MOST_APART)
        {
            return Err(failed(ReadError::Dates));
        }
        let due = pace.is_due(&sample);
        if !batch.is_empty() && (!due || batch.len() > BATCH) {
            send(session, &mut batch, &mut counts, &mut targets).await?;
        }
        if !due {
            tokio::select! {
                reached = pace.reach(&sample, session) => reached?,
                _ = tokio::signal::ctrl_c() => return show(session, &targets, false),
            }
        }
        let Some(target) = targets.get(&sample.channel) else { continue };
        replay::append(&mut batch, &target.port.to_string(), &sample.message);
        *counts.entry(sample.channel).or_default() += 1;
    }
    send(session, &mut batch, &mut counts, &mut targets).await?;
    pace.end(session).await?;
    show(session, &targets, true)
}

async fn send(
    session: &Session,
    batch: &mut Vec<u8>,
    counts: &mut BTreeMap<u16, u64>,
    targets: &mut BTreeMap<u16, Target>,
) -> Result<(), Failure> {
    if batch.is_empty() {
        return Ok(());
    }
    session.client.request(&routes::replay(), std::mem::take(batch)).await?;
    for (channel, count) in std::mem::take(counts) {
        if let Some(target) = targets.get_mut(&channel) {
            target.published += count;
        }
    }
    Ok(())
}

fn show(session: &Session, targets: &BTreeMap<u16, Target>, complete: bool) -> Result<(), Failure> {
    let ports: Vec<_> = targets
        .values()
        .map(|target| json!({"port": target.port.to_string(), "published": target.published}))
        .collect();
    session.show_own(&json!({"complete": complete, "ports": ports}), || {
        let rows: Vec<Vec<String>> = targets
            .values()
            .map(|target| vec![target.port.to_string(), target.published.to_string()])
            .collect();
        Table { header: vec!["PORT", "PUBLISHED"], rows }
    })
}

/// The in ports to publish to, by channel.
async fn choose(
    args: &Args,
    recording: &Recording,
    session: &Session,
) -> Result<BTreeMap<u16, Target>, Failure> {
    let mut asked = BTreeMap::new();
    for text in &args.to {
        let halves = text.split_once('=').map(|(topic, port)| (topic.trim_matches('/'), port));
        let Some((topic, port)) = halves else {
            let message = format!("--to {text} is no TOPIC=PORT");
            return Err(Failure::usage(message, "write for instance /gps/pose=arm/target"));
        };
        let port = address(port).map_err(|why| Failure::usage(why, "the port is the second"))?;
        asked.insert(topic.to_owned(), port);
    }
    let query = PortParameters { values: Some(false) };
    let known = session.ask(routes::ports().with(&query)).await?.content;
    let mut targets = BTreeMap::new();
    let mut found: Vec<String> = Vec::new();
    for (number, channel) in recording.channels() {
        let topic = channel.topic.trim_matches('/');
        if channel.message_encoding != "cdr" {
            continue;
        }
        found.push(topic.to_owned());
        let port = match asked.remove(topic) {
            Some(port) => port,
            None if !args.to.is_empty() => continue,
            None => match topic.parse::<Address>() {
                Ok(port) if inport(&known, &port).is_some() => port,
                _ => {
                    tell(&format!("left out: {topic}, which is no in port of this daemon\n"));
                    continue;
                }
            },
        };
        let schema = channel.schema.as_ref().map(|schema| schema.data.as_ref());
        check_type(session, topic, schema.unwrap_or_default(), &port).await?;
        targets.insert(number, Target { port, published: 0 });
    }
    if let Some(topic) = asked.keys().next() {
        let message = format!("{} has no samples of /{topic}", args.file.display());
        return Err(Failure::usage(message, format!("there are: {}", found.join(", "))));
    }
    if targets.is_empty() {
        let message = format!("nothing in {} is to be fed to this daemon", args.file.display());
        return Err(Failure::usage(message, "--to TOPIC=PORT names an in port for a topic"));
    }
    Ok(targets)
}

/// Fails if the types differ: samples of another type would be misinterpreted.
async fn check_type(
    session: &Session,
    topic: &str,
    schema: &[u8],
    port: &Address,
) -> Result<(), Failure> {
    let message =
        session.ask(routes::port_type(&port.component, &port.port)).await?.content.message;
    let definition = message.definition.unwrap_or_default();
    if same_type(definition.as_bytes(), schema) {
        return Ok(());
    }
    let name = message.name;
    let message = format!("/{topic} was recorded with another type than {port} has now ({name})");
    Err(Failure::refused(Code::TypeMismatch.name(), message))
}

fn tell(text: &str) {
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

/// Decides when samples are due.
enum Pace {
    /// By the machine's clock, relative to the date of the first sample.
    Timed { rate: f64, first: Option<(u64, Instant)> },
    /// By the daemon's virtual clock, which this program steps.
    Stepped {
        /// Time of the daemon's clock.
        now: u64,
        /// Difference between the daemon's clock and dates of the recording; known from the first
        /// sample on.
        shift: Option<i128>,
    },
}

impl Pace {
    fn timed(rate: f64) -> Self {
        Pace::Timed { rate, first: None }
    }

    async fn stepped(session: &Session) -> Result<Self, Failure> {
        let reply = step(session, 0).await?;
        Ok(Pace::Stepped { now: reply, shift: None })
    }

    /// The date to publish a sample at. With a virtual clock it is just before the sample's own, so
    /// that the tick of that date is the first to read it.
    fn date(&mut self, sample: &Recorded) -> u64 {
        let Pace::Stepped { now, shift } = self else { return sample.date };
        let shift = *shift.get_or_insert_with(|| {
            // Dates that the virtual clock has not reached yet are used as they are; those of a
            // wall clock, which count from 1970, are shifted to begin now.
            let kept = sample.date > *now && sample.date - *now < MOST_APART;
            if kept { 0 } else { i128::from(*now) + 1 - i128::from(sample.date) }
        });
        let date = i128::from(sample.date) + shift - 1;
        u64::try_from(date.max(0)).unwrap_or(u64::MAX)
    }

    fn is_due(&mut self, sample: &Recorded) -> bool {
        let date = self.date(sample);
        match self {
            Pace::Stepped { now, .. } => date <= *now,
            Pace::Timed { rate, first } => {
                let (begin, start) = *first.get_or_insert_with(|| (date, Instant::now()));
                start + after(date, begin, *rate) <= Instant::now()
            }
        }
    }

    /// Waits, or steps the clock, until a sample is due.
    async fn reach(&mut self, sample: &Recorded, session: &Session) -> Result<(), Failure> {
        let date = self.date(sample);
        match self {
            Pace::Timed { rate, first } => {
                let (begin, start) = first.unwrap_or((date, Instant::now()));
                tokio::time::sleep_until(start + after(date, begin, *rate)).await;
            }
            Pace::Stepped { now, .. } => {
                while *now < date {
                    *now = step(session, (date - *now).min(StepRequest::LONGEST)).await?;
                }
            }
        }
        Ok(())
    }

    /// Steps once more, so that a tick reads the last sample.
    async fn end(&mut self, session: &Session) -> Result<(), Failure> {
        if let Pace::Stepped { .. } = self {
            step(session, 1).await?;
        }
        Ok(())
    }
}

fn after(date: u64, begin: u64, rate: f64) -> Duration {
    let seconds = Duration::from_nanos(date.saturating_sub(begin)).as_secs_f64() / rate;
    let longest = Duration::from_nanos(MOST_APART);
    Duration::try_from_secs_f64(seconds).map_or(longest, |after| after.min(longest))
}

async fn step(session: &Session, nanoseconds: u64) -> Result<u64, Failure> {
    Ok(session.send(routes::step(), &StepRequest { nanoseconds }).await?.content.now)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_of_the_stepped_clock_are_kept_and_those_of_the_wall_begin_now() {
        let dates = |now, dates: [u64; 2]| {
            let mut pace = Pace::Stepped { now, shift: None };
            dates.map(|date| pace.date(&Recorded { channel: 0, date, message: Vec::new() }))
        };
        assert_eq!(dates(0, [5_000_000, 15_000_000]), [4_999_999, 14_999_999]);
        assert_eq!(dates(50, [10, 30]), [50, 70]);
        let wall = 1_795_288_202_264_920_918;
        assert_eq!(dates(50, [wall, wall + 10_000_000]), [50, 10_000_050]);
    }

    #[test]
    fn the_slowest_rate_waits_long_and_the_fastest_not_at_all() {
        assert_eq!(after(3_000_000_000, 1_000_000_000, 2.0), Duration::from_secs(1));
        assert_eq!(after(2, 1, f64::MIN_POSITIVE), Duration::from_nanos(MOST_APART));
        assert_eq!(after(2, 1, f64::MAX), Duration::ZERO);
    }
}
