//! All samples of the ports that are plotted, as recordings have them.

use std::collections::HashMap;

use genom_drawing::plot::{Curve, Plot, number, numbers};
use genom_protocol::frames::Frame;
use genom_protocol::{RecordingRequest, routes};
use genom_types::Record;
use serde_json::json;

use super::chosen::Chosen;
use crate::failure::Failure;
use crate::frames::Frames;
use crate::session::Session;

/// Numbers of a port that are plotted if none is named.
const MOST: usize = 8;

/// The recording that the samples come from.
pub(crate) struct Samples {
    frames: Frames,
    ports: Vec<Source>,
    /// Index of the port, by channel.
    channels: HashMap<u16, usize>,
}

struct Source {
    chosen: Chosen,
    record: Record,
    /// Index in the plot and path of each number, once they are known.
    curves: Vec<(usize, String)>,
}

impl Samples {
    /// Begins with the samples from now on, and a plot of `span` nanoseconds without any.
    pub(crate) async fn begin(
        session: &Session,
        chosen: Vec<Chosen>,
        span: u64,
    ) -> Result<(Self, Plot), Failure> {
        let ports = chosen.iter().map(|one| one.address.to_string()).collect();
        let request = json!(RecordingRequest { ports, ..RecordingRequest::default() });
        let body = session.client.open(&routes::record(), request.to_string().into_bytes()).await?;
        let mut plot = Plot::new(span);
        let mut ports = Vec::new();
        for chosen in chosen {
            let curves = chosen
                .members
                .iter()
                .map(|path| (plot.add(Curve::new(&chosen.address, path, span)), path.clone()));
            let curves = curves.collect();
            plot.docs
                .extend(chosen.doc.as_ref().map(|doc| (chosen.address.to_string(), doc.clone())));
            ports.push(Source { record: Record::new(&chosen.ty), chosen, curves });
        }
        Ok((Self { frames: Frames::new(body), ports, channels: HashMap::new() }, plot))
    }

    /// Adds the next sample to the plot; `false` if there are none any more. Cancel safe.
    pub(crate) async fn next(&mut self, plot: &mut Plot) -> Result<bool, Failure> {
        match self.frames.next().await? {
            Some(Frame::Channel(channel)) => {
                let is = |one: &Source| channel.topic[1..] == one.chosen.address.to_string();
                if let Some(index) = self.ports.iter().position(is) {
                    self.channels.insert(channel.channel, index);
                }
            }
            Some(Frame::Sample(sample)) => {
                let index = self.channels.get(&sample.channel).copied();
                let Some(port) = index.and_then(|index| self.ports.get_mut(index)) else {
                    return Ok(true);
                };
                if port.record.decode_message(sample.message).is_ok() {
                    port.take(sample.date, plot);
                }
            }
            Some(Frame::Lost(lost)) => plot.lost = plot.lost.max(lost.lost),
            Some(Frame::Start(_) | Frame::Until(_)) => {}
            Some(Frame::End(_)) | None => return Ok(false),
        }
        Ok(true)
    }
}

impl Source {
    fn take(&mut self, date: u64, plot: &mut Plot) {
        let value = self.record.to_json();
        if self.curves.is_empty() {
            let mut found = Vec::new();
            numbers(&value, "", &mut found);
            plot.left_out += found.len().saturating_sub(MOST);
            found.truncate(MOST);
            let span = plot.span;
            let curve =
                |path: String| (plot.add(Curve::new(&self.chosen.address, &path, span)), path);
            self.curves = found.into_iter().map(|(path, _)| path).map(curve).collect();
        }
        for (curve, path) in &self.curves {
            plot.take(*curve, date, number(&value, path));
        }
    }
}
