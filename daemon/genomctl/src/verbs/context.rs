//! `genomctl context`: names for daemons.

use clap::Subcommand;
use genom_protocol::contexts::{Context, Contexts};
use serde_json::json;

use crate::contexts;
use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;

/// Keep names for daemons: how to reach each, with which token.
///
/// They are in ~/.config/genomd/contexts.toml; `genomctl --context NAME VERB` uses one once.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Keep what --socket, --host, --ca, --cert and --token-file say under a name; nothing else
    /// changes until it is used.
    Add {
        /// Its name.
        name: String,
    },
    /// Talk to this daemon from now on, unless the command line says otherwise.
    Use {
        /// Its name; without one, to the usual socket again.
        name: Option<String>,
    },
    /// List them; the one in use has a star.
    List,
    /// Forget one.
    Remove {
        /// Its name.
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

/// With `--json`, what is kept now.
fn print(session: &Session, kept: &Contexts) -> Result<(), Failure> {
    if session.json { session.print(&format!("{}\n", json!(kept))) } else { Ok(()) }
}
