//! `genomctl web`: opens the web console.

use std::io::{IsTerminal as _, stdout};
use std::process::{Command, Stdio};

use genom_protocol::{Link, LinkRequest, Right, routes};

use crate::failure::Failure;
use crate::session::Session;

/// Print a link that signs in to the web console once, and open it where there is a browser.
///
/// The daemon must have been started with `--web`. Whoever opens the link has your rights, or those
/// given here.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Rights of whoever opens the link [default: all of yours].
    #[arg(long, value_delimiter = ',')]
    rights: Option<Vec<Right>>,
    /// Only print the link.
    #[arg(long)]
    no_browser: bool,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let request = LinkRequest { rights: args.rights };
    let reply = session.send(routes::web_link(), &request).await?;
    session.show(&reply, |link: &Link| format!("{}\n", link.url))?;
    let seconds = reply.content.seconds;
    session.tell(&format!("it works once, within {seconds} s"))?;
    if !args.no_browser && !session.json && stdout().is_terminal() {
        open(&reply.content.url);
    }
    Ok(())
}

/// Opens the link in the user's browser, if there is one on this screen.
fn open(url: &str) {
    let screen = ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| std::env::var_os(name).is_some());
    let program = std::env::var_os("BROWSER").or_else(|| screen.then(|| "xdg-open".into()));
    let Some(program) = program else { return };
    // The link was printed: without a browser, the user opens it.
    let _ = Command::new(program)
        .arg(url)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
}
