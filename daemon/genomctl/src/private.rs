//! Checks that nobody else can read a secret, or could have put a socket in place.

use std::fs::File;
use std::io::{self, Read as _};
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;

use crate::failure::Failure;

/// Reads a file that only its owner may read; `what` describes it in messages.
pub(crate) fn read(path: &Path, what: &str) -> Result<String, Failure> {
    let refuse = |why: String, help: &str| {
        Failure::usage(format!("the {what} {}: {why}", path.display()), help)
    };
    let unreadable =
        |error: io::Error| refuse(error.to_string(), "ask whoever runs the daemon for one");
    let mut file = File::open(path).map_err(unreadable)?;
    if file.metadata().map_err(unreadable)?.mode() & 0o077 != 0 {
        return Err(refuse("others may read it".to_owned(), "`chmod 600` it"));
    }
    let mut text = String::new();
    file.read_to_string(&mut text).map_err(unreadable)?;
    Ok(text)
}

/// Refuses a socket that another user could have put there, who would then receive requests and
/// send replies. `genomd` follows the same rule.
pub(crate) fn place_of_socket(path: &Path) -> Result<(), Failure> {
    let directory = path.parent().filter(|directory| !directory.as_os_str().is_empty());
    let Ok(found) = std::fs::metadata(directory.unwrap_or(Path::new("."))) else {
        // There is no socket either; connecting to it will report that.
        return Ok(());
    };
    let ours = rustix::process::geteuid().as_raw();
    let socket = std::fs::symlink_metadata(path).ok().map(|socket| socket.uid());
    let Some(why) = distrust(ours, (found.uid(), found.mode()), socket) else { return Ok(()) };
    Err(Failure::usage(
        format!("{} is not used: {why}, who could answer as genomd", path.display()),
        "name the socket of your own daemon with --socket",
    ))
}

/// What is wrong with the owner and mode of a directory, or with the owner of a socket in it.
fn distrust(ours: u32, (owner, mode): (u32, u32), socket: Option<u32>) -> Option<&'static str> {
    let foreign = |uid: u32| uid != ours && uid != 0;
    if foreign(owner) {
        // Not even if it is sticky: the owner of the directory may replace files in it.
        Some("its directory belongs to another user")
    } else if mode & 0o002 != 0 && mode & 0o1000 == 0 {
        Some("others may put files into its directory")
    } else {
        socket.is_some_and(foreign).then_some("it belongs to another user")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sockets_are_trusted_where_nobody_else_can_put_one() {
        for (directory, socket) in [
            ((1000, 0o700), Some(1000)),
            ((1000, 0o775), Some(1000)),
            ((0, 0o755), Some(0)),
            ((0, 0o1777), Some(1000)),
            ((1000, 0o700), None),
        ] {
            assert_eq!(distrust(1000, directory, socket), None, "{directory:?} {socket:?}");
        }
        for (directory, socket) in [
            ((1001, 0o700), Some(1001)),
            ((1001, 0o1777), Some(1000)),
            ((1000, 0o777), Some(1000)),
            ((0, 0o1777), Some(1001)),
        ] {
            assert!(distrust(1000, directory, socket).is_some(), "{directory:?} {socket:?}");
        }
    }
}
