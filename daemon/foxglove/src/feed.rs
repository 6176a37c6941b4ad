//! Samples for all clients: one recording of what they subscribed to.
//!
//! When that changes, a second recording begins before the first one ends, and is read when all
//! samples of the first one have been passed on. What both have is passed on once.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::body::Body;
use genom_protocol::frames::{EVENTS, Frame};
use genom_protocol::sse::Parser;
use genom_protocol::{ChangeParameters, RecordingRequest, routes};
use http_body_util::BodyExt as _;
use tokio::task::JoinHandle;
use tokio::time::{sleep, timeout};
use tokio_util::sync::CancellationToken;

use crate::hub::Hub;
use crate::lock::lock;

/// How long a recording that was asked to end may take for its last samples.
const LAST: Duration = Duration::from_secs(5);
/// Pause before something that failed is tried again.
const PAUSE: Duration = Duration::from_millis(500);
/// Two recordings date one sample one after the other: that much later at most, in nanoseconds.
const APART: u64 = 20_000;

/// The recording of what clients subscribed to.
pub(crate) struct Feed {
    hub: Arc<Hub>,
    /// Topics.
    wanted: BTreeSet<String>,
    running: Option<Running>,
    /// Date of the last sample of each topic that was passed on.
    last: Arc<Mutex<HashMap<String, u64>>>,
}

struct Running {
    end: CancellationToken,
    task: JoinHandle<()>,
}

impl Running {
    /// Asks it to end, and waits until its last samples are passed on.
    async fn finish(self) {
        self.end.cancel();
        let mut task = self.task;
        if timeout(LAST, &mut task).await.is_err() {
            task.abort();
        }
    }
}

impl Feed {
    pub(crate) fn new(hub: Arc<Hub>) -> Self {
        Self { hub, wanted: BTreeSet::new(), running: None, last: Arc::default() }
    }

    /// From now on, samples of these topics are passed on.
    pub(crate) fn want(&mut self, topics: BTreeSet<String>) {
        if topics == self.wanted {
            return;
        }
        self.wanted = topics;
        let before = self.running.take();
        if self.wanted.is_empty() {
            if let Some(before) = before {
                tokio::spawn(before.finish());
            }
            return;
        }
        let end = CancellationToken::new();
        let reading = Reading {
            hub: Arc::clone(&self.hub),
            topics: self.wanted.clone(),
            end: end.clone(),
            last: Arc::clone(&self.last),
            both: HashMap::new(),
        };
        self.running = Some(Running { end, task: tokio::spawn(reading.run(before)) });
    }
}

/// Reads one recording after the other of the same topics, until it is asked to end.
struct Reading {
    hub: Arc<Hub>,
    topics: BTreeSet<String>,
    end: CancellationToken,
    last: Arc<Mutex<HashMap<String, u64>>>,
    /// Topics that the recording before this one had, too, with the date until which it had them.
    both: HashMap<String, u64>,
}

impl Reading {
    async fn run(mut self, mut before: Option<Running>) {
        while !self.end.is_cancelled() {
            self.read(&mut before).await;
            tokio::select! { () = sleep(PAUSE) => {}, () = self.end.cancelled() => {} }
        }
        if let Some(before) = before {
            before.finish().await;
        }
    }

    /// The names by which the control plane knows the topics.
    fn names(&self) -> Vec<String> {
        let name = |topic: &String| {
            let name = topic.trim_start_matches('/');
            match name.split_once('/') {
                Some((EVENTS, _)) => EVENTS.to_owned(),
                _ => name.to_owned(),
            }
        };
        self.topics.iter().map(name).collect::<BTreeSet<_>>().into_iter().collect()
    }

