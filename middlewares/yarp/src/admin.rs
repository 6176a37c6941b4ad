//! What YARP's tools ask of a port itself: who is connected, and connections to make or to end.

use std::collections::BTreeSet;

use crate::bottle::Value;
use crate::port::{Port, Role};
use crate::replies::Reply;
use crate::wire::Carrier;

/// Version of this protocol, as genuine ports tell it.
const VERSION: [i64; 3] = [1, 2, 3];

/// What follows from a question.
pub(crate) enum Then {
    Reply(Reply),
    /// These connections are closed.
    Cut {
        tokens: BTreeSet<u64>,
        reply: Reply,
    },
    /// A connection is made; `answer` makes the reply of what becomes of it.
    Connect {
        to: String,
        carrier: Carrier,
        answer: Making,
    },
}

/// Makes the reply of what became of a connection.
pub(crate) type Making = Box<dyn FnOnce(Result<(), String>) -> Reply + Send>;

impl Then {
    pub(crate) fn values(values: impl Into<Vec<Value>>) -> Self {
        Self::Reply(bottle(&values.into()))
    }
}

fn bottle(values: &[Value]) -> Reply {
    Reply::Bottle(Value::to_bottle(values))
}

/// The answer to `[add]` and `[del]`: a number, negative if it failed, and a sentence.
fn outcome(done: bool, sentence: String) -> Reply {
    let number = Value::Int(if done { 0 } else { -1 });
    bottle(&[number, Value::Text(format!("{sentence}\r\n"))])
}

/// Answers an administrative bottle.
pub(crate) fn ask(port: &Port, values: &[Value]) -> Then {
    let words: Vec<String> =
        values.iter().map(|value| value.as_word().unwrap_or_default()).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["ver", ..] => {
            let version = VERSION.map(Value::Int);
            Then::values([&[Value::vocab("ver")][..], &version[..]].concat())
        }
        ["add", to] => connect(port, to, None, outcome),
        ["add", to, carrier] => connect(port, to, Some(carrier), outcome),
        ["del", other] => disconnect(port, other, outcome),
        ["list", "out"] => Then::values(names(outputs(port))),
        ["list", "in"] => Then::values(names(inputs(port))),
        ["list", "out", to] => detail(outputs(port), to, |to| (port.name.clone(), to)),
        ["list", "in", from] => detail(inputs(port), from, |from| (from, port.name.clone())),
        ["prop", "get", ..] => Then::values([properties(port)]),
        ["help", ..] | [] => {
            let lines = [
                "[help]                  # give this help",
                "[ver]                   # report protocol version information",
                "[add] $portname         # add an output connection",
                "[add] $portname $car    # add an output with a given protocol (tcp, fast_tcp)",
                "[del] $portname         # remove an input or output connection",
                "[list] [in]             # list input connections",
                "[list] [out]            # list output connections",
                "[prop] [get]            # tell what the port is",
            ];
            let lines = lines.iter().map(|line| Value::from(*line));
            Then::values(std::iter::once(Value::vocab("many")).chain(lines).collect::<Vec<_>>())
        }
        _ => {
            let hint = "send [help] for list of valid commands";
            Then::values([Value::vocab("fail"), Value::from(hint)])
        }
    }
}

/// Answers a command in a word: `/dest` connects, `!/dest` and `~/src` end connections, `*` tells
/// how the port fares. `asking` is who asks.
pub(crate) fn command(port: &Port, word: &str, asking: &str, by: Carrier) -> Then {
    let said = |_: bool, sentence: String| Reply::Text(format!("{sentence}\r\n"));
    match word {
        "*" => Then::Reply(Reply::Text(describe(port, asking, by))),
        _ if word.starts_with('/') || word.contains(":/") => connect(port, word, None, said),
        _ => match word.strip_prefix(['!', '~']) {
            Some(other) => disconnect(port, other, said),
            None => {
                let hint = format!("{word:?} is no command; `*` tells how the port fares");
                Then::Reply(said(false, hint))
            }
        },
    }
}

type Telling = fn(bool, String) -> Reply;

/// `/name`, `carrier://name` or `carrier:/name`.
fn destination(text: &str) -> (Option<&str>, String) {
    match text.split_once(":/") {
        Some((carrier, name)) if !carrier.contains('/') => {
            (Some(carrier), format!("/{}", name.trim_start_matches('/')))
        }
        _ => (None, text.to_owned()),
    }
}

