//! Whether the endpoints are reached that a session is to connect to.
//!
//! A session goes on trying without a word. So another one is opened here that tries each endpoint
//! once, with the same certificates and passwords, and says why it fails.

use std::net::ToSocketAddrs as _;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use genom_middleware::Obstacle;
use zenoh::{Config, Session, Wait as _};

use crate::settings::{endpoints, get, locator};
use crate::words::plain;

/// How long all attempts together may take.
const PATIENCE: Duration = Duration::from_secs(3);

/// Endpoints that are tried.
const MOST: usize = 16;

/// Held while endpoints are tried, so that whoever asks often starts no more threads than these.
static TURN: Mutex<()> = Mutex::new(());

/// What became of an attempt: nothing if there is a session, or why there is none.
type Attempt = (String, Option<String>);

/// The endpoints that are not reached, with the reasons.
pub(crate) fn unreached(session: &Session, config: &Config) -> Vec<Obstacle> {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let links = session.info().links().wait();
    let links: Vec<String> = links.map(|link| locator(link.dst().as_str()).to_owned()).collect();
    let mut tried: Vec<String> = endpoints(config, "connect");
    tried.truncate(MOST);
    let (told, heard) = channel();
    for endpoint in &tried {
        let (endpoint, told) = (endpoint.clone(), told.clone());
        let (links, trial) = (links.clone(), trial(config, &endpoint));
        // Without another thread it is not tried, and nothing said of it.
        let _ = thread::Builder::new()
            .name("zenoh-doctor".to_owned())
            .spawn(move || attempt(endpoint, &links, trial, &told));
    }
    drop(told);
    let end = Instant::now() + PATIENCE;
    let mut open = tried;
    let mut found = Vec::new();
    while let Ok((endpoint, why)) =
        heard.recv_timeout(end.saturating_duration_since(Instant::now()))
    {
        open.retain(|other| *other != endpoint);
        found.extend(why.map(|why| obstacle(&endpoint, &why)));
    }
    let late = format!("no answer within {} s", PATIENCE.as_secs());
    found.extend(open.iter().map(|endpoint| obstacle(endpoint, &late)));
    found.sort_by(|one, other| one.what.cmp(&other.what));
    found
}

/// Tries an endpoint, unless there is a link with it.
fn attempt(endpoint: String, links: &[String], trial: Option<Config>, told: &Sender<Attempt>) {
    if is_linked(&endpoint, links) {
        let _ = told.send((endpoint, None));
        return;
    }
    let Some(trial) = trial else { return };
    let opened = zenoh::open(trial).wait();
    let why = opened.as_ref().err().map(|why| plain(&why.to_string()));
    // Nobody listens any more if it took too long.
    let _ = told.send((endpoint, why));
    if let Ok(session) = opened {
        let _ = session.close().wait();
    }
}

/// Whether one of the links is with that endpoint, whose host may be a name.
fn is_linked(endpoint: &str, links: &[String]) -> bool {
    let endpoint = locator(endpoint);
    if links.iter().any(|link| link == endpoint) {
        return true;
    }
    let Some((protocol, address)) = endpoint.split_once('/') else { return false };
    let addresses = address.to_socket_addrs().into_iter().flatten();
    addresses.into_iter().any(|address| links.contains(&format!("{protocol}/{address}")))
}

/// The configuration of a session that tries one endpoint, once.
fn trial(config: &Config, endpoint: &str) -> Option<Config> {
    let mut trial = config.clone();
    let connect = serde_json::json!([endpoint]).to_string();
    for (key, value) in [
        ("mode", "\"peer\""),
        ("listen/endpoints", "[]"),
        ("connect/endpoints", connect.as_str()),
        ("connect/timeout_ms", "0"),
        ("connect/exit_on_failure", "true"),
        ("scouting/multicast/enabled", "false"),
        ("scouting/gossip/enabled", "false"),
        ("adminspace/enabled", "false"),
    ] {
        trial.insert_json5(key, value).ok()?;
    }
    if !get(config, "id").is_null() {
        // Not that of the session, which may be known there.
        let id = zenoh::config::ZenohId::default();
        trial.insert_json5("id", &format!("\"{id}\"")).ok()?;
    }
    Some(trial)
}

fn obstacle(endpoint: &str, why: &str) -> Obstacle {
    let secret = ["tls/", "quic/"].iter().any(|protocol| endpoint.starts_with(protocol));
    let fix = if why.contains("InitSyn") {
        "what listens there speaks another version of zenoh's protocol, or is no zenoh: install \
         zenoh 1.x on both sides"
    } else if secret {
        "start who is to listen there; both sides need certificates of one authority, and a \
         `certificate` of this side where `mutual` is set"
    } else {
        "start the router or daemon that is to listen there, or correct `connect`"
    };
    let what =
        format!("there is no session with {}, which is to be connected: {why}", locator(endpoint));
    Obstacle { what, fix: fix.to_owned() }
}
