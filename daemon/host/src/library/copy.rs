//! Private copies of library files: one file a load, so that a rebuilt library loads anew and two
//! components never share symbols or static variables.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Once;

use tempfile::TempDir;

/// Directories of copies begin so, within the temporary directory.
const PREFIX: &str = "genomd-library-";
/// Locked as long as the process that made the directory lives.
const LOCK: &str = "lock";

/// A copy of a library in a directory of its own; both go when it is dropped.
#[derive(Debug)]
pub(super) struct PrivateCopy {
    path: PathBuf,
    _lock: File,
    _directory: TempDir,
}

impl PrivateCopy {
    /// Writes `bytes` under the name of `original` into a new private directory.
    pub(super) fn new(original: &Path, bytes: &[u8]) -> io::Result<Self> {
        static SWEEP: Once = Once::new();
        SWEEP.call_once(|| sweep(&std::env::temp_dir()));
        let directory = tempfile::Builder::new().prefix(PREFIX).tempdir()?;
        // The lock takes its name only once it is held, or a sweep could come in between.
        let early = directory.path().join("lock.new");
        let lock = File::create(&early)?;
        lock.lock()?;
        fs::rename(&early, directory.path().join(LOCK))?;
        let name = original.file_name().unwrap_or("library.so".as_ref());
        let path = directory.path().canonicalize()?.join(name);
        fs::write(&path, bytes)?;
        Ok(Self { path, _lock: lock, _directory: directory })
    }

    /// The file to load.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }
}

/// Removes the copies that a killed daemon left behind in `directory`.
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

/// Writes `bytes` beside `original`, hands the file's path to `load`, and removes the file.
///
/// For libraries that look for others relative to their own place (`$ORIGIN`). The mapped
/// file lives on without its name.
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
    // Closed for writing, or the kernel may refuse to map it for execution.
    let path = file.into_temp_path();
    let absolute = path.canonicalize()?;
    Ok(load(&absolute))
}

#[cfg(test)]
mod tests {
    use super::*;

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
