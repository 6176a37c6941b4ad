//! Bare zenoh: bytes copied in by the writer, and copied out by the reader from where a callback
//! stored them.

use std::fmt::Display;
use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;

use zenoh::Wait;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;
use zenoh::sample::Sample;

use super::ends::Bare;
use super::place::{Looks, Place};
use crate::error::FloorError;
use crate::pair::{Receive, Send};

/// A session that stays on this machine, with the options of genomd's.
#[derive(Debug)]
pub struct Session(zenoh::Session);

struct Out(Publisher<'static>, Vec<u8>);

fn refused(error: impl Display) -> FloorError {
    FloorError::of("zenoh")(error.to_string())
}

impl Send for Out {
    fn send(&mut self) -> Result<(), FloorError> {
        self.0.put(black_box(&self.1)).wait().map_err(refused)
    }
}

impl Session {
    /// The writing process listens on a socket in this folder, the reading one connects to it.
    ///
    /// # Errors
    /// zenoh refuses.
    pub fn open(place: &Path, reads: bool) -> Result<Self, FloorError> {
        let mut config = zenoh::Config::default();
        let socket = format!("[\"unixsock-stream/{}\"]", place.join("bare.sock").display());
        let (here, none) = if reads { ("connect", "listen") } else { ("listen", "connect") };
        for (key, value) in [
            (format!("{here}/endpoints").as_str(), socket.as_str()),
            (format!("{none}/endpoints").as_str(), "[]"),
            ("scouting/multicast/enabled", "false"),
            ("scouting/gossip/enabled", "false"),
        ] {
            config.insert_json5(key, value).map_err(refused)?;
        }
        zenoh::open(config).wait().map(Self).map_err(refused)
    }
}

impl Bare for Session {
    fn writer(&self, bytes: usize) -> Result<Box<dyn Send>, FloorError> {
        let writer = self.0.declare_publisher(format!("bare/{bytes}"));
        let writer = writer.congestion_control(CongestionControl::Block).wait().map_err(refused)?;
        Ok(Box::new(Out(writer, vec![1; bytes])))
    }

    fn reader(&self, bytes: usize) -> Result<Box<dyn Receive>, FloorError> {
        let place = Place::new();
        let to = Arc::clone(&place);
        let reader = self.0.declare_subscriber(format!("bare/{bytes}"));
        let keep = reader.callback(move |sample: Sample| to.put(sample)).wait().map_err(refused)?;
        let copy = |sample: &Sample, to: &mut Vec<u8>| {
            sample.payload().slices().for_each(|part| to.extend_from_slice(part));
        };
        Ok(Box::new(Looks::at(place, copy, keep)))
    }
}