fn connect(port: &Port, to: &str, carrier: Option<&str>, telling: Telling) -> Then {
    let (own, from, text) = (port.name.clone(), port.name.clone(), to.to_owned());
    if !matches!(port.role, Role::Out(_)) {
        return Then::Reply(telling(false, "Outputs not allowed".to_owned()));
    }
    let (named, to) = destination(to);
    let wanted = named.or(carrier).unwrap_or("tcp");
    let Some(carrier) = Carrier::named(wanted) else {
        let why = format!("{own} does not offer the carrier {wanted}, but tcp and fast_tcp");
        return Then::Reply(telling(false, why));
    };
    let answer: Making = Box::new(move |made| match made {
        Ok(()) => telling(true, format!("Added connection from {from} to {text}")),
        Err(why) => telling(false, format!("Cannot connect {from} to {text}: {why}")),
    });
    Then::Connect { to, carrier, answer }
}

fn disconnect(port: &Port, other: &str, telling: Telling) -> Then {
    let (_, name) = destination(other);
    let (own, mut tokens) = (&port.name, BTreeSet::new());
    let sentence = match &port.role {
        Role::Out(out) => {
            tokens.extend(out.link_to(&name));
            format!("Removed connection from {own} to {name}")
        }
        Role::In(port) => {
            let found = port.senders().into_iter().filter(|(_, from)| *from == name);
            tokens.extend(found.map(|(token, _)| token));
            format!("Removing connection from {name} to {own}")
        }
        Role::Rpc(_) => String::new(),
    };
    if tokens.is_empty() {
        let sentence = format!("Could not find a connection of {own} with {name}");
        return Then::Reply(telling(false, sentence));
    }
    Then::Cut { tokens, reply: telling(true, sentence) }
}

type Connection = (String, Carrier);

fn outputs(port: &Port) -> Vec<Connection> {
    match &port.role {
        Role::Out(out) => out.links(),
        Role::In(_) | Role::Rpc(_) => Vec::new(),
    }
}

fn inputs(port: &Port) -> Vec<Connection> {
    match &port.role {
        Role::In(port) => {
            port.senders().into_iter().map(|(_, name)| (name, Carrier::FastTcp)).collect()
        }
        Role::Out(_) | Role::Rpc(_) => Vec::new(),
    }
}

fn names(connections: Vec<Connection>) -> Vec<Value> {
    connections.into_iter().map(|(name, _)| Value::Text(name)).collect()
}

fn pair(key: &str, value: Value) -> Value {
    Value::List(vec![Value::from(key), value])
}

fn detail(
    connections: Vec<Connection>,
    other: &str,
    ends: impl Fn(String) -> (String, String),
) -> Then {
    let (_, wanted) = destination(other);
    let found = connections.into_iter().find(|(name, _)| *name == wanted);
    Then::values(found.map_or_else(Vec::new, |(name, carrier)| {
        let (from, to) = ends(name);
        vec![
            pair("from", Value::Text(from)),
            pair("to", Value::Text(to)),
            pair("carrier", Value::from(carrier.name())),
        ]
    }))
}

fn properties(port: &Port) -> Value {
    let is = |truth: bool| Value::Int(truth.into());
    let of = vec![
        pair("is_input", is(!matches!(port.role, Role::Out(_)))),
        pair("is_output", is(matches!(port.role, Role::Out(_)))),
        pair("is_rpc", is(matches!(port.role, Role::Rpc(_)))),
        pair("type", Value::from(port.type_name())),
    ];
    pair("port", Value::List(of))
}

fn describe(port: &Port, asking: &str, by: Carrier) -> String {
    let name = &port.name;
    let mut lines = vec![format!("This is {name} at tcp://{}/", port.at)];
    let outputs = outputs(port);
    if outputs.is_empty() {
        lines.push("There are no outgoing connections".to_owned());
    }
    for (to, carrier) in outputs {
        let carrier = carrier.name();
        lines.push(format!("There is an output connection from {name} to {to} using {carrier}"));
    }
    let mut inputs = inputs(port);
    if inputs.iter().all(|(from, _)| from != asking) {
        inputs.push((asking.to_owned(), by));
    }
    for (from, carrier) in inputs {
        let carrier = carrier.name();
        lines.push(format!("There is an input connection from {from} to {name} using {carrier}"));
    }
    lines.join("\r\n") + "\r\n"
}
