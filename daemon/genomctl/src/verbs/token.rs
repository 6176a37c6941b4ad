//! `genomctl token`: creates tokens for daemons that listen beyond their Unix socket.

use std::fs::{File, OpenOptions};
use std::io::{Read as _, Write as _};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::PathBuf;

use genom_protocol::{Reloaded, Right, routes};
use serde_json::json;

use crate::failure::Failure;
use crate::session::Session;

/// Create a token, as an entry of a daemon's token file (`genomd --token-file`). `token reload`
/// makes the daemon read that file again.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct Args {
    #[command(subcommand)]
    what: Option<What>,
    /// Name of its holder, used in messages and logs.
    #[arg(required = true)]
    name: Option<String>,
    /// Rights of its holder.
    #[arg(long, value_delimiter = ',', default_value = "read")]
    rights: Vec<Right>,
    /// Add it to this file, which is created with access for you alone if it does not exist
    /// [default: print it].
    #[arg(long, value_name = "FILE")]
    into: Option<PathBuf>,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    /// Make the daemon read its token file again, as SIGHUP does.
    ///
    /// A token that is not in the file any more is refused from the next request on. If the file
    /// has a mistake, nothing changes.
    Reload,
}

pub(super) async fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    if let Some(What::Reload) = args.what {
        let reply = session.ask(routes::reload_tokens()).await?;
        return session.show(&reply, |reply: &Reloaded| format!("{} tokens known\n", reply.tokens));
    }
    let name = args.name.as_deref().unwrap_or_default();
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_.@".contains(c);
    if name.is_empty() || !name.chars().all(plain) {
        return Err(Failure::usage(
            format!("`{name}` is no name for a token"),
            "letters, digits, `-`, `_`, `.` and `@`",
        ));
    }
    let mut random = [0; 32];
    File::open("/dev/urandom")?.read_exact(&mut random)?;
    let token: String = random.iter().map(|byte| format!("{byte:02x}")).collect();
    let rights: Vec<_> = args.rights.iter().map(|right| format!("\"{right}\"")).collect();
    let entry = format!(
        "[[token]]\nname = \"{name}\"\ntoken = \"{token}\"\nrights = [{}]\n",
        rights.join(", ")
    );
    match &args.into {
        None => session.print_text("token", &entry),
        Some(path) => {
            let mut file = OpenOptions::new().create(true).append(true).mode(0o600).open(path)?;
            file.write_all(entry.as_bytes())?;
            if session.json {
                return session.print(&format!("{}\n", json!({ "name": name, "into": path })));
            }
            Ok(())
        }
    }
}
