//! `genomctl echo`: values of a port as they come.

use clap_complete::engine::ArgValueCompleter;
use serde_json::Value;

use crate::complete::Names;
use crate::escape;
use crate::failure::Failure;
use crate::names::{Path2, encode, url};
use crate::session::Session;

/// Print the values of a port as they come, one a line, until Ctrl-C.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The port: COMPONENT/PORT or COMPONENT/PORT/ELEMENT.
    #[arg(add = ArgValueCompleter::from(Names::Ports))]
    port: Path2,
    /// Stop after this many values.
    #[arg(short = 'n', long, value_name = "COUNT")]
    count: Option<u64>,
    /// At most this many values a second.
    #[arg(long, value_name = "HERTZ")]
    rate: Option<f64>,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let (port, element) = args.port.port();
    let mut path = url(["components", &args.port.component, "ports", port, "stream"]);
    let mut query = Vec::new();
    query.extend(args.rate.map(|rate| format!("rate={rate}")));
    query.extend(element.map(|element| format!("element={}", encode(element))));
    if !query.is_empty() {
        path.push('?');
        path.push_str(&query.join("&"));
    }
    let mut events = session.client.stream(&path).await?;
    if let Some(element) = element {
        tell_absent(session, &args.port, port, element).await?;
    }
    let mut left = args.count.unwrap_or(u64::MAX);
    // One for all: a Ctrl-C that comes between two events counts, too.
    let interrupted = tokio::signal::ctrl_c();
    tokio::pin!(interrupted);
    while left > 0 {
        let event = tokio::select! {
            event = events.next() => event,
            _ = &mut interrupted => return Ok(()),
        };
        let Some(event) = event else { return Err(session.client.lost()) };
        match event.kind.as_str() {
            "value" => {
                session.print(&render(&event.data, session.json))?;
                left -= 1;
            }
            "end" => return Err(ended(&args.port, &event.data)),
            _ => {}
        }
    }
    Ok(())
}

/// Says that an element of a multiple port is not there, or not yet.
async fn tell_absent(
    session: &Session,
    address: &Path2,
    port: &str,
    element: &str,
) -> Result<(), Failure> {
    let component = &address.component;
    let told =
        session.get(&format!("{}?values=false", url(["components", component, "ports"]))).await?;
    let all = told["ports"].as_array().map(Vec::as_slice).unwrap_or_default();
    let start = format!("{component}/{port}/");
    let there: Vec<&str> =
        all.iter().filter_map(|one| one["address"].as_str()?.strip_prefix(&start)).collect();
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

/// One value a line: the value alone for a plain number, JSON for the rest.
fn render(data: &str, json: bool) -> String {
    match serde_json::from_str::<Value>(data) {
        Ok(Value::String(text)) if !json => format!("{}\n", escape::lines(&text)),
        _ => format!("{}\n", escape::json(data)),
    }
}

fn ended(port: &Path2, why: &str) -> Failure {
    Failure::refused("ended", format!("{port} is no more: {}", escape::line(why)))
}
