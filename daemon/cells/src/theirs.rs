//! Files in the directory of a cell. Its process may write there, also in a sandbox: in place of any
//! of them it can put a link to a file of the user, a pipe that nobody writes to, or a file without
//! end. The daemon neither follows a link there, nor waits, nor reads more than it expects.

use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::os::fd::AsRawFd as _;
use std::os::unix::fs::{FileTypeExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};

use rustix::fs::OFlags;

use crate::shelf;

/// Opens a regular file, if it is none of the others.
pub(crate) fn open(path: &Path) -> io::Result<File> {
    let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK;
    let file = OpenOptions::new().read(true).custom_flags(flags.bits().cast_signed()).open(path)?;
    match file.metadata()?.is_file() {
        true => Ok(file),
        false => Err(io::Error::new(ErrorKind::InvalidInput, "it is no regular file")),
    }
}

/// Reads a text of so many bytes at most; a longer one is refused.
pub(crate) fn read(path: &Path, most: u64) -> io::Result<String> {
    let mut text = String::new();
    open(path)?.take(most.saturating_add(1)).read_to_string(&mut text)?;
    match text.len() as u64 > most {
        true => Err(io::Error::new(ErrorKind::FileTooLarge, format!("it has over {most} bytes"))),
        false => Ok(text),
    }
}

/// Replaces a file as a whole, readable by this user only: what was in its place is not written to.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut aside = path.as_os_str().to_owned();
    aside.push(".new");
    let aside = PathBuf::from(aside);
    create(&aside)?.write_all(bytes)?;
    fs::rename(&aside, path)
}

/// Makes a file, readable by this user only, in place of what is there.
pub(crate) fn create(path: &Path) -> io::Result<File> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => shelf::create(path),
    }
}

/// Where to connect to a socket that is no link: the path holds as long as the file is kept.
pub(crate) fn socket(path: &Path) -> io::Result<(File, PathBuf)> {
    let flags = OFlags::NOFOLLOW | OFlags::PATH;
    let file = OpenOptions::new().read(true).custom_flags(flags.bits().cast_signed()).open(path)?;
    if !file.metadata()?.file_type().is_socket() {
        return Err(io::Error::new(ErrorKind::InvalidInput, "it is no socket"));
    }
    let path = PathBuf::from(format!("/proc/self/fd/{}", file.as_raw_fd()));
    Ok((file, path))
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::{PermissionsExt as _, symlink};
    use std::os::unix::net::{UnixListener, UnixStream};

    use rustix::fs::{CWD, FileType, Mode, mknodat};

    use super::*;

    #[test]
    fn what_is_in_place_of_a_file_is_neither_read_nor_waited_for_nor_written_to() {
        let scratch = tempfile::tempdir().unwrap();
        let at = |name: &str| scratch.path().join(name);
        fs::write(at("secret"), "secret").unwrap();
        symlink(at("secret"), at("link")).unwrap();
        mknodat(CWD, at("pipe"), FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        let _listener = UnixListener::bind(at("socket")).unwrap();
        fs::create_dir(at("directory")).unwrap();
        for name in ["link", "pipe", "socket", "directory"] {
            assert!(read(&at(name), 100).is_err(), "{name}");
        }
        for name in ["link", "pipe", "socket", "new"] {
            // Also where the file beside it is prepared.
            let aside = at(&format!("{name}.new"));
            symlink(at("secret"), &aside).unwrap();
            write(&at(name), b"mine").unwrap();
            assert_eq!(read(&at(name), 100).unwrap(), "mine", "{name}");
            let mode = fs::symlink_metadata(at(name)).unwrap().permissions().mode();
            assert_eq!(mode & 0o777, 0o600, "{name}");
        }
        assert!(write(&at("directory"), b"mine").is_err());
        assert_eq!(fs::read(at("secret")).unwrap(), b"secret");
    }

    #[test]
    fn a_text_that_is_too_long_is_refused() {
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("text");
        write(&path, &[b'x'; 100]).unwrap();
        assert_eq!(read(&path, 100).unwrap().len(), 100);
        assert_eq!(read(&path, 99).unwrap_err().kind(), ErrorKind::FileTooLarge);
        assert!(read(Path::new("/dev/zero"), 100).is_err());
    }

    #[test]
    fn a_socket_is_reached_unless_a_link_leads_to_it() {
        let scratch = tempfile::tempdir().unwrap();
        let at = |name: &str| scratch.path().join(name);
        let _listener = UnixListener::bind(at("socket")).unwrap();
        symlink(at("socket"), at("link")).unwrap();
        fs::write(at("file"), "").unwrap();
        let (_held, path) = socket(&at("socket")).unwrap();
        UnixStream::connect(path).unwrap();
        assert!(socket(&at("link")).is_err() && socket(&at("file")).is_err());
        assert_eq!(socket(&at("none")).unwrap_err().kind(), ErrorKind::NotFound);
    }
}
