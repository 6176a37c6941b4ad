//! Private copies of library files: each load uses its own file, so that a rebuilt library is
//! loaded anew and components never share symbols or static variables. Other users can neither
//! write nor exchange it between the check and the load.

use std::fs::{self, File, OpenOptions, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::{OpenOptionsExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};

use tempfile::TempDir;

/// Prefix of the directories of copies in the temporary directory.
const PREFIX: &str = "genomd-library-";
/// File that is locked as long as the process that made the directory lives.
const LOCK: &str = "lock";

/// A copy of a library in this process's own directory; removed when it is dropped.
#[derive(Debug)]
pub(super) struct PrivateCopy {
    path: PathBuf,
    _shelf: Arc<Shelf>,
}

/// The directory of this process's copies, which exists as long as one of them does.
#[derive(Debug)]
struct Shelf {
    path: PathBuf,
    _lock: File,
    _directory: TempDir,
}

impl Shelf {
    /// The directory; all copies share one lock, and one search for what dead processes left.
    fn get() -> io::Result<Arc<Self>> {
        static SHELF: Mutex<Weak<Shelf>> = Mutex::new(Weak::new());
        let mut known = SHELF.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(shelf) = known.upgrade().filter(|shelf| shelf.path.is_dir()) {
            return Ok(shelf);
        }
        sweep(&std::env::temp_dir());
        // For this user alone, whatever the umask: nobody else can exchange what was checked.
        let own = Permissions::from_mode(0o700);
        let directory = tempfile::Builder::new().prefix(PREFIX).permissions(own).tempdir()?;
        // The lock gets its name only once it is held; otherwise another process's sweep could take
        // it.
        let early = directory.path().join("lock.new");
        let lock = File::create(&early)?;
        lock.lock()?;
        fs::rename(&early, directory.path().join(LOCK))?;
        let path = directory.path().canonicalize()?;
        let shelf = Arc::new(Self { path, _lock: lock, _directory: directory });
        *known = Arc::downgrade(&shelf);
        Ok(shelf)
    }
}

impl PrivateCopy {
    /// Writes `bytes` to a new file whose name contains that of `original`.
    pub(super) fn new(original: &Path, bytes: &[u8]) -> io::Result<Self> {
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        let shelf = Shelf::get()?;
        let name = original.file_name().unwrap_or("library.so".as_ref()).to_string_lossy();
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path = shelf.path.join(format!("{number}-{name}"));
        // Made before the file is written, so that an incomplete copy is removed as well.
        let copy = Self { path, _shelf: shelf };
        let mut file =
            OpenOptions::new().write(true).create_new(true).mode(0o400).open(&copy.path)?;
        file.write_all(bytes)?;
        Ok(copy)
    }

    /// The file to load.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for PrivateCopy {
    fn drop(&mut self) {
        if let Err(why) = fs::remove_file(&self.path) {
            tracing::debug!("{}: a copy of a library stays: {why}", self.path.display());
        }
    }
}

/// Removes the copies in `directory` whose process was killed.
fn sweep(directory: &Path) {
    let Ok(entries) = fs::read_dir(directory) else { return };
    for entry in entries.flatten() {
        let stale = entry.file_name().to_string_lossy().starts_with(PREFIX)
            && File::open(entry.path().join(LOCK)).is_ok_and(|lock| lock.try_lock().is_ok());
        if stale && let Err(why) = fs::remove_dir_all(entry.path()) {
            tracing::debug!("{}: stale copy of a library stays: {why}", entry.path().display());
        }
    }
}

/// Writes `bytes` beside `original`, passes the file's path to `load`, and removes the file.
///
/// For libraries that look for others relative to their own directory (`$ORIGIN`). The mapping
/// stays valid after the file is removed.
pub(super) fn beside<T>(
    original: &Path,
    bytes: &[u8],
    load: impl FnOnce(&Path) -> T,
) -> io::Result<T> {
    let directory = original.parent().filter(|parent| !parent.as_os_str().is_empty());
    let name = original.file_name().unwrap_or("library.so".as_ref()).to_string_lossy();
    let mut file = tempfile::Builder::new()
        .prefix(&format!(".{name}.genomd-"))
        .tempfile_in(directory.unwrap_or(Path::new(".")))?;
    file.write_all(bytes)?;
    // Closed for writing first: the kernel may refuse to execute a file that is open for writing.
    let path = file.into_temp_path();
    let absolute = path.canonicalize()?;
    Ok(load(&absolute))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_copies_are_in_one_directory_that_goes_with_the_last() {
        let original = Path::new("somewhere/demo.so");
        let copies: Vec<_> = (0_u8..3).map(|n| PrivateCopy::new(original, &[n]).unwrap()).collect();
        let directory = copies[0].path().parent().unwrap().to_owned();
        for (n, copy) in (0_u8..).zip(&copies) {
            assert_eq!(copy.path().parent(), Some(&*directory));
            assert!(copy.path().to_string_lossy().ends_with("-demo.so"));
            assert_eq!(fs::read(copy.path()).unwrap(), [n]);
        }
        let first = copies[0].path().to_owned();
        let mut copies = copies.into_iter();
        drop(copies.next());
        assert!(!first.exists() && directory.join(LOCK).exists());
    }

    #[test]
    fn nobody_else_can_write_to_a_copy_or_put_another_in_its_place() {
        let copy = PrivateCopy::new(Path::new("somewhere/own.so"), b"checked").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o7777;
        assert_eq!(mode(copy.path()), 0o400);
        assert_eq!(mode(copy.path().parent().unwrap()), 0o700);
        let scratch = TempDir::new().unwrap();
        let original = scratch.path().join("beside.so");
        let of_beside = beside(&original, b"checked", |path| mode(path)).unwrap();
        assert_eq!(of_beside, 0o600);
    }

    #[test]
    fn a_sweep_removes_what_a_killed_daemon_left_and_keeps_what_is_in_use() {
        let scratch = TempDir::new().unwrap();
        let stale = scratch.path().join(format!("{PREFIX}stale"));
        let used = scratch.path().join(format!("{PREFIX}used"));
        let young = scratch.path().join(format!("{PREFIX}young"));
        for directory in [&stale, &used, &young] {
            fs::create_dir(directory).unwrap();
        }
        File::create(stale.join(LOCK)).unwrap();
        let held = File::create(used.join(LOCK)).unwrap();
        held.lock().unwrap();

        sweep(scratch.path());

        assert!(!stale.exists());
        assert!(used.exists());
        assert!(young.exists(), "a directory without lock is being made");
    }
}
