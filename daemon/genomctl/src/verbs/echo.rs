//! `genomctl echo`: prints the values of a port.

use clap_complete::engine::ArgValueCompleter;
use genom_protocol::{Address, Code, PortParameters, StreamEnd, StreamParameters, routes};
use serde_json::{Map, Value};
use tokio::signal::unix::{SignalKind, signal};

use crate::complete::Names;
use crate::escape;
use crate::failure::Failure;
use crate::names::address;
use crate::session::Session;
use genom_protocol::sse::Event;

/// Print the values of a port as they arrive, one per line, until Ctrl-C.
///
/// With `--json` and --time, each line is an object with `time` and `value`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The port: COMPONENT/PORT or COMPONENT/PORT/ELEMENT.
    #[arg(value_parser = address, add = ArgValueCompleter::from(Names::Ports))]
    port: Address,
    /// Stop after this many values.
    #[arg(short = 'n', long, value_name = "COUNT")]
    count: Option<u64>,
    /// Begin each line with the date of the sample, in seconds since 1970 or on the virtual clock.
    #[arg(long, short)]
    time: bool,
    /// Print only this member of the value, such as velocity, pose.x or samples.0; may be repeated:
    /// members are separated by tabs.
    #[arg(long, short, value_name = "MEMBER")]
    field: Vec<String>,
    /// Maximum number of values per second.
    #[arg(long, value_name = "HERTZ")]
    rate: Option<f64>,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let Address { component, port, element } = &args.port;
    let query = StreamParameters { element: element.clone(), rate: args.rate, form: None };
    let route = routes::values(component, port).with(&query);
    let mut events = session.client.stream(&route).await?;
    // Before anything is printed: a reader of the first line may send the interrupt at once.
    let mut interrupt = signal(SignalKind::interrupt())?;
    if let Some(element) = element {
        tell_absent(session, &args.port, element).await?;
    }
    let mut left = args.count.unwrap_or(u64::MAX);
    while left > 0 {
        let event = tokio::select! {
            event = events.next() => event?,
            _ = interrupt.recv() => return Ok(()),
        };
        let Some(event) = event else { return Err(session.client.lost()) };
        match event.kind.as_str() {
            "value" => {
                session.print(&args.line(&event, session.json)?)?;
                left -= 1;
            }
            "end" => return Err(ended(&args.port, &event.data)),
            _ => {}
        }
    }
    Ok(())
}

impl Args {
    /// The line for a value: the value or members of it, with its date if requested.
    fn line(&self, event: &Event, json: bool) -> Result<String, Failure> {
        let text = match self.field.as_slice() {
            [] => render(&event.data, json),
            fields => {
                let value: Value = serde_json::from_str(&event.data).unwrap_or_default();
                let chosen =
                    fields.iter().map(|field| Ok((field.as_str(), member(&value, field)?)));
                let chosen = chosen.collect::<Result<Vec<_>, Failure>>()?;
                if json {
                    let all: Map<_, _> = chosen
                        .iter()
                        .map(|(name, it)| ((*name).to_owned(), (*it).clone()))
                        .collect();
                    format!("{}\n", Value::Object(all))
                } else {
                    let line = |it: &Value| render(&it.to_string(), false).trim_end().to_owned();
                    let cells: Vec<_> = chosen.iter().map(|(_, it)| line(it)).collect();
                    format!("{}\n", cells.join("\t"))
                }
            }
        };
        let date = event.id.filter(|_| self.time);
        let date = date.map(|date| format!("{}.{:09}", date / NS, date % NS));
        Ok(match date {
            None => text,
            Some(date) if json => {
                format!("{{\"time\":{date},\"value\":{}}}\n", text.trim_end())
            }
            Some(date) => format!("{date} {text}"),
        })
    }
}

/// Nanoseconds per second.
const NS: u64 = 1_000_000_000;

/// The member of a value at a path of names and indices.
fn member<'a>(value: &'a Value, way: &str) -> Result<&'a Value, Failure> {
    let mut at = value;
    for step in way.split('.') {
        let next = match at {
            Value::Array(all) => step.parse().ok().and_then(|index: usize| all.get(index)),
            at => at.get(step),
        };
        at = next.ok_or_else(|| {
            let there = match at {
                Value::Object(members) => members.keys().cloned().collect::<Vec<_>>().join(", "),
                Value::Array(all) => format!("elements 0 to {}", all.len().saturating_sub(1)),
                _ => "no members".to_owned(),
            };
            let message = format!("--field {way}: there is no `{step}`");
            Failure::usage(message, format!("there is: {}", escape::line(&there)))
        })?;
    }
    Ok(at)
}

/// Tells the user that an element of a multiple port does not exist, or not yet.
async fn tell_absent(session: &Session, at: &Address, element: &str) -> Result<(), Failure> {
    let Address { component, port, .. } = at;
    let query = PortParameters { values: Some(false) };
    let reply = session.ask(routes::ports_of(component).with(&query)).await?;
    let start = format!("{component}/{port}/");
    let all = reply.content.ports.iter();
    let there: Vec<&str> = all.filter_map(|one| one.address.strip_prefix(&start)).collect();
    if there.contains(&element) {
        return Ok(());
    }
    let others = match &there[..] {
        [] => "it has none".to_owned(),
        [one] => format!("there is {one}"),
        several => format!("there are {}", several.join(", ")),
    };
    let text =
        format!("{component}/{port} has no element `{element}` yet: waiting for it; {others}");
    session.tell(&escape::line(&text))
}

/// One value per line: a plain number as such, everything else as JSON.
fn render(data: &str, json: bool) -> String {
    match serde_json::from_str::<Value>(data) {
        Ok(Value::String(text)) if !json => format!("{}\n", escape::lines(&text)),
        _ => format!("{}\n", escape::json(data)),
    }
}

fn ended(port: &Address, data: &str) -> Failure {
    let why = serde_json::from_str(data).map_or_else(|_| data.to_owned(), |end: StreamEnd| end.why);
    Failure::refused(Code::Ended.name(), format!("{port} is no more: {}", escape::line(&why)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(time: bool, fields: &[&str], json: bool) -> Result<String, Failure> {
        let field = fields.iter().map(|&field| field.to_owned()).collect();
        let port = "arm/pose".parse().unwrap();
        let args = Args { port, count: None, rate: None, time, field };
        let data = r#"{"pose":{"x":1.5,"name":"home"},"joints":[1,2]}"#.to_owned();
        let id = Some(1_700_000_000_000_001_000);
        args.line(&Event { kind: "value".to_owned(), data, id }, json)
    }

    #[test]
    fn a_line_has_the_members_and_the_date_that_are_asked_for() {
        assert_eq!(line(false, &["pose.x", "pose.name"], false).unwrap(), "1.5\thome\n");
        let printed = line(true, &["joints.1"], false).unwrap();
        assert_eq!(printed, "1700000000.000001000 2\n");
        let printed = line(true, &["joints.1"], true).unwrap();
        assert_eq!(printed, "{\"time\":1700000000.000001000,\"value\":{\"joints.1\":2}}\n");
        let refused = line(false, &["pose.y"], false).unwrap_err();
        assert!(refused.text().contains("there is: name, x") || refused.text().contains("x, name"));
    }
}