    /// Reads one recording, to its end.
    async fn read(&mut self, before: &mut Option<Running>) {
        let request = RecordingRequest { ports: self.names(), ..RecordingRequest::default() };
        let request = serde_json::to_vec(&request).unwrap_or_default();
        let (hub, route) = (Arc::clone(&self.hub), routes::record());
        let mut body = match hub.inside.open(&hub.own, &route, request).await {
            Ok(response) => response.into_body(),
            // A component was unloaded: its channels soon are no more.
            Err(error) => return tracing::debug!("foxglove: no samples: {error}"),
        };
        let mut number = None;
        let mut asked = false;
        let (mut bytes, mut channels) = (Vec::new(), BTreeMap::new());
        loop {
            let more = tokio::select! {
                more = body.frame() => more,
                () = self.end.cancelled(), if !asked && number.is_some() => {
                    asked = true;
                    self.ask_to_end(number).await;
                    continue;
                }
            };
            let Some(Ok(more)) = more else { return };
            if let Some(more) = more.data_ref() {
                bytes.extend_from_slice(more);
            }
            let mut at = 0;
            loop {
                match Frame::first(&bytes[at..]) {
                    Ok(Some((frame, length))) => {
                        if let Frame::Start(start) = &frame {
                            number = Some(start.recording);
                            // All that is written and read from now on is in this recording.
                            self.take_over(before.take()).await;
                        }
                        self.take(frame, &mut channels);
                        at += length;
                    }
                    Ok(None) => break,
                    Err(error) => return tracing::error!("foxglove: a recording: {error}"),
                }
            }
            bytes.drain(..at);
        }
    }

    async fn ask_to_end(&self, number: Option<u64>) {
        let number = number.unwrap_or_default().to_string();
        let ended = self.hub.inside.ask(&self.hub.own, &routes::end_recording(&number), "").await;
        if let Err(error) = ended {
            tracing::debug!("foxglove: a recording is over: {error}");
        }
    }

    async fn take_over(&mut self, before: Option<Running>) {
        let Some(before) = before else { return };
        before.finish().await;
        self.both.clone_from(&lock(&self.last));
    }

    fn take(&mut self, frame: Frame<'_>, channels: &mut BTreeMap<u16, String>) {
        match frame {
            Frame::Channel(channel) => _ = channels.insert(channel.channel, channel.topic),
            Frame::Sample(sample) => {
                let Some(topic) = channels.get(&sample.channel) else { return };
                if !self.topics.contains(topic) {
                    return;
                }
                if let Some(until) = self.both.get(topic) {
                    if sample.date <= until.saturating_add(APART) {
                        return;
                    }
                    self.both.remove(topic);
                }
                self.hub.deliver(topic, sample.date, sample.message);
                let mut last = lock(&self.last);
                match last.get_mut(topic) {
                    Some(last) => *last = sample.date,
                    None => _ = last.insert(topic.clone(), sample.date),
                }
            }
            Frame::Lost(lost) => {
                if let Some(topic) = channels.get(&lost.channel) {
                    self.hub.lost(topic, lost.lost);
                }
            }
            Frame::Start(_) | Frame::End(_) | Frame::Until(_) => {}
        }
    }
}

/// The changes that the daemon tells.
pub(crate) struct Changes {
    hub: Arc<Hub>,
    body: Option<Body>,
    parser: Parser,
    /// Whether what there is has to be looked at, since changes may have been missed.
    missed: bool,
}

impl Changes {
    pub(crate) fn follow(hub: &Arc<Hub>) -> Self {
        Self { hub: Arc::clone(hub), body: None, parser: Parser::default(), missed: false }
    }

    /// Waits for the next change that concerns channels or services; whether it is one of
    /// components. Cancel safe.
    pub(crate) async fn next(&mut self) -> bool {
        loop {
            while let Some(event) = self.parser.next() {
                let data: serde_json::Value = serde_json::from_str(&event.data).unwrap_or_default();
                match data["event"].as_str().unwrap_or_default() {
                    "connected" | "disconnected" | "moved" => return false,
                    "missed" => return true,
                    other if other.starts_with("component_") || other.starts_with("cell_") => {
                        return true;
                    }
                    _ => {}
                }
            }
            if std::mem::take(&mut self.missed) {
                return true;
            }
            let Some(body) = &mut self.body else {
                self.open().await;
                continue;
            };
            match body.frame().await {
                Some(Ok(more)) => {
                    if let Some(more) = more.data_ref() {
                        self.parser.feed(more);
                    }
                }
                _ => self.body = None,
            }
        }
    }

    async fn open(&mut self) {
        let route = routes::events().with(&ChangeParameters::default());
        match self.hub.inside.open(&self.hub.own, &route, "").await {
            Ok(response) => {
                (self.body, self.parser) = (Some(response.into_body()), Parser::default());
                self.missed = true;
            }
            Err(error) => {
                tracing::debug!("foxglove: changes are not told: {error}");
                sleep(PAUSE).await;
            }
        }
    }
}
