//! A file per daemon that lists what it offers, beside iceoryx2's own files:
//! `genom-UID/<prefix><node>`.
//!
//! One line announces a served service or a written port, another withdraws it. A reader of the
//! file reads what was appended since its last look, so nobody has to answer, and an offer holds no
//! file descriptor. Only its daemon writes the file, and removes it before its node. The file of a
//! killed daemon is ignored, and the next start of a daemon removes it.

use std::collections::{HashMap, HashSet};
use std::fs::{self, DirBuilder, File, OpenOptions};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};

use genom_middleware::{Endpoint, EndpointKind};
use iceoryx2::node::NodeState;
use iceoryx2::prelude::{CallbackProgression, Node};
use rustix::fs::OFlags;

use crate::raw::Ipc;

/// The file is rewritten when it has this many more withdrawn offers than current ones.
const GONE: usize = 256;

/// Greatest size of a file in bytes; more than any daemon needs.
const LONGEST: u64 = 64 << 20;

/// Kind of an offer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Kind {
    /// A service.
    Service,
    /// The writer of a port.
    Writer,
}

impl Kind {
    fn letter(self) -> char {
        match self {
            Self::Service => 's',
            Self::Writer => 'w',
        }
    }
}

/// Content of an announcing line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Offer {
    /// Digests of the types. Both sides must have the same ones.
    pub(crate) digests: String,
    /// Spelling of the type, for messages.
    pub(crate) spelling: String,
}

/// Offers of one daemon, by kind and address: `s demo/goto`.
type Offers = HashMap<String, Offer>;

fn key(kind: Kind, address: &str) -> String {
    format!("{} {address}", kind.letter())
}

/// Folder of the files, under iceoryx2's root.
fn folder(root: &Path) -> PathBuf {
    root.join(format!("genom-{}", rustix::process::geteuid().as_raw()))
}

/// The folder, and the prefix of the files' names.
fn place(node: &Node<Ipc>) -> (PathBuf, String) {
    let global = &node.config().global;
    (folder(Path::new(&global.root_path().to_string())), global.prefix.to_string())
}

/// The node whose file this is.
fn owner(file: &str, prefix: &str) -> Option<u128> {
    let digits = file.strip_prefix(prefix)?;
    (digits.len() == 32).then(|| u128::from_str_radix(digits, 16).ok()).flatten()
}

/// All files, with their nodes.
fn files(node: &Node<Ipc>) -> Vec<(u128, PathBuf)> {
    let (folder, prefix) = place(node);
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let named =
        |entry: fs::DirEntry| Some((owner(entry.file_name().to_str()?, &prefix)?, entry.path()));
    entries.filter_map(named).collect()
}

/// The nodes that are alive, or may be.
pub(crate) fn alive(node: &Node<Ipc>) -> Vec<u128> {
    let mut found = vec![node.id().value()];
    let _ = Node::<Ipc>::list(node.config(), |state| {
        if !matches!(state, NodeState::Dead(_)) {
            found.push(state.node_id().value());
        }
        CallbackProgression::Continue
    });
    found
}

/// All files of a root and prefix, with their nodes; includes files that are being rewritten.
pub(crate) fn list(root: &Path, prefix: &str) -> Vec<(u128, PathBuf)> {
    let entries = fs::read_dir(folder(root)).into_iter().flatten().flatten();
    let named = |entry: fs::DirEntry| {
        let name = entry.file_name();
        // The name of a file that is being rewritten has a suffix after the node.
        let node = owner(name.to_str()?.get(..prefix.len() + 32)?, prefix)?;
        Some((node, entry.path()))
    };
    entries.filter_map(named).collect()
}

/// Lists every service that living daemons serve, and every port that they write but that has no
/// iceoryx2 publisher yet.
pub(crate) fn listed(node: &Node<Ipc>, seen: &mut Vec<Endpoint>) {
    let alive = alive(node);
    let written: HashSet<String> = seen
        .iter()
        .filter(|end| end.kind == EndpointKind::Publisher)
        .map(|end| end.address.clone())
        .collect();
    for (_, path) in files(node).into_iter().filter(|(owner, _)| alive.contains(owner)) {
        let mut peer = Peer::default();
        peer.read(&path);
        for (key, offer) in peer.offers {
            let kind = match key.split_at_checked(2) {
                Some(("s ", _)) => EndpointKind::Service,
                Some(("w ", address)) if !written.contains(address) => EndpointKind::Publisher,
                _ => continue,
            };
            seen.push(Endpoint { kind, address: key[2..].to_owned(), ty: offer.spelling });
        }
    }
}

/// The catalog of this daemon.
pub(crate) struct Catalog {
    path: PathBuf,
    file: File,
    offers: Offers,
    gone: usize,
}

/// The catalog of this daemon could not be created or written.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CatalogError {
    #[error("cannot make {}: {source}", path.display())]
    Make { path: PathBuf, source: io::Error },
    #[error("cannot write {}: {source}", path.display())]
    Write { path: PathBuf, source: io::Error },
}

impl CatalogError {
    fn make(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        |source| Self::Make { path, source }
    }

    fn write(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        |source| Self::Write { path, source }
    }
}

fn create(path: &Path) -> Result<File, CatalogError> {
    let mut options = OpenOptions::new();
    options.append(true).create_new(true).mode(0o600);
    options.open(path).map_err(CatalogError::make(path))
}

fn added(key: &str, offer: &Offer) -> String {
    format!("+\t{key}\t{}\t{}\n", offer.digests, offer.spelling)
}

