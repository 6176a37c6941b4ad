//! Random secrets that browsers hold: the daemon keeps only their digests.

use std::{fmt, io};

use genom_proof::{Bytes, random};
use sha2::{Digest as _, Sha256};

/// A secret of 256 random bits, as hexadecimal digits.
pub(crate) fn new() -> io::Result<String> {
    Ok(Bytes(random::<32>()?).to_string())
}

/// What is kept of a secret. Secrets are found by it, so that the time of a search tells nothing.
pub(crate) fn digest(secret: &str) -> Bytes<32> {
    Bytes(Sha256::digest(secret.as_bytes()).into())
}

/// The cookie of a request's session.
#[derive(Clone)]
pub(crate) struct Secret(pub(crate) String);

impl fmt::Debug for Secret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Secret(...)")
    }
}
