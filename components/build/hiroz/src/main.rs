//! A node of ROS 2 over zenoh, made with hiroz, an implementation that has nothing in common with
//! genomd's. Controlled line by line.
//!
//! Each input line is a command, `["verb", arguments...]`; each output line is its result. Messages
//! are CDR in hexadecimal, with their header.

use std::collections::HashMap;
use std::error::Error;
use std::io::{BufRead as _, Write as _};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use hiroz::Builder as _;
use hiroz::context::ZContextBuilder;
use hiroz::ffi::publisher::RawPublisher;
use hiroz::ffi::service::RawServiceClient;
use hiroz::ffi::subscriber::RawSubscriber;
use hiroz::node::ZNode;
use hiroz::parameter::{Parameter, ParameterClient, ParameterTarget, ParameterValue};
use serde_json::{Value, json};
use tokio::runtime::Runtime;

type Wrong = Box<dyn Error + Send + Sync>;
type Outcome = Result<Value, Wrong>;

/// Only a failing test takes this long; its own watchdog waits longer.
const PATIENCE: Duration = Duration::from_secs(50);

struct Peer {
    node: Arc<ZNode>,
    runtime: Runtime,
    readers: HashMap<String, (RawSubscriber, Receiver<Vec<u8>>)>,
    writers: HashMap<String, RawPublisher>,
    clients: HashMap<String, RawServiceClient>,
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

/// Waits for what the graph of hiroz tells by a signal.
fn until(node: &ZNode, what: &str, mut holds: impl FnMut() -> bool) -> Result<(), Wrong> {
    let end = Instant::now() + PATIENCE;
    let (mutex, changed) = &*node.graph().change_signal;
    loop {
        let guard = mutex.lock().map_err(|error| error.to_string())?;
        if holds() {
            return Ok(());
        }
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(format!("never: {what}").into());
        }
        drop(changed.wait_timeout(guard, left).map_err(|error| error.to_string())?);
    }
}

impl Peer {
    fn new(router: &str) -> Result<Self, Wrong> {
        let builder = ZContextBuilder::default().with_router_endpoint(router);
        let context = builder.map_err(|error| error.to_string())?.build();
        let context = context.map_err(|error| error.to_string())?;
        let node = context.create_node("peer").without_parameters().build();
        let node = Arc::new(node.map_err(|error| error.to_string())?);
        Ok(Self {
            node,
            runtime: Runtime::new()?,
            readers: HashMap::new(),
            writers: HashMap::new(),
            clients: HashMap::new(),
        })
    }

    fn command(&mut self, verb: &str, given: &[Value]) -> Outcome {
        let node = &self.node;
        match verb {
            "read" => {
                let (topic, ty, hash) = (text(given, 0)?, text(given, 1)?, text(given, 2)?);
                let (sender, receiver) = channel();
                let heard = move |message: &[u8]| drop(sender.send(message.to_vec()));
                let reader = node.create_raw_subscriber(topic, ty, hash, heard)?;
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
                let writer = node.create_raw_publisher(topic, ty, hash)?;
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
                let there = client.wait_for_service(PATIENCE);
                self.clients.insert(service.to_owned(), client);
                Ok(json!(there))
            }
            "call" => {
                let client = &self.clients[text(given, 0)?];
                Ok(json!(hexadecimal(&client.call_raw(&bytes(text(given, 1)?)?, PATIENCE)?)))
            }
            "nodes" | "no node" => {
                let name = text(given, 0)?;
                let there = || {
                    let all = node.graph().get_node_names();
                    all.iter().any(|(node, before)| {
                        format!("{}/{node}", before.trim_end_matches('/')) == name
                    })
                };
                until(node, name, || there() == (verb == "nodes"))?;
                Ok(json!(there()))
            }
            "topics" => Ok(json!(node.graph().get_topic_names_and_types())),
            "services" => Ok(json!(node.graph().get_service_names_and_types())),
            "actions" => Ok(json!(node.graph().get_action_names_and_types())),
            "parameters" => {
                let target = ParameterTarget::new(text(given, 0)?, text(given, 1)?);
                let (name, value) = (text(given, 2)?, given.get(3).and_then(Value::as_f64));
                let client = ParameterClient::new(Arc::clone(node), target)?;
                let work = async {
                    let names = client.list(&[] as &[&str], None).await?.names;
                    let set = match value {
                        Some(value) => {
                            let one = Parameter::new(name, ParameterValue::Double(value));
                            let set = client.set(&[one]).await?;
                            set.iter().map(|one| one.successful).collect()
                        }
                        None => Vec::new(),
                    };
                    let value = match client.get(&[name]).await?.as_slice() {
                        [ParameterValue::Double(value)] => json!(value),
                        other => json!(format!("{other:?}")),
                    };
                    Ok(json!({"names": names, "set": set, "value": value}))
                };
                self.runtime.block_on(work)
            }
            other => Err(format!("no verb {other}").into()),
        }
    }
}

fn main() -> Result<(), Wrong> {
    let router = std::env::args().nth(1).ok_or("give the endpoint of the router")?;
    let mut peer = Peer::new(&router)?;
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
