//! Where the cells of a daemon keep their files: a directory beside the daemon's socket.
//!
//! `SOCKET.cells/NAME/` holds `socket` (its control plane), `config.toml` (how it is to run),
//! `journal.toml` (what it is to hold), `note` (what it tells when it crashes) and `pid`; of a cell in a sandbox, `tmp`, too, and
//! `NAME.libraries` stands beside it. Only the daemon's user can enter it.

use std::ffi::{OsStr, OsString};
use std::fs::{self, DirBuilder};
use std::io::{self, Read as _};
use std::os::unix::ffi::{OsStrExt as _, OsStringExt as _};
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _};
use std::path::{Path, PathBuf};

use genom_gateway::Reach;
use genom_protocol::Change;
use serde_json::Value;

use crate::theirs;

/// Longest path of a Unix socket, in bytes (`sun_path`, with its final 0).
const LONGEST: usize = 107;

/// File in which a cell writes why it does not start.
const REFUSAL: &str = "refusal";

/// The directory of one cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place(PathBuf);

/// No directory for a cell.
#[derive(Debug, thiserror::Error)]
pub enum PlaceError {
    /// The name cannot stand in a path, or in messages.
    #[error("`{0}` is no name of a cell: up to 32 letters, digits, `_` and `-`, a letter first")]
    Name(String),
    /// The name of a gateway.
    #[error("`{0}` is a name of a gateway: give the cell another one")]
    Gateway(String),
    /// The socket would have a longer path than the system takes.
    #[error("{} is too long for a socket: give the daemon a shorter --socket", .0.display())]
    Long(PathBuf),
    /// Others could put files there.
    #[error("{} belongs to another user, or others may enter it", .0.display())]
    Foreign(PathBuf),
    /// The system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// What was to be made.
        path: PathBuf,
        /// Its own words.
        source: io::Error,
    },
}

/// The directory of all cells of the daemon that listens on this socket.
#[must_use]
pub fn of_all(socket: &Path) -> PathBuf {
    let mut name = socket.as_os_str().to_owned();
    name.push(".cells");
    name.into()
}

/// Makes a directory for this user alone.
pub(crate) fn make(path: impl AsRef<Path>) -> Result<(), PlaceError> {
    let path = path.as_ref();
    let failed = |source| PlaceError::Io { path: path.to_owned(), source };
    DirBuilder::new().recursive(true).mode(0o700).create(path).map_err(failed)?;
    let found = fs::symlink_metadata(path).map_err(failed)?;
    let ours = found.uid() == rustix::process::geteuid().as_raw();
    if found.is_dir() && ours && found.mode() & 0o077 == 0 {
        Ok(())
    } else {
        Err(PlaceError::Foreign(path.to_owned()))
    }
}

impl Place {
    /// The place of a cell; nothing is made yet.
    ///
    /// # Errors
    /// The name is none, or its socket's path would be too long.
    pub fn new(all: &Path, name: &str) -> Result<Self, PlaceError> {
        let fine = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        let begins = name.starts_with(|first: char| first.is_ascii_alphabetic());
        if !begins || name.len() > 32 || !name.chars().all(fine) {
            return Err(PlaceError::Name(name.to_owned()));
        }
        let place = Self(all.join(name));
        match place.socket() {
            // A socket is made under a longer name first, and renamed.
            socket if socket.as_os_str().len() + 11 > LONGEST => Err(PlaceError::Long(socket)),
            _ => Ok(place),
        }
    }

    /// The place that holds a cell's configuration: how the cell itself finds it.
    pub(crate) fn of_config(config: &Path) -> Self {
        Self(config.parent().unwrap_or(Path::new(".")).to_owned())
    }

    /// Those that are there, whether their cells live or not.
    #[must_use]
    pub fn found(all: &Path) -> Vec<(String, Self)> {
        let entries = fs::read_dir(all).into_iter().flatten().flatten();
        let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
        let mut found: Vec<_> =
            names.filter_map(|name| Some((name.clone(), Self::new(all, &name).ok()?))).collect();
        found.sort_by(|one, other| one.0.cmp(&other.0));
        found
    }

    /// Makes the directory, for this user alone.
    ///
    /// # Errors
    /// The system refuses, or somebody else made it before.
    pub fn make(&self) -> Result<(), PlaceError> {
        self.0.parent().into_iter().chain([self.0.as_path()]).try_for_each(make)
    }

