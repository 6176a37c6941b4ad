//! `genomctl list`: the components that run.

use serde::Deserialize;

use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;

/// List the components that run or are being loaded, and what is left of those that did not stop.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {}

#[derive(Debug, Deserialize)]
struct Reply {
    components: Vec<Component>,
    #[serde(default)]
    loading: Vec<String>,
    #[serde(default)]
    left_behind: Vec<Left>,
}

/// What is left of a component that did not stop in time: it has no name any more.
#[derive(Debug, Deserialize)]
struct Left {
    component: String,
    state: String,
}

#[derive(Debug, Deserialize)]
struct Component {
    name: String,
    component: String,
    state: String,
    backend: String,
    activities: usize,
    library: String,
}

pub(super) async fn run(_: Args, session: &Session) -> Result<(), Failure> {
    let reply = session.get("/components").await?;
    session.show_table(reply, render)
}

fn render(reply: &Reply) -> Table {
    let none = || "-".to_owned();
    let row = |component: &Component| {
        vec![
            component.name.clone(),
            component.component.clone(),
            component.state.clone(),
            component.backend.clone(),
            component.activities.to_string(),
            component.library.clone(),
        ]
    };
    let loading =
        |name: &String| vec![name.clone(), none(), "loading".to_owned(), none(), none(), none()];
    let left = |left: &Left| {
        vec![none(), left.component.clone(), left.state.clone(), none(), none(), none()]
    };
    let mut rows: Vec<_> = reply.components.iter().map(row).collect();
    rows.extend(reply.loading.iter().map(loading));
    rows.extend(reply.left_behind.iter().map(left));
    Table { header: vec!["NAME", "COMPONENT", "STATE", "BACKEND", "ACTIVITIES", "LIBRARY"], rows }
}
