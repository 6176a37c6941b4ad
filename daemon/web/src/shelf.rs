//! The file in which sessions outlive the daemon, so that open pages go on with the next one.
//!
//! It has mode 0600, and is in the directory of the control plane's socket, which is private. It
//! holds digests of what browsers have, not the secrets themselves.

use std::fs::{self, OpenOptions};
use std::io::{self, Write as _};
use std::net::SocketAddr;
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};

use genom_proof::Bytes;
use serde::{Deserialize, Serialize};

use crate::visitor::Visitor;

/// What is in the file.
#[derive(Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Kept {
    /// Address of the console.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) address: Option<SocketAddr>,
    /// The sessions.
    #[serde(default)]
    pub(crate) sessions: Vec<KeptSession>,
}

/// A session in the file.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct KeptSession {
    /// Digest of the cookie.
    pub(crate) digest: Bytes<32>,
    /// Whose it is.
    pub(crate) visitor: Visitor,
    /// When it ends, in seconds since 1970.
    pub(crate) until: u64,
}

/// The file.
#[derive(Debug)]
pub(crate) struct Shelf(PathBuf);

impl Shelf {
    /// The file beside this socket.
    pub(crate) fn beside(socket: &Path) -> Self {
        let mut path = socket.as_os_str().to_owned();
        path.push(".web");
        Self(path.into())
    }

    /// What the daemon before this one left. A file that another user wrote, or that cannot be
    /// read, counts as empty.
    pub(crate) fn read(&self) -> Kept {
        let ours = rustix::process::geteuid().as_raw();
        let private = |found: &fs::Metadata| {
            found.is_file() && found.uid() == ours && found.mode() & 0o077 == 0
        };
        match fs::symlink_metadata(&self.0) {
            Ok(found) if private(&found) => {}
            _ => return Kept::default(),
        }
        let text = fs::read_to_string(&self.0).unwrap_or_default();
        serde_json::from_str(&text).unwrap_or_default()
    }

    /// Writes the file anew.
    pub(crate) fn write(&self, kept: &Kept) -> io::Result<()> {
        let mut aside = self.0.clone().into_os_string();
        aside.push(".new");
        // What is there was left by a daemon that ended while it wrote.
        let _ = fs::remove_file(&aside);
        let mut file = OpenOptions::new().create_new(true).write(true).mode(0o600).open(&aside)?;
        file.write_all(&serde_json::to_vec(kept)?)?;
        fs::rename(&aside, &self.0)
    }
}
