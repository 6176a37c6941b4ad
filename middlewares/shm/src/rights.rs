//! Ownership and permissions of files. Each user has a folder and a prefix that others can neither
//! read nor write: by truncating a segment they could end or block every process that has it
//! mapped.

use std::fs::{self, DirBuilder, Metadata, Permissions};
use std::io;
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};

use iceoryx2::prelude::Config;

use crate::error::ShmError;
use crate::heal::{Places, SEGMENTS};

/// Mode bits that let group or others change a folder.
const OTHERS_WRITE: u32 = 0o022;

/// Folder of this user's files: `/run/user/<uid>/genomd/iceoryx2`, or
/// `/dev/shm/genomd-<uid>/iceoryx2` if there is no `/run/user/<uid>`. Both are in memory: iceoryx2
/// synchronises each file that it creates, which takes milliseconds on a disk.
#[must_use]
pub fn default_root() -> PathBuf {
    let user = user();
    let run = PathBuf::from(format!("/run/user/{user}"));
    let base = if run.is_dir() {
        run.join("genomd")
    } else {
        PathBuf::from(format!("{SEGMENTS}/genomd-{user}"))
    };
    base.join("iceoryx2")
}

/// Prefix of this user's segments. It names the user because `/dev/shm` is shared by all.
#[must_use]
pub fn default_prefix() -> String {
    format!("genomd_{}_", user())
}

fn user() -> u32 {
    rustix::process::geteuid().as_raw()
}

/// Whether iceoryx2's configuration file sets the prefix or the root.
pub(crate) fn is_told(config: &Config) -> bool {
    let own = Config::default();
    config.global.prefix != own.global.prefix || config.global.root_path() != own.global.root_path()
}

/// Creates the folder. Refuses one that belongs to another user or that others may change.
pub(crate) fn prepare(places: &Places) -> Result<(), ShmError> {
    let folder = &places.root;
    let made = DirBuilder::new().recursive(true).mode(0o700).create(folder);
    made.map_err(|error| ShmError::Folder { path: folder.clone(), why: error.to_string() })?;
    // Includes the parent folders that belong to this user alone, such as `/dev/shm/genomd-<uid>`.
    let all = [&places.nodes, &places.services].into_iter().map(PathBuf::as_path);
    for path in all.chain([folder.as_path()]).chain(folder.parent()) {
        let Ok(told) = fs::symlink_metadata(path) else { continue };
        let above = Some(path) == folder.parent();
        if above && told.uid() != user() {
            // A shared folder such as `/dev/shm`, whose sticky bit protects each user's entries.
            continue;
        }
        own(path, &told)?;
        if told.mode() & OTHERS_WRITE != 0 && !above {
            return Err(ShmError::Open { path: path.to_owned(), mode: told.mode() & 0o7777 });
        }
    }
    for file in counters(places) {
        if let Ok(told) = fs::symlink_metadata(&file) {
            own(&file, &told)?;
        }
    }
    Ok(())
}

fn own(path: &Path, told: &Metadata) -> Result<(), ShmError> {
    if told.uid() == user() {
        return Ok(());
    }
    let (owner, mode) = (told.uid(), told.mode() & 0o7777);
    Err(ShmError::Foreign { path: path.to_owned(), owner, mode, user: user() })
}

/// Removes the permissions of others from the node counter, which iceoryx2 makes writable for
/// everybody because it expects one per machine. Ours is per user.
pub(crate) fn close(places: &Places) -> io::Result<()> {
    for file in counters(places) {
        fs::set_permissions(file, Permissions::from_mode(0o600))?;
    }
    Ok(())
}

fn counters(places: &Places) -> Vec<PathBuf> {
    crate::heal::counters(places)
}
