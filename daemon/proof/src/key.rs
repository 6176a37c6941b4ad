//! Keys derived from a token: one for each purpose, so that a code made for one purpose is not
//! valid for another.

use std::fmt;

use hkdf::Hkdf;
use hmac::{Hmac, KeyInit as _, Mac as _};
use sha2::{Digest as _, Sha256};
use subtle::ConstantTimeEq as _;

use crate::hex::Bytes;

/// Length of a nonce, in bytes.
pub const NONCE: usize = 32;
/// Length of a hint, in bytes.
pub const HINT: usize = 8;
/// Length of an authentication code, in bytes.
pub const MAC: usize = 32;

/// Salt of HKDF: separates these keys from others that may be derived from the same token.
const SALT: &[u8] = b"genomd token";
/// First part of each transcript; another version of the protocol has another name.
const PROTOCOL: &[u8] = b"genomd relay 1";

/// Random bytes from the operating system.
///
/// # Errors
/// The operating system provides none.
pub fn random<const N: usize>() -> std::io::Result<[u8; N]> {
    let mut bytes = [0; N];
    getrandom::fill(&mut bytes).map_err(std::io::Error::other)?;
    Ok(bytes)
}

/// Key material derived from a token. It does not contain the token's text, and is never printed.
#[derive(Clone)]
pub struct Token(Hkdf<Sha256>);

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token(...)")
    }
}

impl Token {
    /// Derives the key material from the text of a token.
    #[must_use]
    pub fn new(text: &str) -> Self {
        Self(Hkdf::new(Some(SALT), text.as_bytes()))
    }

    /// The key for one purpose.
    fn key(&self, parts: &[&[u8]]) -> [u8; 32] {
        let mut key = [0; 32];
        // HKDF refuses only lengths above 255 blocks of the hash; this is one block.
        let made = self.0.expand_multi_info(parts, &mut key);
        debug_assert!(made.is_ok());
        key
    }

    /// By this hint the daemon finds the token without the client sending it. It depends on the
    /// nonce, so that an eavesdropper cannot tell which requests use the same token.
    #[must_use]
    pub fn hint(&self, nonce: &[u8; NONCE]) -> Bytes<HINT> {
        let code = mac(&self.key(&[b"hint"]), &[nonce]);
        let mut hint = [0; HINT];
        hint.iter_mut().zip(code).for_each(|(to, from)| *to = from);
        Bytes(hint)
    }

    /// The keys of the session that a handshake establishes.
    #[must_use]
    pub fn keys(&self, handshake: &Handshake<'_>) -> Keys {
        let transcript = handshake.transcript();
        Keys {
            proof: mac(&self.key(&[b"daemon"]), &[&transcript]),
            requests: self.key(&[b"requests", &transcript]),
            answers: self.key(&[b"answers", &transcript]),
        }
    }
}

/// What client and daemon told each other in the handshake.
#[derive(Clone, Copy, Debug)]
pub struct Handshake<'a> {
    /// Name of the daemon that the client asked for; a daemon answers to its own name only.
    pub daemon: &'a str,
    /// Identity of the daemon's endpoint on the middleware.
    pub at: &'a str,
    /// Random bytes chosen by the client.
    pub nonce: &'a [u8; NONCE],
    /// Random bytes chosen by the daemon.
    pub cookie: &'a [u8; NONCE],
}

impl Handshake<'_> {
    fn transcript(&self) -> [u8; 32] {
        let mut hash = Sha256::new();
        for part in [PROTOCOL, self.daemon.as_bytes(), self.at.as_bytes(), self.nonce, self.cookie]
        {
            // Each part is preceded by its length: two different handshakes never give the same
            // bytes.
            hash.update((part.len() as u64).to_be_bytes());
            hash.update(part);
        }
        hash.finalize().into()
    }
}

/// The keys of one session.
#[derive(Clone)]
pub struct Keys {
    proof: [u8; MAC],
    requests: [u8; 32],
    answers: [u8; 32],
}

impl fmt::Debug for Keys {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Keys(...)")
    }
}

impl Keys {
    /// The daemon's proof that it holds the token.
    #[must_use]
    pub fn proof(&self) -> Bytes<MAC> {
        Bytes(self.proof)
    }

    /// Checks the daemon's proof, in constant time.
    #[must_use]
    pub fn proves(&self, shown: &Bytes<MAC>) -> bool {
        self.proof.ct_eq(&shown.0).into()
    }

