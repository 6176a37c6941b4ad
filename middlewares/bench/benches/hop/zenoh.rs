//! zenoh: bytes copied in by the writer, and copied out by the reader from where a callback stored
//! them.

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;

use genom_bench::pair::{Receive, Send};
use genom_middleware::Middleware;
use genom_zenoh::{Options, Zenoh};
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;
use zenoh::sample::Sample;
use zenoh::{Session, Wait};

use crate::Backend;
use crate::place::{Looks, Place};

/// genomd's backend.
pub(crate) fn ours(place: &Path) -> Arc<Zenoh> {
    let options = Options { rendezvous: Some(place.join("ours")), ..Options::default() };
    Zenoh::open(&options).unwrap()
}

pub(crate) struct Both {
    ours: Arc<Zenoh>,
    session: Session,
}

struct Out(Publisher<'static>, Vec<u8>);

impl Send for Out {
    fn send(&mut self) {
        self.0.put(black_box(&self.1)).wait().unwrap();
    }
}

impl Both {
    /// The bare sessions have the options of genomd's, and a socket of their own.
    pub(crate) fn open(place: &Path, reads: bool) -> Self {
        let ours = ours(place);
        let mut config = zenoh::Config::default();
        let socket = format!("[\"unixsock-stream/{}\"]", place.join("bare.sock").display());
        let (here, none) = if reads { ("connect", "listen") } else { ("listen", "connect") };
        for (key, value) in [
            (format!("{here}/endpoints").as_str(), socket.as_str()),
            (format!("{none}/endpoints").as_str(), "[]"),
            ("scouting/multicast/enabled", "false"),
            ("scouting/gossip/enabled", "false"),
        ] {
            config.insert_json5(key, value).unwrap();
        }
        Self { ours, session: zenoh::open(config).wait().unwrap() }
    }
}

impl Backend for Both {
    fn writer(&self, bytes: usize) -> Box<dyn Send> {
        let writer = self.session.declare_publisher(format!("bare/{bytes}"));
        let writer = writer.congestion_control(CongestionControl::Block).wait().unwrap();
        Box::new(Out(writer, vec![1; bytes]))
    }

    fn reader(&self, bytes: usize) -> Box<dyn Receive> {
        let place = Place::new();
        let to = Arc::clone(&place);
        let reader = self.session.declare_subscriber(format!("bare/{bytes}"));
        let keep = reader.callback(move |sample: Sample| to.put(sample)).wait().unwrap();
        let copy = |sample: &Sample, to: &mut Vec<u8>| {
            sample.payload().slices().for_each(|part| to.extend_from_slice(part));
        };
        Box::new(Looks::at(place, copy, keep))
    }

    fn ours(&self) -> &dyn Middleware {
        &*self.ours
    }
}
