//! TLS of the TCP listener: the daemon's certificate, and those of clients if they are asked for.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use genom_configuration::Tls;
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::{self, PemObject as _};
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::server::{VerifierBuilderError, WebPkiClientVerifier};
use tokio_rustls::rustls::{self, RootCertStore, ServerConfig};

use crate::rpc::private::{self, PrivateError};

/// Certificates or keys that cannot be used.
#[derive(Debug, thiserror::Error)]
pub(crate) enum TlsError {
    /// A file that is not there, or is no PEM file of what it should hold.
    #[error("{}: no usable {what}: {source}", path.display())]
    File { path: PathBuf, what: &'static str, source: pem::Error },
    /// Others could read the key.
    #[error(transparent)]
    Open(#[from] private::NotPrivate),
    /// The files do not fit together.
    #[error("the certificate and key of rpc.tls cannot be used: {0}")]
    Unfit(#[from] rustls::Error),
    /// The clients' roots are none.
    #[error("{}: no roots of client certificates: {source}", path.display())]
    Roots { path: PathBuf, source: VerifierBuilderError },
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

/// What answers TLS handshakes.
pub(crate) fn acceptor(tls: &Tls) -> Result<TlsAcceptor, TlsError> {
    let certificates_of_ours = certificates(&tls.cert)?;
    let unusable =
        |source| TlsError::File { path: tls.key.clone(), what: "private key in PEM", source };
    let text = private::read(&tls.key).map_err(|error| match error {
        PrivateError::Read(source) => unusable(pem::Error::Io(source)),
        PrivateError::Open(open) => open.into(),
    })?;
    let key = PrivateKeyDer::from_pem_slice(text.as_bytes()).map_err(unusable)?;
    let provider = Arc::new(ring::default_provider());
    let builder = ServerConfig::builder_with_provider(Arc::clone(&provider))
        .with_safe_default_protocol_versions()?;
    let builder = match &tls.client_ca {
        None => builder.with_no_client_auth(),
        Some(path) => {
            let mut roots = RootCertStore::empty();
            for root in certificates(path)? {
                roots.add(root)?;
            }
            let verifier = WebPkiClientVerifier::builder_with_provider(Arc::new(roots), provider)
                .build()
                .map_err(|source| TlsError::Roots { path: path.clone(), source })?;
            builder.with_client_cert_verifier(verifier)
        }
    };
    Ok(Arc::new(builder.with_single_cert(certificates_of_ours, key)?).into())
}