impl Catalog {
    /// Creates an empty catalog.
    pub(crate) fn create(node: &Node<Ipc>) -> Result<Self, CatalogError> {
        let (folder, prefix) = place(node);
        let made = DirBuilder::new().recursive(true).mode(0o700).create(&folder);
        made.map_err(CatalogError::make(&folder))?;
        let path = folder.join(format!("{prefix}{:032x}", node.id().value()));
        let file = create(&path)?;
        Ok(Self { path, file, offers: HashMap::new(), gone: 0 })
    }

    /// Announces an offer. Returns false if it was announced already.
    pub(crate) fn add(
        &mut self,
        kind: Kind,
        address: &str,
        offer: Offer,
    ) -> Result<bool, CatalogError> {
        let key = key(kind, address);
        if self.offers.contains_key(&key) {
            return Ok(false);
        }
        // Only shown to people, so it may be cut. It must not contain a line break.
        let spelling = offer.spelling.chars().take(120);
        let spelling = spelling.map(|c| if c.is_control() { ' ' } else { c }).collect();
        let offer = Offer { spelling, ..offer };
        self.write(&added(&key, &offer))?;
        self.offers.insert(key, offer);
        Ok(true)
    }

    /// Withdraws an offer.
    pub(crate) fn remove(&mut self, kind: Kind, address: &str) {
        let key = key(kind, address);
        if self.offers.remove(&key).is_none() {
            return;
        }
        self.gone += 1;
        let said = if self.gone > self.offers.len() + GONE {
            self.renew()
        } else {
            self.write(&format!("-\t{key}\n"))
        };
        if let Err(error) = said {
            tracing::warn!("{address} is still listed for others, though it is gone: {error}");
        }
    }

    fn write(&mut self, text: &str) -> Result<(), CatalogError> {
        self.file.write_all(text.as_bytes()).map_err(CatalogError::write(&self.path))
    }

    /// Replaces the file by one that has only the current offers.
    fn renew(&mut self) -> Result<(), CatalogError> {
        let mut new = self.path.clone().into_os_string();
        new.push(".new");
        let new = PathBuf::from(new);
        let _ = fs::remove_file(&new);
        let mut file = create(&new)?;
        let text: String = self.offers.iter().map(|(key, offer)| added(key, offer)).collect();
        let written = file.write_all(text.as_bytes()).and_then(|()| fs::rename(&new, &self.path));
        written.map_err(CatalogError::write(&new))?;
        (self.file, self.gone) = (file, 0);
        Ok(())
    }
}

impl Drop for Catalog {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}

/// The catalogs of all daemons, as far as they have been read.
#[derive(Default)]
pub(crate) struct Reader {
    peers: HashMap<u128, Peer>,
}

impl Reader {
    /// The daemons that offer this kind at an address, including killed ones.
    pub(crate) fn find(
        &mut self,
        node: &Node<Ipc>,
        kind: Kind,
        address: &str,
    ) -> Vec<(u128, Offer)> {
        let (files, key) = (files(node), key(kind, address));
        self.peers.retain(|owner, _| files.iter().any(|(other, _)| other == owner));
        let mut found = Vec::new();
        for (owner, path) in files {
            let peer = self.peers.entry(owner).or_default();
            peer.read(&path);
            found.extend(peer.offers.get(&key).map(|offer| (owner, offer.clone())));
        }
        found
    }

    /// Whether another living daemon offers it.
    pub(crate) fn is_of_others(&mut self, node: &Node<Ipc>, kind: Kind, address: &str) -> bool {
        let mut others = self.find(node, kind, address);
        others.retain(|(owner, _)| *owner != node.id().value());
        if others.is_empty() {
            return false;
        }
        let alive = alive(node);
        others.iter().any(|(owner, _)| alive.contains(owner))
    }
}

/// The catalog of one daemon, as far as it has been read.
#[derive(Default)]
struct Peer {
    inode: u64,
    read: u64,
    offers: Offers,
}

impl Peer {
    /// Reads what was appended. A file that cannot be read counts as empty.
    fn read(&mut self, path: &Path) {
        if self.try_read(path).is_none() {
            *self = Self::default();
        }
    }

    fn try_read(&mut self, path: &Path) -> Option<()> {
        let about = fs::symlink_metadata(path).ok()?;
        if about.ino() == self.inode && about.len() == self.read {
            return Some(());
        }
        // Do not follow links or block on a FIFO, whoever put it there.
        let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK;
        let mut options = OpenOptions::new();
        let options = options.read(true).custom_flags(flags.bits().cast_signed());
        let mut file = options.open(path).ok()?;
        let about = file.metadata().ok().filter(fs::Metadata::is_file)?;
        if about.ino() != self.inode || about.len() < self.read {
            *self = Self { inode: about.ino(), ..Self::default() };
        }
        let mut new = Vec::new();
        file.seek(SeekFrom::Start(self.read)).ok()?;
        file.take(LONGEST.checked_sub(self.read)?).read_to_end(&mut new).ok()?;
        // A last line without its line break is read next time.
        let whole = new.iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
        self.read += whole as u64;
        for line in String::from_utf8_lossy(new.get(..whole)?).lines() {
            let mut words = line.splitn(4, '\t');
            match (words.next(), words.next(), words.next(), words.next()) {
                (Some("+"), Some(key), Some(digests), Some(spelling)) => {
                    let (digests, spelling) = (digests.to_owned(), spelling.to_owned());
                    self.offers.insert(key.to_owned(), Offer { digests, spelling });
                }
                (Some("-"), Some(key), ..) => drop(self.offers.remove(key)),
                _ => {}
            }
        }
        Some(())
    }
}
