//! A node of ROS 2 over zenoh, made with hiroz, an implementation that has nothing in common with
//! genomd's. Controlled line by line.
//!
//! Each input line is a command, `["verb", arguments...]`; each output line is its result. Messages
//! are CDR in hexadecimal, with their header, unless hiroz has a type for them.
//!
//! The first argument of the program is the endpoint of the router. With `router` it is that router
//! as well; what begins with `/` is the namespace of the node.

mod actions;
mod graph;
mod learned;
mod parameters;
mod services;

use std::collections::HashMap;
use std::error::Error;
use std::io::{BufRead as _, Write as _};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use hiroz::Builder as _;
use hiroz::config::RouterConfigBuilder;
use hiroz::context::ZContextBuilder;
use hiroz::dynamic::DynSub;
use hiroz::ffi::publisher::RawPublisher;
use hiroz::ffi::service::RawServiceClient;
use hiroz::ffi::subscriber::RawSubscriber;
use hiroz::node::ZNode;
use hiroz::qos::{QosDurability, QosProfile};
use serde_json::{Value, json};
use tokio::runtime::Runtime;
use zenoh::Wait as _;

type Wrong = Box<dyn Error + Send + Sync>;
type Outcome = Result<Value, Wrong>;

/// Only a failing test takes this long; its own watchdog waits longer.
const PATIENCE: Duration = Duration::from_secs(50);

struct Peer {
    // Goals hold the node.
    actions: actions::Actions,
    served: HashMap<String, services::Served>,
    readers: HashMap<String, (RawSubscriber, Receiver<Vec<u8>>)>,
    writers: HashMap<String, RawPublisher>,
    clients: HashMap<String, RawServiceClient>,
    learned: HashMap<String, DynSub>,
    events: Option<parameters::Events>,
    node: Arc<ZNode>,
    runtime: Runtime,
    _router: Option<zenoh::Session>,
}

fn text(arguments: &[Value], at: usize) -> Result<&str, Wrong> {
    arguments
        .get(at)
        .and_then(Value::as_str)
        .ok_or_else(|| format!("argument {at} is no text").into())
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn bytes(hexadecimal: &str) -> Result<Vec<u8>, Wrong> {
    let pair = |at: usize| u8::from_str_radix(&hexadecimal[at..at + 2], 16);
    Ok((0..hexadecimal.len()).step_by(2).map(pair).collect::<Result<_, _>>()?)
}

/// The quality of service of those who keep what they wrote for readers that come late.
fn transient_local() -> QosProfile {
    QosProfile { durability: QosDurability::TransientLocal, ..QosProfile::default() }
}

impl Peer {
    fn new(router: &str, more: &[String]) -> Result<Self, Wrong> {
        let session = if more.iter().any(|word| word == "router") {
            let config = RouterConfigBuilder::new().with_listen_endpoint(router).build_config()?;
            Some(zenoh::open(config).wait()?)
        } else {
            None
        };
        let context = ZContextBuilder::default().with_router_endpoint(router)?.build()?;
        let mut node = context.create_node("peer").without_parameters();
        if let Some(namespace) = more.iter().find(|word| word.starts_with('/')) {
            node = node.with_namespace(namespace);
        }
        Ok(Self {
            node: Arc::new(node.build()?),
            runtime: Runtime::new()?,
            actions: actions::Actions::default(),
            served: HashMap::new(),
            readers: HashMap::new(),
            writers: HashMap::new(),
            clients: HashMap::new(),
            learned: HashMap::new(),
            events: None,
            _router: session,
        })
    }

    fn command(&mut self, verb: &str, given: &[Value]) -> Outcome {
        let node = &self.node;
        let late = given.get(3) == Some(&json!(true));
        let quality = late.then(transient_local);
        match verb {
            "read" => {
                let (topic, ty, hash) = (text(given, 0)?, text(given, 1)?, text(given, 2)?);
                let (sender, receiver) = channel();
                let heard = move |message: &[u8]| drop(sender.send(message.to_vec()));
                let reader =
                    node.create_raw_subscriber_with_qos(topic, ty, hash, heard, quality)?;
                self.readers.insert(topic.to_owned(), (reader, receiver));
                Ok(json!("reads"))
            }
            "sample" => {
                let (_, samples) = &self.readers[text(given, 0)?];
                Ok(json!(hexadecimal(&samples.recv_timeout(PATIENCE)?)))
            }
            "arrived" => {
                let (_, samples) = &self.readers[text(given, 0)?];
                Ok(json!(samples.try_recv().is_ok()))
            }
            "write" => {
                let (topic, ty, hash) = (text(given, 0)?, text(given, 1)?, text(given, 2)?);
                let writer = node.create_raw_publisher_with_qos(topic, ty, hash, quality)?;
                self.writers.insert(topic.to_owned(), writer);
                Ok(json!("writes"))
            }
            "put" => {
                self.writers[text(given, 0)?].publish_bytes(&bytes(text(given, 1)?)?)?;
                Ok(json!("put"))
            }
            "client" => {
                let (service, ty, hash) = (text(given, 0)?, text(given, 1)?, text(given, 2)?);
                let client = node.create_raw_service_client(service, ty, hash)?;
                graph::served(node, service)?;
                self.clients.insert(service.to_owned(), client);
                Ok(json!(true))
            }
            "call" => {
                let client = &self.clients[text(given, 0)?];
                Ok(json!(hexadecimal(&client.call_raw(&bytes(text(given, 1)?)?, PATIENCE)?)))
            }
            "serve" => {
                let served = services::serve(&self.runtime, node, given)?;
                self.served.insert(text(given, 0)?.to_owned(), served);
                Ok(json!("serves"))
            }
            "close" => {
                let name = text(given, 0)?;
                let served = self.served.remove(name).is_some();
                Ok(json!(self.writers.remove(name).is_some() || served))
            }
            "learn" => {
                let topic = text(given, 0)?;
                let (reader, told) = learned::learn(&self.runtime, node, topic, given)?;
                self.learned.insert(topic.to_owned(), reader);
                Ok(told)
            }
            "learned" => learned::next(&self.learned[text(given, 0)?]),
            "any learned" => learned::any(&self.learned[text(given, 0)?]),
            "parameters" => parameters::parameters(&self.runtime, node, given),
            "dump" => parameters::dump(&self.runtime, node, given),
            "load" => parameters::load(&self.runtime, node, given),
            "parameter events" => {
                self.events = Some(parameters::events(node)?);
                Ok(json!("reads"))
            }
            "parameter event" => {
                parameters::event(self.events.as_ref().ok_or("nobody reads them")?)
            }
            "action" | "goal" | "feedback" | "status" | "cancel" | "result" | "serve action"
            | "asked" | "feed" | "to cancel" | "end" => {
                self.actions.command(&self.runtime, node, verb, given)
            }
            _ => graph::command(node, verb, given),
        }
    }
}

fn main() -> Result<(), Wrong> {
    let arguments: Vec<String> = std::env::args().collect();
    let router = arguments.get(1).ok_or("give the endpoint of the router")?;
    let mut peer = Peer::new(router, &arguments[2..])?;
    let mut out = std::io::stdout();
    writeln!(out, "\"up\"")?;
    for line in std::io::stdin().lock().lines() {
        let command: Vec<Value> = serde_json::from_str(&line?)?;
        let verb = text(&command, 0)?.to_owned();
        let outcome = peer.command(&verb, &command[1..])?;
        writeln!(out, "{outcome}")?;
        out.flush()?;
    }
    Ok(())
}
