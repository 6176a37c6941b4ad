//! `genomctl backends`: the middlewares of the daemon.

use genom_protocol::{Capabilities, Endpoint, MiddlewareParameters, Middlewares, Stranger, routes};

use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;
use crate::terminal::Terminal;

/// List the middlewares that the daemon was built with, what they support and what is visible on
/// them.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Also list the ports and services visible on them, and peers that do not announce theirs.
    #[arg(long, short)]
    visible: bool,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let query = MiddlewareParameters { visible: args.visible, ..Default::default() };
    let reply = session.ask(routes::middlewares().with(&query)).await?;
    session.show(&reply, |reply| render(reply, session.terminal))
}

fn render(reply: &Middlewares, terminal: Terminal) -> String {
    let rows: Vec<_> = reply
        .middlewares
        .iter()
        .map(|middleware| {
            let mark = if middleware.name == reply.default { "*" } else { "" };
            vec![
                format!("{}{mark}", middleware.name),
                middleware.version.clone(),
                middleware.capabilities.as_ref().map_or_else(|| "not open".into(), words),
            ]
        })
        .collect();
    let header = vec!["BACKEND", "VERSION", "CAPABILITIES"];
    let mut out = Table { header, rows }.text(terminal);
    for middleware in &reply.middlewares {
        for endpoint in middleware.endpoints.iter().flatten() {
            let Endpoint { kind, address, ty } = endpoint;
            out.push_str(&format!("{}: {kind} {address} ({ty})\n", middleware.name));
        }
        for stranger in &middleware.strangers {
            let text = match stranger {
                Stranger::Reader { address } => format!("subscription {address} (unknown)"),
                Stranger::Session { name, role } => {
                    format!("{role} {name} (no genomd: what it opened does not show)")
                }
            };
            out.push_str(&format!("{}: {text}\n", middleware.name));
        }
    }
    out
}

fn words(capabilities: &Capabilities) -> String {
    let named = [
        ("variable-size", capabilities.variable_size),
        ("zero-copy", capabilities.zero_copy),
        ("cross-process", capabilities.cross_process),
        ("cross-host", capabilities.cross_host),
        ("native-services", capabilities.native_services),
    ];
    let words: Vec<_> = named.iter().filter(|(_, has)| *has).map(|(word, _)| *word).collect();
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;
    use serde_json::json;

    #[test]
    fn those_who_do_not_say_what_they_open_are_listed_last() {
        let middleware = json!({
            "name": "zenoh", "version": "1",
            "endpoints": [{"kind": "publisher", "address": "demo/position", "ty": "state"}],
            "strangers": [
                {"kind": "session", "name": "7db4", "role": "peer"},
                {"kind": "reader", "address": "demo/position"},
            ],
        });
        let reply = json!({"default": "zenoh", "middlewares": [middleware]});
        expect![[r#"
            BACKEND  VERSION  CAPABILITIES
            zenoh*   1        not open
            zenoh: publisher demo/position (state)
            zenoh: peer 7db4 (no genomd: what it opened does not show)
            zenoh: subscription demo/position (unknown)
        "#]]
        .assert_eq(&render(&serde_json::from_value(reply).unwrap(), Terminal::default()));
    }
}