    /// Authentication code of request `number`.
    #[must_use]
    pub fn request(&self, number: u64, bytes: &[u8]) -> Bytes<MAC> {
        Bytes(mac(&self.requests, &[&number.to_be_bytes(), bytes]))
    }

    /// Authentication code of the answer to request `number`.
    #[must_use]
    pub fn answer(&self, number: u64, bytes: &[u8]) -> Bytes<MAC> {
        Bytes(mac(&self.answers, &[&number.to_be_bytes(), bytes]))
    }

    /// Checks the code of request `number`, in constant time.
    #[must_use]
    pub fn is_request(&self, number: u64, bytes: &[u8], shown: &Bytes<MAC>) -> bool {
        code(&self.requests, &[&number.to_be_bytes(), bytes]).verify_slice(&shown.0).is_ok()
    }

    /// Checks the code of the answer to request `number`, in constant time.
    #[must_use]
    pub fn is_answer(&self, number: u64, bytes: &[u8], shown: &Bytes<MAC>) -> bool {
        code(&self.answers, &[&number.to_be_bytes(), bytes]).verify_slice(&shown.0).is_ok()
    }
}

fn code(key: &[u8; 32], parts: &[&[u8]]) -> Hmac<Sha256> {
    // RFC 2104 pads keys with zeros to one block of the hash.
    let mut block = [0; 64];
    block.iter_mut().zip(key).for_each(|(to, from)| *to = *from);
    let mut code = Hmac::<Sha256>::new(&block.into());
    parts.iter().for_each(|part| code.update(part));
    code
}

fn mac(key: &[u8; 32], parts: &[&[u8]]) -> [u8; MAC] {
    code(key, parts).finalize().into_bytes().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "0123456789abcdef0123456789abcdef";

    fn handshake<'a>(daemon: &'a str, at: &'a str) -> Handshake<'a> {
        Handshake { daemon, at, nonce: &[1; NONCE], cookie: &[2; NONCE] }
    }

    /// The tests of the Python client contain the same values.
    #[test]
    fn the_codes_are_those_that_other_implementations_make() {
        let token = Token::new(TEXT);
        let keys = token.keys(&handshake("robot", "1f"));
        let made = [
            token.hint(&[1; NONCE]).to_string(),
            keys.proof().to_string(),
            keys.request(7, b"abc").to_string(),
            keys.answer(7, b"abc").to_string(),
        ];
        let expected = [
            "ac21196dc2cbaee6",
            "ca8eaa2ce55c8a76dba1c97d5ff27163aa71fc9763d67023c9bbb19bf1366d3b",
            "9dc470dce1c9cc32f7d325bb992f6695933f589ada063daf85b4d3642a8a1391",
            "3d80d179c59f243f91e0e2c136cd863844dc4c7c863bc2e131095d1513a0a876",
        ];
        assert_eq!(made, expected);
    }

    #[test]
    fn whatever_differs_gives_other_keys() {
        let keys = Token::new(TEXT).keys(&handshake("robot", "1f"));
        let proof = keys.proof();
        assert!(keys.proves(&proof));
        let other = Token::new("0123456789abcdef0123456789abcdeX");
        assert!(!other.keys(&handshake("robot", "1f")).proves(&proof));
        // Where the first name ends and the next begins makes a difference, too.
        for (daemon, at) in [("robot", "2f"), ("arm", "1f"), ("robot1", "f"), ("robo", "t1f")] {
            assert!(!Token::new(TEXT).keys(&handshake(daemon, at)).proves(&proof), "{daemon}");
        }
        for (nonce, cookie) in [([1; NONCE], [3; NONCE]), ([2; NONCE], [1; NONCE])] {
            let changed = Handshake { daemon: "robot", at: "1f", nonce: &nonce, cookie: &cookie };
            assert!(!Token::new(TEXT).keys(&changed).proves(&proof));
        }
    }

    #[test]
    fn a_code_is_good_for_one_number_one_text_and_one_direction() {
        let keys = Token::new(TEXT).keys(&handshake("robot", "1f"));
        let code = keys.request(1, b"abc");
        assert!(keys.is_request(1, b"abc", &code));
        assert!(!keys.is_request(2, b"abc", &code));
        assert!(!keys.is_request(1, b"abd", &code));
        assert!(!keys.is_answer(1, b"abc", &code));
    }

    #[test]
    fn nothing_of_a_token_shows_when_it_is_printed() {
        let token = Token::new(TEXT);
        let shown = format!("{token:?} {:?}", token.keys(&handshake("robot", "1f")));
        assert_eq!(shown, "Token(...) Keys(...)");
    }
}
