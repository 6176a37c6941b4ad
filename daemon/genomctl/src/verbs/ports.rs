//! `genomctl ports`: lists ports with their connections and values.

use clap_complete::engine::ArgValueCompleter;
use genom_protocol::{Ports, routes};
use serde_json::Value;

use crate::complete::Names;
use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;

/// List ports, what they are connected to and their last values.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of the component; all components if left out.
    #[arg(add = ArgValueCompleter::from(Names::Components))]
    component: Option<String>,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let route = match &args.component {
        Some(component) => routes::ports_of(component),
        None => routes::ports(),
    };
    session.show_table(&session.ask(route).await?, render)
}

fn render(reply: &Ports) -> Table {
    let rows: Vec<_> = reply
        .ports
        .iter()
        .map(|port| {
            vec![
                port.address.clone(),
                port.direction.to_string(),
                port.ty.clone(),
                port.connected.clone().unwrap_or_else(|| "-".to_owned()),
                port.value.as_ref().map_or_else(|| "-".to_owned(), short),
            ]
        })
        .collect();
    Table { header: vec!["PORT", "DIRECTION", "TYPE", "CONNECTED", "VALUE"], rows }
}

/// A value, shortened to fit in a line; `genomctl echo` prints all of it.
fn short(value: &Value) -> String {
    const WIDTH: usize = 48;
    let text = value.to_string();
    match text.char_indices().nth(WIDTH) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}
