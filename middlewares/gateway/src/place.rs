//! Where gateways of a daemon are found, from the path of the daemon's socket.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// What names of cells that are gateways begin with.
const PREFIX: &str = "gateway-";

/// Name of the cell that is the gateway of a middleware.
#[must_use]
pub fn cell_of(middleware: &str) -> String {
    format!("{PREFIX}{middleware}")
}

/// The middleware whose gateway a cell of this name is, if it is one.
#[must_use]
pub fn middleware_of(cell: &str) -> Option<&str> {
    cell.strip_prefix(PREFIX)
}

/// Where the gateways of one daemon are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reach {
    daemon: PathBuf,
}

impl Reach {
    /// The gateways of the daemon with this socket.
    #[must_use]
    pub fn new(daemon: &Path) -> Self {
        Self { daemon: daemon.to_owned() }
    }

    fn beside(&self, ending: &str) -> PathBuf {
        let mut path = OsString::from(self.daemon.as_os_str());
        path.push(ending);
        path.into()
    }

    /// The door of the daemon at which it is asked to start a gateway: whoever knocks sends a line
    /// with the name of the middleware, and reads why there is no gateway, or nothing when there is
    /// one.
    #[must_use]
    pub fn bell(&self) -> PathBuf {
        self.directory().join("bell")
    }

    /// The door of a gateway, in a directory of its own.
    #[must_use]
    pub fn door(&self, middleware: &str) -> PathBuf {
        self.directory().join(middleware).join("door")
    }

    /// The directory with all these doors in it.
    #[must_use]
    pub fn directory(&self) -> PathBuf {
        self.beside(".gateways")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gateways_are_found_from_the_socket_of_their_daemon() {
        let reach = Reach::new(Path::new("/run/genomd.sock"));
        assert_eq!(reach.bell(), Path::new("/run/genomd.sock.gateways/bell"));
        let door = Path::new("/run/genomd.sock.gateways/ros2/door");
        assert_eq!(reach.door("ros2"), door);
        assert!(door.starts_with(reach.directory()));
        assert_eq!(middleware_of(&cell_of("ros2")), Some("ros2"));
        assert_eq!(middleware_of("arm"), None);
    }
}
