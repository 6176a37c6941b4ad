//! TLS of a TCP listener: the certificate of the service, and checks of clients' certificates.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::{self, PemObject as _};
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::server::{VerifierBuilderError, WebPkiClientVerifier};
use tokio_rustls::rustls::{self, RootCertStore, ServerConfig};

use crate::private::{self, PrivateError};

/// Why certificates or keys cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TlsError {
    /// A file is missing, or is not a PEM file with the expected content.
    #[error("{}: no usable {what}: {source}", path.display())]
    File {
        /// Path of the file.
        path: PathBuf,
        /// The expected content.
        what: &'static str,
        /// The error.
        source: pem::Error,
    },
    /// Others can read the key.
    #[error(transparent)]
    Open(#[from] private::NotPrivate),
    /// Certificate and key do not match.
    #[error("the certificate and key of rpc.tls cannot be used: {0}")]
    Unfit(#[from] rustls::Error),
    /// The root certificates for clients are not valid.
    #[error("{}: no roots of client certificates: {source}", path.display())]
    Roots {
        /// Path of the file.
        path: PathBuf,
        /// The error.
        source: VerifierBuilderError,
    },
}

fn certificates(path: &Path) -> Result<Vec<CertificateDer<'static>>, TlsError> {
    let failed =
        |source| TlsError::File { path: path.to_owned(), what: "certificate in PEM", source };
    let all: Vec<_> = CertificateDer::pem_file_iter(path)
        .map_err(failed)?
        .collect::<Result<_, _>>()
        .map_err(failed)?;
    if all.is_empty() { Err(failed(pem::Error::NoItemsFound)) } else { Ok(all) }
}

/// PEM files of a TLS listener.
#[derive(Clone, Copy, Debug)]
pub struct Certificates<'a> {
    /// The certificate chain of the service, its own certificate first.
    pub cert: &'a Path,
    /// Its private key, which nobody else may read.
    pub key: &'a Path,
    /// Root certificates that clients' certificates are checked against. If set, clients without a
    /// certificate are refused.
    pub client_ca: Option<&'a Path>,
}

/// Creates the acceptor of TLS connections.
///
/// # Errors
/// A file is missing, has other content, or can be read by others; or certificate and key do not
/// match.
pub fn acceptor(files: Certificates<'_>) -> Result<TlsAcceptor, TlsError> {
    let certificates_of_ours = certificates(files.cert)?;
    let unusable =
        |source| TlsError::File { path: files.key.to_owned(), what: "private key in PEM", source };
    let text = private::read(files.key).map_err(|error| match error {
        PrivateError::Read(source) => unusable(pem::Error::Io(source)),
        PrivateError::Open(open) => open.into(),
    })?;
    let key = PrivateKeyDer::from_pem_slice(text.as_bytes()).map_err(unusable)?;
    let provider = Arc::new(ring::default_provider());
    let builder = ServerConfig::builder_with_provider(Arc::clone(&provider))
        .with_safe_default_protocol_versions()?;
    let builder = match files.client_ca {
        None => builder.with_no_client_auth(),
        Some(path) => {
            let mut roots = RootCertStore::empty();
            for root in certificates(path)? {
                roots.add(root)?;
            }
            let verifier = WebPkiClientVerifier::builder_with_provider(Arc::new(roots), provider)
                .build()
                .map_err(|source| TlsError::Roots { path: path.to_owned(), source })?;
            builder.with_client_cert_verifier(verifier)
        }
    };
    Ok(Arc::new(builder.with_single_cert(certificates_of_ours, key)?).into())
}
