//! Determines the daemon from the command line and contexts, and connects to it.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use genom_protocol::TokenFile;
use genom_protocol::socket::default_path;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpStream, UnixStream};
use tokio::sync::oneshot;
use tokio::time::timeout;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::PemObject as _;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, RootCertStore};

use crate::chosen::Chosen;
use crate::connection::{Connection, Host, Tcp};
use crate::failure::Failure;
use crate::private;
use crate::process::is_stopped;

/// A daemon, and how to reach it.
#[derive(Debug)]
pub(crate) struct Target {
    way: Way,
    /// Sent with requests; never part of a message or a log.
    token: Option<Secret>,
    /// Name of another daemon, to which this one relays requests.
    pub(crate) daemon: Option<String>,
    /// The context that selected the daemon, if the command line did not.
    chosen: Option<Chosen>,
    /// How long the daemon may leave all requests unanswered.
    pub(crate) limit: Duration,
}

/// Default of `limit`, in seconds.
const LIMIT: f64 = 10.0;

#[derive(Debug)]
enum Way {
    Socket(PathBuf),
    Tcp(Tcp),
    Tls { host: Tcp, ca: PathBuf, cert: Option<PathBuf> },
}

/// A text that debug output omits.
struct Secret(String);

impl std::fmt::Debug for Secret {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("...")
    }
}

impl std::fmt::Display for Target {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.way {
            Way::Socket(path) => write!(f, "{}", path.display())?,
            Way::Tcp(host) => write!(f, "{host}")?,
            Way::Tls { host, .. } => write!(f, "{host}")?,
        }
        match &self.daemon {
            Some(daemon) => write!(f, " for zenoh:{daemon}"),
            None => Ok(()),
        }
    }
}

impl Target {
    /// The daemon that the options select. Files of certificates are read only when connecting.
    pub(crate) fn new(connection: Connection, chosen: Option<Chosen>) -> Result<Self, Failure> {
        let Connection { socket, host, ca, cert, token_file, timeout: seconds, .. } = connection;
        let seconds = seconds.unwrap_or(LIMIT);
        let limit = Duration::try_from_secs_f64(seconds).ok().filter(|limit| !limit.is_zero());
        let limit = limit.ok_or_else(|| {
            Failure::usage(format!("--timeout {seconds}: no time to answer in"), "try 10")
        })?;
        let token = token_file.map(|path| read_token(&path)).transpose()?;
        let mut daemon = None;
        let way = match host {
            None => Way::Socket(socket.unwrap_or_else(default_path)),
            Some(Host::Zenoh(name)) => {
                daemon = Some(name);
                Way::Socket(socket.unwrap_or_else(default_path))
            }
            Some(Host::Tcp(host)) => {
                if host.tls.unwrap_or(ca.is_some() || !host.is_here()) {
                    let Some(ca) = ca else {
                        return Err(Failure::usage(
                            format!("{host}: nothing says whose certificate to trust"),
                            "--ca FILE names the root of the daemon's certificate",
                        ));
                    };
                    Way::Tls { host, ca, cert }
                } else if host.is_here() {
                    Way::Tcp(host)
                } else {
                    return Err(Failure::usage(
                        format!("{host} is another machine: the token would go in the clear"),
                        "use https:// and --ca FILE",
                    ));
                }
            }
        };
        Ok(Self { way, token, daemon, chosen, limit })
    }

    /// Value of the `Authorization` header. A token for a relayed daemon is not sent: its
    /// possession is proved instead.
    pub(crate) fn authorization(&self) -> Option<String> {
        let own = self.token.as_ref().filter(|_| self.daemon.is_none());
        own.map(|Secret(token)| format!("Bearer {token}"))
    }

    /// The token with which to authenticate to a relayed daemon.
    pub(crate) fn proof(&self) -> Option<genom_proof::Token> {
        self.token.as_ref().map(|Secret(token)| genom_proof::Token::new(token))
    }

    /// The daemon closed the connection before it replied.
    pub(crate) fn lost(&self) -> Failure {
        Failure::Lost { target: self.to_string() }
    }

    /// The daemon answers no requests; `process` is its process, if known.
    pub(crate) fn silent(&self, process: Option<i32>) -> Failure {
        let (target, limit) = (self.to_string(), self.limit);
        Failure::Silent { target, limit, stopped: process.filter(|one| is_stopped(*one)) }
    }

    /// The reply does not have the expected form.
    pub(crate) fn misread(&self, why: String) -> Failure {
        Failure::Reply { target: self.to_string(), why }
    }

    /// Connects. Also returns the process at the other end, if known.
    pub(crate) async fn open(&self) -> Result<(Box<dyn Stream>, Option<i32>), Failure> {
        timeout(self.limit, self.open_in_time()).await.unwrap_or_else(|_| Err(self.silent(None)))
    }

