//! `genomctl sdk`: installs what components are built against. No daemon.

use std::io;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

use genom_project::{Written, sdk};
use serde_json::json;

use crate::failure::Failure;
use crate::session::Session;

/// Install what components are built against below a prefix: headers, pkg-config files (genom3.pc,
/// genomd.pc), and the command genom3. Packages of genomd have all this.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The prefix, such as /usr/local or ~/.local.
    prefix: PathBuf,
    /// The prefix that the files name, if they are moved there later [default: they find it from
    /// where they are].
    #[arg(long, value_name = "PREFIX")]
    installed_as: Option<PathBuf>,
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let mut text = String::new();
    let mut list = Vec::new();
    let mut tell = |path: PathBuf, written: Written| {
        let word = match written {
            Written::Created => "created",
            Written::Replaced => "replaced",
            Written::Same | Written::Kept => "kept",
        };
        text.push_str(&format!("{word} {}\n", path.display()));
        list.push(json!({ "path": path, "written": word }));
    };
    for file in sdk::files(args.installed_as.as_deref()) {
        tell(args.prefix.join(&file.path), file.write(&args.prefix, true)?);
    }
    let link = args.prefix.join("bin/genom3");
    let written = command(&args.prefix, &link)
        .map_err(|error| io::Error::new(error.kind(), format!("{}: {error}", link.display())))?;
    tell(link, written);
    if session.json {
        return session.print(&format!("{}\n", json!({ "files": list })));
    }
    session.print(&text)
}

/// Makes the command: a link to the genomctl beside it, else to this one.
fn command(prefix: &Path, link: &Path) -> io::Result<Written> {
    let beside = prefix.join("bin/genomctl").is_file();
    let target = if beside { PathBuf::from("genomctl") } else { std::env::current_exe()? };
    if std::fs::read_link(link).is_ok_and(|found| found == target) {
        return Ok(Written::Same);
    }
    std::fs::create_dir_all(prefix.join("bin"))?;
    let existed = match std::fs::symlink_metadata(link) {
        // GenoM3's own program is not ours to replace.
        Ok(found) if !found.is_symlink() => {
            return Err(io::Error::other("is a program that genomctl did not install; remove it"));
        }
        Ok(_) => std::fs::remove_file(link).map(|()| true)?,
        Err(_) => false,
    };
    symlink(target, link)?;
    Ok(if existed { Written::Replaced } else { Written::Created })
}
