//! TLS of a TCP listener: the certificate of the service, and those of clients if they are asked for.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::{self, PemObject as _};
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::server::{VerifierBuilderError, WebPkiClientVerifier};
use tokio_rustls::rustls::{self, RootCertStore, ServerConfig};

use crate::private::{self, PrivateError};

/// Certificates or keys that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TlsError {
    /// A file that is not there, or is no PEM file of what it should hold.
    #[error("{}: no usable {what}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What it should hold.
        what: &'static str,
        /// What is wrong with it.
        source: pem::Error,
    },
    /// Others could read the key.
    #[error(transparent)]
    Open(#[from] private::NotPrivate),
    /// The files do not fit together.
    #[error("the certificate and key of rpc.tls cannot be used: {0}")]
    Unfit(#[from] rustls::Error),
    /// The clients' roots are none.
    #[error("{}: no roots of client certificates: {source}", path.display())]
    Roots {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
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

/// Files of a TLS listener, in PEM.
#[derive(Clone, Copy, Debug)]
pub struct Certificates<'a> {
    /// The certificate of the service, and those between it and its root.
    pub cert: &'a Path,
    /// Its key, which nobody else may read.
    pub key: &'a Path,
    /// Roots of clients' certificates: with them nobody comes in without one.
    pub client_ca: Option<&'a Path>,
}

/// What answers TLS handshakes.
///
/// # Errors
/// A file is missing, holds something else, or could be read by others; or they do not fit
/// together.
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