    /// Where is kept what components ran before a reload.
    #[must_use]
    pub fn trials(&self) -> PathBuf {
        self.0.join("trials")
    }

    /// Removes it with all that is in it, and the directory of all cells when it was the last.
    pub fn remove(&self) {
        if let Err(error) = fs::remove_dir_all(&self.0)
            && error.kind() != io::ErrorKind::NotFound
        {
            tracing::warn!("{} stays behind: {error}", self.0.display());
        }
        let _ = fs::remove_file(self.libraries());
        let _ = fs::remove_file(self.runner_file());
        // Refused as long as another cell has its own there.
        let _ = self.0.parent().map(fs::remove_dir);
    }

    /// The socket of its control plane.
    #[must_use]
    pub fn socket(&self) -> PathBuf {
        self.0.join("socket")
    }

    /// Name of the cell.
    pub(crate) fn name(&self) -> Option<&str> {
        self.0.file_name()?.to_str()
    }

    /// How it is to run.
    #[must_use]
    pub fn config(&self) -> PathBuf {
        self.0.join("config.toml")
    }

    /// Of a gateway: where those who use it knock.
    pub(crate) fn door(&self) -> Option<PathBuf> {
        let middleware = genom_gateway::middleware_of(self.name()?)?;
        // Beside the directory of all cells, by the daemon's socket.
        Some(Reach::new(&self.0.parent()?.with_extension("")).door(middleware))
    }

    /// What it is to hold.
    #[must_use]
    pub fn journal(&self) -> PathBuf {
        self.0.join("journal.toml")
    }

    /// Why it does not run, when it refuses to.
    pub(crate) fn refusal(&self) -> PathBuf {
        self.0.join(REFUSAL)
    }

    /// What its process tells when it crashes.
    #[must_use]
    pub fn note(&self) -> PathBuf {
        self.0.join("note")
    }

    /// What of its limits does not hold, as it was told.
    pub(crate) fn told(&self) -> PathBuf {
        self.0.join("limits-told")
    }

    /// Its directory.
    #[must_use]
    pub fn directory(&self) -> &Path {
        &self.0
    }

    /// Where a cell in a sandbox keeps its temporary files.
    #[must_use]
    pub fn temporary(&self) -> PathBuf {
        self.0.join("tmp")
    }

    /// The directories of its libraries, for a cell in a sandbox: one a line. It stands beside the
    /// directory, where the cell itself cannot write.
    #[must_use]
    pub fn libraries(&self) -> PathBuf {
        self.0.with_extension("libraries")
    }

    /// The words of the command of the runner that its process is to be, if its codels are scripts. The
    /// file stands beside the directory, where the cell itself cannot write.
    pub(crate) fn runner(&self) -> Option<Vec<OsString>> {
        let words = fs::read(self.runner_file()).ok().filter(|words| !words.is_empty())?;
        Some(words.split(|byte| *byte == 0).map(|word| OsString::from_vec(word.to_vec())).collect())
    }

    /// Says which runner its process is to be, from its next start on.
    pub(crate) fn set_runner(&self, words: &[String]) -> io::Result<()> {
        fs::write(self.runner_file(), words.join("\0"))
    }

    fn runner_file(&self) -> PathBuf {
        self.0.with_extension("runner")
    }

    /// Lets a cell in a sandbox read this directory, from its next start on.
    ///
    /// # Errors
    /// The system refuses.
    pub fn grant(&self, directory: &Path) -> io::Result<()> {
        let mut all = self.granted();
        if all.iter().any(|known| known == directory) {
            return Ok(());
        }
        all.push(directory.to_owned());
        let lines: Vec<&[u8]> = all.iter().map(|path| path.as_os_str().as_bytes()).collect();
        fs::write(self.libraries(), lines.join(&b'\n'))
    }

    /// The directories of its libraries.
    #[must_use]
    pub fn granted(&self) -> Vec<PathBuf> {
        let text = fs::read(self.libraries()).unwrap_or_default();
        let lines = text.split(|byte| *byte == b'\n').filter(|line| !line.is_empty());
        lines.map(|line| PathBuf::from(OsStr::from_bytes(line))).collect()
    }

    /// Why its process did not start, in its own words; told once.
    pub(crate) fn taken_refusal(&self) -> Option<String> {
        taken(&self.refusal())
    }

