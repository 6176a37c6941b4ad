//! `genomctl list`: lists components.

use genom_protocol::{Component, Components, LeftBehind, routes};

use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;

/// List the components that are running or being loaded, and those that did not stop in time.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {}

/// Where the column of cells stands.
const CELL: usize = 3;

pub(super) async fn run(_: Args, session: &Session) -> Result<(), Failure> {
    let reply = session.ask(routes::components()).await?;
    session.show_table(&reply, render)
}

fn render(reply: &Components) -> Table {
    let none = || "-".to_owned();
    let row = |component: &Component| {
        vec![
            component.name.clone(),
            component.component.clone(),
            component.state.clone(),
            component.backend.to_string(),
            component.activities.to_string(),
            component.library.display().to_string(),
        ]
    };
    let loading =
        |name: &String| vec![name.clone(), none(), "loading".to_owned(), none(), none(), none()];
    let left = |left: &LeftBehind| {
        vec![none(), left.component.clone(), left.state.clone(), none(), none(), none()]
    };
    let mut rows: Vec<_> = reply.components.iter().map(row).collect();
    rows.extend(reply.loading.iter().map(loading));
    rows.extend(reply.left_behind.iter().map(left));
    let mut header = vec!["NAME", "COMPONENT", "STATE", "BACKEND", "ACTIVITIES", "LIBRARY"];
    // A column of their own only where there are cells.
    if reply.components.iter().any(|component| component.cell.is_some()) {
        header.insert(CELL, "CELL");
        let cells = reply.components.iter().map(|component| component.cell.clone());
        for (row, cell) in rows.iter_mut().zip(cells.chain(std::iter::repeat(None))) {
            row.insert(CELL, cell.unwrap_or_else(none));
        }
    }
    Table { header, rows }
}
