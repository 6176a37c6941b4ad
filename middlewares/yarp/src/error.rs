//! Errors of opening the middleware and of asking the name server.

use std::io;
use std::path::PathBuf;
use std::time::Duration;

/// Name of this middleware in configurations and errors.
pub(crate) const BACKEND: &str = "yarp";

/// The middleware could not be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum YarpError {
    /// The name server's address is not of the form that is needed.
    #[error("`server = {0:?}` is no address: write HOST:PORT, such as \"127.0.0.1:10000\"")]
    Server(String),
    /// The address to listen at is not of the form that is needed.
    #[error("`listen = {0:?}` is no address of this machine: write one, such as \"127.0.0.1\"")]
    Listen(String),
    /// Everybody on the network could call services and write ports.
    #[error(
        "`listen = \"{0}\"` lets every machine of that network call services and write ports, since \
         YARP asks nobody who he is: listen at 127.0.0.1, or write `insecure = true` where the \
         network is yours alone"
    )]
    Insecure(String),
    /// The prefix cannot begin names.
    #[error(
        "`prefix = {0:?}` begins no YARP name: write names with / between them, without blanks"
    )]
    Prefix(String),
    /// The namespace is not the name of a name server.
    #[error("`namespace = {0:?}` is no name of a name server: write one like \"/root\"")]
    Namespace(String),
    /// There is no such carrier.
    #[error("`carrier = {0:?}`: this side connects with \"tcp\" or \"fast_tcp\"")]
    Carrier(String),
    /// The time that servers may take to answer is none.
    #[error("`answer_within = {0}` is no time: write seconds, up to a year, or 0 for any time")]
    AnswerWithin(f64),
    /// A file of YARP that says where the name server is cannot be read.
    #[error("{path} says where the YARP name server is, and cannot be read: {source}")]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// A file of YARP says nothing that can be used.
    #[error(
        "{path} does not say where the YARP name server is: its first line is {line:?}, and not \
         `HOST PORT yarp`; `yarp conf HOST PORT` writes it, or set `server`"
    )]
    File {
        /// Path of the file.
        path: PathBuf,
        /// Its first line.
        line: String,
    },
    /// The system refuses a thread, or what wakes it.
    #[error("the system gives no thread for YARP's connections: {0}")]
    System(#[from] io::Error),
}

/// The name server did not answer, or refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum NameError {
    #[error(
        "no YARP name server is at {server}: {why}; start one (`yarpserver`), or say where it is \
         (`[backends.yarp] server`, or `yarp conf HOST PORT`)"
    )]
    Absent { server: String, why: String },
    #[error("the YARP name server at {server} does not answer within {within:?}")]
    Silent { server: String, within: Duration },
    #[error("what is at {server} is no YARP name server: it says {said:?}")]
    Foreign { server: String, said: String },
    #[error("the YARP name server at {server} did not register {name}: it says {said:?}")]
    Refused { server: String, name: String, said: String },
    #[error("{0:?} is no name on YARP: names have no blanks, quotes, brackets or backslashes")]
    Name(String),
}
