//! `genomctl freeze`: writes the state of the running system into a file.

use std::fs::OpenOptions;
use std::io::Write as _;
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};

use genom_protocol::{Frozen, routes};

use crate::escape;
use crate::failure::Failure;
use crate::session::Session;

/// Write the running system into a file: its deployment, and of each component the IDS, the last
/// values of ports, and its activities with their inputs and states. `genomctl thaw` brings it back.
///
/// Each component is frozen between two of its codels; components one after the other, unless the
/// clock is virtual and stands still. Nothing is stopped.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The file to write (JSON), readable by you only. It is replaced as a whole.
    file: PathBuf,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    // Not escaped for terminals: values have to be as they are.
    let reply = session.client.request(&routes::freeze(), Vec::new()).await?;
    let frozen: Frozen =
        serde_json::from_value(reply).map_err(|error| session.client.misread(error.to_string()))?;
    let text = frozen.text();
    write(&args.file, text.as_bytes()).map_err(|error| {
        let message = format!("{}: {error}", args.file.display());
        Failure::usage(message, "name a file in a directory that you may write to")
    })?;
    session.print_text("frozen", &told(&args.file, &frozen, text.len()))
}

/// Writes another file beside it and renames that, so that there never is half of one.
fn write(path: &Path, text: &[u8]) -> std::io::Result<()> {
    let mut aside = path.as_os_str().to_owned();
    aside.push(format!(".{}", std::process::id()));
    let mut options = OpenOptions::new();
    let mut file = options.create_new(true).write(true).mode(0o600).open(&aside)?;
    let written = file.write_all(text).and_then(|()| file.sync_all());
    let renamed = written.and_then(|()| std::fs::rename(&aside, path));
    renamed.inspect_err(|_| drop(std::fs::remove_file(&aside)))
}

fn told(path: &Path, frozen: &Frozen, bytes: usize) -> String {
    let activities: usize = frozen.components.values().map(|one| one.activities.len()).sum();
    let plural = |count: usize, one: &str, many: &str| {
        format!("{count} {}", if count == 1 { one } else { many })
    };
    let mut out = format!(
        "{}: {}, {}, {bytes} bytes\n",
        path.display(),
        plural(frozen.components.len(), "component", "components"),
        plural(activities, "activity", "activities"),
    );
    for (name, state) in &frozen.components {
        for path in state.ids.iter().flat_map(|ids| &ids.left_out) {
            out.push_str(&format!("{name}: ids.{path} cannot be written: codels make it anew\n"));
        }
        for port in &state.ports_left_out {
            out.push_str(&format!("{name}: the value of port {port} is large, and was not kept\n"));
        }
    }
    escape::lines(&out)
}
