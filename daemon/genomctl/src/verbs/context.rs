//! `genomctl context`: manages contexts, which are names for daemons.

use clap::Subcommand;
use genom_protocol::contexts::{Context, Contexts};
use serde_json::json;

use crate::contexts;
use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;

/// Manage contexts: names for daemons, with the options and tokens to reach them.
///
/// They are kept in ~/.config/genomd/contexts.toml; `genomctl --context NAME VERB` uses one for a
/// single command.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Keep --socket, --host, --ca, --cert and --token-file as given under a name. This does not
    /// select the context.
    Add {
        /// Name of the context.
        name: String,
    },
    /// Select a context for all commands that do not name a daemon themselves.
    Use {
        /// Name of the context; without one, the default socket is used again.
        name: Option<String>,
    },
    /// List the contexts; a star marks the selected one.
    List,
    /// Remove a context.
    Remove {
        /// Name of the context.
        name: String,
    },
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let mut kept = contexts::read()?;
    match &args.what {
        What::Add { name } => {
            let context = contexts::of(&session.given);
            if context == Context::default() {
                return Err(Failure::usage(
                    "nothing says which daemon this is",
                    format!("genomctl context add {name} --host https://robot:7300 --ca ca.pem"),
                ));
            }
            kept.context.insert(name.clone(), context);
            contexts::write(&kept)?;
            if kept.current.as_ref() != Some(name) {
                session.tell(&format!(
                    "kept: --context {name} talks to it, `genomctl context use {name}` does from \
                     now on"
                ))?;
            }
            return print(session, &kept);
        }
        What::Use { name } => {
            if let Some(name) = name {
                contexts::named(&kept, name)?;
            }
            kept.current = name.clone();
        }
        What::List if session.json => {
            return session.print(&format!("{}\n", json!(kept)));
        }
        What::List => {
            let rows: Vec<_> = kept
                .context
                .iter()
                .map(|(name, context)| {
                    let star = if kept.current.as_ref() == Some(name) { "*" } else { "" };
                    vec![format!("{name}{star}"), contexts::target(context)]
                })
                .collect();
            let table = Table { header: vec!["CONTEXT", "DAEMON"], rows };
            return session.print(&table.text(session.terminal));
        }
        What::Remove { name } => {
            contexts::named(&kept, name)?;
            kept.context.remove(name);
            kept.current = kept.current.filter(|current| current != name);
        }
    }
    contexts::write(&kept)?;
    print(session, &kept)
}

/// With `--json`, prints all contexts.
fn print(session: &Session, kept: &Contexts) -> Result<(), Failure> {
    if session.json { session.print(&format!("{}\n", json!(kept))) } else { Ok(()) }
}
