//! Who steps this daemon, at the other end of a socket: the program that started it; of a cell, the
//! daemon of such a program.

use std::fs::File;
use std::io;
use std::os::fd::{BorrowedFd, OwnedFd};
use std::sync::Arc;
use std::thread;

use genom_cells::Cells;
use genom_host::keep_from_children;
use genom_supervisor::Supervisor;
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::{Errno, fcntl_dupfd_cloexec};
use rustix::net::{AddressFamily, SocketAddrAny, SocketType, getpeername, getsockname, sockopt};
use rustix::process::{Pid, getppid};
use rustix::stdio::{dup2_stdin, stdin};
use tokio::runtime::Handle;

use crate::session::Session;
use crate::who::Who;

/// Length of the address of a socket without a name: its family only.
const UNNAMED: u32 = size_of::<u16>() as u32;

/// The program that this daemon is a part of; of a cell, its daemon.
#[derive(Debug)]
pub struct Program {
    socket: Arc<OwnedFd>,
    who: Who,
}

/// Why there is none.
#[derive(Debug, thiserror::Error)]
pub enum NoProgram {
    /// The standard input is something else.
    #[error(
        "--embedded is for programs that start genomd, with one end of a pair of sockets \
         (AF_UNIX, SOCK_SEQPACKET) as its standard input: genom.Daemon in Python does it"
    )]
    Other,
    /// The system refuses.
    #[error("--embedded: {0}")]
    Io(#[from] io::Error),
}

impl From<Errno> for NoProgram {
    fn from(error: Errno) -> Self {
        Self::Io(error.into())
    }
}

impl Program {
    /// Takes the standard input, which the program holds open as long as it wants the daemon; codels
    /// get none. To be called before there are other threads.
    ///
    /// # Errors
    /// The standard input is no such socket.
    pub fn take() -> Result<Self, NoProgram> {
        let given = stdin();
        let domain = sockopt::socket_domain(given).map_err(|_| NoProgram::Other)?;
        let kind = sockopt::socket_type(given)?;
        if (domain, kind) != (AddressFamily::UNIX, SocketType::SEQPACKET) || !is_of_pair(given) {
            return Err(NoProgram::Other);
        }
        let socket = fcntl_dupfd_cloexec(given, 3)?;
        keep_from_children(&socket);
        dup2_stdin(File::open("/dev/null")?)?;
        Ok(Self { socket: Arc::new(socket), who: Who::Program })
    }

    /// The daemon of this cell, which lent it this end of a socket.
    #[must_use]
    pub fn of_daemon(socket: OwnedFd) -> Self {
        Self { socket: Arc::new(socket), who: Who::Daemon }
    }

    /// Stops the daemon when the program has closed its end, or ended, whatever codels do then. What
    /// becomes of a cell without daemon is said elsewhere.
    ///
    /// # Errors
    /// No thread can be started.
    pub fn watch(&self, supervisor: &Arc<Supervisor>) -> io::Result<()> {
        if self.who == Who::Daemon {
            return Ok(());
        }
        let process = Pid::as_raw(getppid());
        tracing::info!("process {process}, which started this daemon, steps its clock");
        let (socket, supervisor) = (Arc::clone(&self.socket), Arc::downgrade(supervisor));
        let watching = move || {
            let mut end = [PollFd::new(&*socket, PollFlags::empty())];
            while poll(&mut end, None) == Err(Errno::INTR) {}
            if let Some(supervisor) = supervisor.upgrade() {
                supervisor
                    .ask_to_stop("the program that started this daemon has closed its socket");
            }
        };
        thread::Builder::new().name("genomd-program".to_owned()).spawn(watching)?;
        Ok(())
    }

    /// Does what it asks, in a thread of its own, in which codels run.
    ///
    /// # Errors
    /// No thread can be started.
    pub fn serve(
        &self,
        supervisor: &Arc<Supervisor>,
        cells: &Arc<Cells>,
        runtime: Handle,
    ) -> io::Result<()> {
        let session = Session::new((&self.socket, self.who), supervisor, cells, runtime);
        thread::Builder::new().name("genomd-steps".to_owned()).spawn(move || session.run())?;
        Ok(())
    }
}

/// Whether neither end has a name: both were made as a pair, so that nobody connected to it.
fn is_of_pair(socket: BorrowedFd<'_>) -> bool {
    let unnamed = |end: SocketAddrAny| end.addr_len() <= UNNAMED;
    getsockname(socket).is_ok_and(unnamed)
        && getpeername(socket).is_ok_and(|peer| peer.is_none_or(unnamed))
}
