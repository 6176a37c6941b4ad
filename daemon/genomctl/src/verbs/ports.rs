//! `genomctl ports`: ports with their connections and values.

use clap_complete::engine::ArgValueCompleter;
use serde::Deserialize;
use serde_json::Value;

use crate::complete::Names;
use crate::failure::Failure;
use crate::names::url;
use crate::session::Session;
use crate::table::Table;

/// List ports, what they are connected to and their last values.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of the component; all components when left out.
    #[arg(add = ArgValueCompleter::from(Names::Components))]
    component: Option<String>,
}

#[derive(Debug, Deserialize)]
struct Reply {
    ports: Vec<Port>,
}

#[derive(Debug, Deserialize)]
struct Port {
    address: String,
    direction: String,
    #[serde(rename = "type")]
    ty: String,
    #[serde(default)]
    connected: Option<String>,
    #[serde(default)]
    value: Option<Value>,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let path = match &args.component {
        Some(component) => url(["components", component, "ports"]),
        None => "/ports".to_owned(),
    };
    let reply = session.get(&path).await?;
    session.show_table(reply, render)
}

fn render(reply: &Reply) -> Table {
    let rows: Vec<_> = reply
        .ports
        .iter()
        .map(|port| {
            vec![
                port.address.clone(),
                port.direction.clone(),
                port.ty.clone(),
                port.connected.clone().unwrap_or_else(|| "-".to_owned()),
                port.value.as_ref().map_or_else(|| "-".to_owned(), short),
            ]
        })
        .collect();
    Table { header: vec!["PORT", "DIRECTION", "TYPE", "CONNECTED", "VALUE"], rows }
}

/// A value cut to what fits a line; `genomctl echo` shows the whole.
fn short(value: &Value) -> String {
    const WIDTH: usize = 48;
    let text = value.to_string();
    match text.char_indices().nth(WIDTH) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}