    async fn open_in_time(&self) -> Result<(Box<dyn Stream>, Option<i32>), Failure> {
        let unreachable = |source| Failure::Unreachable {
            target: self.to_string(),
            chosen: self.chosen.clone(),
            source,
        };
        match &self.way {
            Way::Socket(path) => {
                private::place_of_socket(path)?;
                let stream = socket(path).await.map_err(unreachable)?;
                let process = stream.peer_cred().ok().and_then(|peer| peer.pid());
                Ok((Box::new(stream), process))
            }
            Way::Tcp(host) => Ok((Box::new(tcp(host).await.map_err(unreachable)?), None)),
            Way::Tls { host, ca, cert } => {
                let connector = connector(ca, cert.as_deref())?;
                let name = ServerName::try_from(host.name.clone()).map_err(|_| {
                    Failure::usage(format!("{host}: no name for a certificate"), "check its name")
                })?;
                let stream = tcp(host).await.map_err(unreachable)?;
                let stream = connector.connect(name, stream).await.map_err(unreachable)?;
                Ok((Box::new(stream), None))
            }
        }
    }
}

/// A connection over any transport.
pub(crate) trait Stream: AsyncRead + AsyncWrite + Unpin + Send {}

impl<S: AsyncRead + AsyncWrite + Unpin + Send> Stream for S {}

/// Connects to a Unix socket. If its backlog is full, `connect` blocks, and therefore runs in a
/// thread.
async fn socket(path: &Path) -> io::Result<UnixStream> {
    match UnixStream::connect(path).await {
        Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
        connected => return connected,
    }
    let (sender, connected) = oneshot::channel();
    let path = path.to_owned();
    // The thread may remain blocked; it ends with the process.
    std::thread::Builder::new().name("connect".to_owned()).spawn(move || {
        let _ = sender.send(std::os::unix::net::UnixStream::connect(path));
    })?;
    let stream = connected.await.map_err(io::Error::other)??;
    stream.set_nonblocking(true)?;
    UnixStream::from_std(stream)
}

async fn tcp(host: &Tcp) -> io::Result<TcpStream> {
    TcpStream::connect((host.name.as_str(), host.port)).await
}

fn connector(ca: &Path, cert: Option<&Path>) -> Result<TlsConnector, Failure> {
    let unusable = |path: &Path, what: &str, why: &dyn std::fmt::Display| {
        let message = format!("{}: no usable {what}: {why}", path.display());
        Failure::usage(message, "files of certificates and keys are in PEM")
    };
    let certificates = |path: &Path| -> Result<Vec<CertificateDer<'static>>, Failure> {
        CertificateDer::pem_file_iter(path)
            .and_then(Iterator::collect)
            .map_err(|error| unusable(path, "certificate", &error))
    };
    let mut roots = RootCertStore::empty();
    for root in certificates(ca)? {
        roots.add(root).map_err(|error| unusable(ca, "root certificate", &error))?;
    }
    let builder = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_safe_default_protocol_versions()
        .map_err(|error| unusable(ca, "root certificate", &error))?
        .with_root_certificates(roots);
    let config = match cert {
        None => builder.with_no_client_auth(),
        Some(path) => {
            let text = private::read(path, "key file")?;
            let key = PrivateKeyDer::from_pem_slice(text.as_bytes())
                .map_err(|error| unusable(path, "private key", &error))?;
            builder
                .with_client_auth_cert(certificates(path)?, key)
                .map_err(|error| unusable(path, "client certificate", &error))?
        }
    };
    Ok(Arc::new(config).into())
}

/// Reads a token: the only content of the file, or the first of a daemon's token file.
fn read_token(path: &Path) -> Result<Secret, Failure> {
    let refuse = |why: String, help: &str| {
        Failure::usage(format!("the token file {}: {why}", path.display()), help)
    };
    let text = private::read(path, "token file")?;
    let of_file =
        toml::from_str::<TokenFile>(&text).ok().and_then(|all| all.token.into_iter().next());
    let token = of_file.map_or_else(|| text.trim().to_owned(), |one| one.token);
    let plain = token.bytes().all(|byte| byte.is_ascii_graphic());
    if token.is_empty() || !plain {
        return Err(refuse("it holds no token".to_owned(), "one line, the token alone"));
    }
    Ok(Secret(token))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn target(host: &str, ca: Option<&str>) -> Result<Target, Failure> {
        let host = Some(host.parse().unwrap());
        let ca = ca.map(PathBuf::from);
        Target::new(Connection { host, ca, ..Connection::default() }, None)
    }

    #[test]
    fn a_token_goes_over_the_network_by_tls_only() {
        assert!(matches!(target("127.0.0.1:1", None).unwrap().way, Way::Tcp(_)));
        assert!(matches!(target("robot:1", Some("ca")).unwrap().way, Way::Tls { .. }));
        assert!(matches!(target("https://[::1]:1", Some("ca")).unwrap().way, Way::Tls { .. }));
        let refused = target("robot:1", None).unwrap_err().to_string();
        assert!(refused.contains("whose certificate to trust"), "{refused}");
        assert_eq!(target("zenoh:arm", None).unwrap().daemon.as_deref(), Some("arm"));
        let refused = target("http://robot:1", None).unwrap_err().to_string();
        assert!(refused.contains("in the clear"), "{refused}");
    }
}