    /// Writes down, for the daemon, why a cell ends itself: a rule of its supervision was broken.
    pub(crate) fn write_broken_rule(&self, violation: &Change, why: &str) -> io::Result<()> {
        let event = serde_json::to_string(violation).map_err(io::Error::other)?;
        let text = format!("{}\n{event}", why.replace('\n', " "));
        theirs::write(&self.broken_rule(), text.as_bytes())
    }

    /// What it wrote there: why, and the event that tells the violation. The file is removed.
    pub(crate) fn taken_broken_rule(&self) -> Option<(String, Value)> {
        let text = taken(&self.broken_rule())?;
        let (why, event) = text.split_once('\n').unwrap_or((&text, ""));
        Some((why.to_owned(), serde_json::from_str(event).unwrap_or_default()))
    }

    fn broken_rule(&self) -> PathBuf {
        self.0.join("broken-rule")
    }

    /// The number of its process.
    #[must_use]
    pub fn pid(&self) -> PathBuf {
        self.0.join("pid")
    }
}

/// Most of what is read of a text that a cell wrote, in bytes.
const MOST: u64 = 4096;

/// What a cell wrote into a file, which is removed. A cell in a sandbox may have put anything in its
/// place: what is no file is not read.
fn taken(file: &Path) -> Option<String> {
    let mut text = Vec::new();
    let opened = theirs::open(file);
    let _ = fs::remove_file(file);
    opened.ok()?.take(MOST).read_to_end(&mut text).ok()?;
    let text = String::from_utf8_lossy(&text);
    Some(text.chars().map(|c| if c.is_control() && c != '\n' { ' ' } else { c }).collect())
}

#[cfg(test)]
mod tests {
    #[test]
    fn what_a_cell_put_in_place_of_a_text_is_not_read() {
        let scratch = tempfile::tempdir().unwrap();
        let place = Place(scratch.path().to_owned());
        let told = Change::Stopping {};
        place.write_broken_rule(&told, "a\nb").unwrap();
        let (why, event) = place.taken_broken_rule().unwrap();
        assert_eq!((why.as_str(), event["event"].as_str()), ("a b", Some("stopping")));
        assert_eq!(place.taken_broken_rule(), None);
        fs::write(scratch.path().join("secret"), "secret").unwrap();
        for put in ["symlink", "fifo", "directory"] {
            let at = place.broken_rule();
            match put {
                "symlink" => std::os::unix::fs::symlink("secret", &at).unwrap(),
                "fifo" => {
                    let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
                    let kind = rustix::fs::FileType::Fifo;
                    rustix::fs::mknodat(rustix::fs::CWD, &at, kind, mode, 0).unwrap();
                }
                _ => fs::create_dir(&at).unwrap(),
            }
            assert_eq!(place.taken_broken_rule(), None, "{put}");
        }
        fs::remove_dir(place.broken_rule()).unwrap();
        fs::write(place.broken_rule(), vec![b'x'; 1 << 20]).unwrap();
        assert_eq!(place.taken_broken_rule().unwrap().0.len(), 4096);
    }

    use std::os::unix::fs::PermissionsExt as _;

    use super::*;

    #[test]
    fn a_name_that_leaves_the_directory_is_refused() {
        let all = Path::new("/run/genomd.sock.cells");
        for name in ["", "..", "a/b", "-x", "a b", "é", &"x".repeat(33)] {
            assert!(matches!(Place::new(all, name), Err(PlaceError::Name(_))), "{name}");
        }
        let place = Place::new(all, "vision-2").unwrap();
        assert_eq!(place.socket(), Path::new("/run/genomd.sock.cells/vision-2/socket"));
        let deep = PathBuf::from(format!("/{}", "d/".repeat(50)));
        assert!(matches!(Place::new(&deep, "vision"), Err(PlaceError::Long(_))));
    }

    #[test]
    fn a_directory_that_others_may_enter_is_refused() {
        let scratch = tempfile::tempdir().unwrap();
        let all = of_all(&scratch.path().join("s"));
        let place = Place::new(&all, "arm").unwrap();
        place.make().unwrap();
        assert_eq!(Place::found(&all), [("arm".to_owned(), place.clone())]);
        fs::set_permissions(&all, fs::Permissions::from_mode(0o755)).unwrap();
        assert!(matches!(place.make(), Err(PlaceError::Foreign(_))));
        fs::set_permissions(&all, fs::Permissions::from_mode(0o700)).unwrap();
        place.remove();
        assert!(!all.exists());
    }
}
