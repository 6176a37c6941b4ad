//! What is measured of a running deployment: counters and processes first, then, in a time of its
//! own so that it disturbs neither, when samples are written and read.

use std::collections::{BTreeSet, HashMap};
use std::time::{Duration, Instant};

use genom_comparison::pairing::Pairs;
use genom_comparison::process::Usage;
use genom_comparison::report::{Measured, Run};
use genom_protocol::frames::{Frame, Times};
use genom_protocol::{Address, Connection, ConnectionKind, RecordingRequest, Traffic, routes};
use serde_json::json;

use crate::failure::Failure;
use crate::frames::Frames;
use crate::session::Session;
use crate::traffic::reading;

/// Measures for so long, twice.
pub(super) async fn run(session: &Session, process: u32, time: Duration) -> Result<Run, Failure> {
    let connections = session.ask(routes::connections()).await?.content.connections;
    let ports = |one: &Connection| matches!(one.kind, ConnectionKind::Port);
    let connections: Vec<Connection> = connections.into_iter().filter(ports).collect();
    let components = session.ask(routes::components()).await?.content.components;
    let own: BTreeSet<String> = components.into_iter().map(|component| component.name).collect();

    let mut measured = Vec::new();
    for one in connections {
        let ends = counters(session, &own, &one).await?;
        measured.push((one, ends));
    }
    let (begin, before) = (Instant::now(), Usage::of(process));
    tokio::time::sleep(time).await;
    let (span, after) = (begin.elapsed(), Usage::of(process));
    let mut run = Run {
        processor: after.processor.saturating_sub(before.processor),
        span,
        memory: after.memory,
        processes: after.processes,
        connections: Vec::new(),
    };
    for (one, (out, into)) in measured {
        let (out_now, into_now) = counters(session, &own, &one).await?;
        let policy = one.policy.as_deref().and_then(|policy| policy.parse().ok());
        run.connections.push(Measured {
            backend: one.backend.unwrap_or_default(),
            inport: one.inport,
            outport: one.outport,
            policy: policy.unwrap_or_default(),
            out: out.zip(out_now).map(|(before, now)| [before, now]),
            into: [into, into_now],
            pairs: Pairs::default(),
        });
    }
    let times = record(session, &run.connections, time).await?;
    let none = Vec::new();
    let of = |port: &str| times.get(&format!("/{port}")).unwrap_or(&none);
    for one in &mut run.connections {
        one.pairs = Pairs::of(of(&one.outport), of(&one.inport), one.policy);
    }
    Ok(run)
}

/// Counters of the out port, if this deployment has it, and of the in port.
async fn counters(
    session: &Session,
    own: &BTreeSet<String>,
    of: &Connection,
) -> Result<(Option<Traffic>, Traffic), Failure> {
    let address = |text: &str| {
        text.parse::<Address>().map_err(|error| session.client.misread(error.to_string()))
    };
    let out = match of.outport.parse::<Address>() {
        Ok(at) if own.contains(&at.component) => Some(reading(session, &at).await?),
        _ => None,
    };
    Ok((out, reading(session, &address(&of.inport)?).await?))
}

/// When samples are written and read, by topic.
async fn record(
    session: &Session,
    connections: &[Measured],
    time: Duration,
) -> Result<HashMap<String, Vec<Times>>, Failure> {
    let mut times: HashMap<String, Vec<Times>> = HashMap::new();
    let outs = connections.iter().filter(|one| one.out.is_some()).map(|one| one.outport.clone());
    let ports: BTreeSet<String> =
        outs.chain(connections.iter().map(|one| one.inport.clone())).collect();
    if ports.is_empty() {
        return Ok(times);
    }
    let request = json!(RecordingRequest {
        ports: ports.into_iter().collect(),
        times: true,
        ..RecordingRequest::default()
    });
    let body = session.client.open(&routes::record(), request.to_string().into_bytes()).await?;
    let mut frames = Frames::new(body);
    let Some(Frame::Start(start)) = frames.next().await? else {
        return Err(session.client.misread("a recording without a start".to_owned()));
    };
    let mut topics = HashMap::new();
    let mut over = std::pin::pin!(tokio::time::sleep(time));
    let mut ending = false;
    loop {
        tokio::select! {
            frame = frames.next() => match frame? {
                Some(Frame::Channel(channel)) => {
                    topics.insert(channel.channel, channel.topic);
                }
                Some(Frame::Sample(sample)) => {
                    let topic = topics.get(&sample.channel).cloned();
                    if let Some((topic, taken)) = topic.zip(Times::from_bytes(sample.message)) {
                        times.entry(topic).or_default().push(taken);
                    }
                }
                Some(Frame::Lost(_) | Frame::Start(_) | Frame::Until(_)) => {}
                Some(Frame::End(_)) => return Ok(times),
                None => return Err(session.client.lost()),
            },
            () = &mut over, if !ending => {
                ending = true;
                session.ask(routes::end_recording(&start.recording.to_string())).await?;
            }
        }
    }
}
