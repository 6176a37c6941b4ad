//! Key expressions: of ports and services, and of liveliness tokens, which contain types.

use genom_middleware::{Address, EndpointKind};
use zenoh::key_expr::OwnedKeyExpr;

/// First chunk of all tokens. Because of the `@`, `**` does not match it.
const TOKENS: &str = "@genom";

/// Builds key expressions below the configured prefix.
#[derive(Clone, Debug)]
pub(crate) struct Keys {
    /// Empty, or ends with `/`.
    prefix: String,
}

/// Content of a liveliness token.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Token {
    pub(crate) kind: EndpointKind,
    /// Id of the session that declared it.
    pub(crate) session: String,
    /// Number among that session's ends at this address.
    pub(crate) number: u64,
    /// Digest of the type, or `<input>-<output>-<description>` of a service.
    pub(crate) digest: String,
    /// The types as error messages spell them.
    pub(crate) types: String,
    pub(crate) address: String,
}

/// An address cannot be used as a key expression.
#[derive(Debug, thiserror::Error)]
pub(crate) enum KeyError {
    #[error("`{0}` is no key: it has wild cards")]
    WildCards(String),
    /// zenoh refuses it, for instance because of an empty chunk.
    #[error("{0}")]
    Refused(zenoh::Error),
}

impl Keys {
    pub(crate) fn new(prefix: &str) -> Self {
        let prefix = prefix.trim_matches('/');
        Self { prefix: if prefix.is_empty() { String::new() } else { format!("{prefix}/") } }
    }

    /// Prefix of all keys: empty, or ends with `/`.
    pub(crate) fn of_all(&self) -> &str {
        &self.prefix
    }

    /// The key of a port or service; the error says why it is not valid.
    pub(crate) fn of(&self, at: &Address) -> Result<OwnedKeyExpr, KeyError> {
        let key = format!("{}{at}", self.prefix);
        if key.contains(['*', '$']) {
            return Err(KeyError::WildCards(key));
        }
        OwnedKeyExpr::new(key).map_err(KeyError::Refused)
    }

    /// A key expression that matches all tokens.
    pub(crate) fn all_tokens(&self) -> String {
        format!("{}{TOKENS}/**", self.prefix)
    }

    /// The key of a daemon's liveliness token.
    pub(crate) fn of_daemon(&self, session: &str, name: &str) -> String {
        format!("{}{TOKENS}/daemon/{session}/{}", self.prefix, escape(name))
    }

    /// Parses session and name from such a key.
    pub(crate) fn daemon(&self, key: &str) -> Option<(String, String)> {
        let rest = key.strip_prefix(&self.prefix)?.strip_prefix(TOKENS)?;
        let (session, name) = rest.strip_prefix("/daemon/")?.split_once('/')?;
        Some((session.to_owned(), unescape(name)?))
    }

    /// The key for requests to a daemon of that name.
    pub(crate) fn to_daemon(&self, name: &str) -> String {
        format!("{}{TOKENS}/rpc/{}", self.prefix, escape(name))
    }

    /// The key for requests to the daemon of that name in that session.
    pub(crate) fn to_daemon_at(&self, name: &str, session: &str) -> String {
        format!("{}/{}", self.to_daemon(name), escape(session))
    }

    pub(crate) fn of_token(&self, token: &Token) -> String {
        let kind = match token.kind {
            EndpointKind::Publisher => "pub",
            EndpointKind::Subscription => "sub",
            EndpointKind::Service => "srv",
        };
        let Token { session, number, digest, address, .. } = token;
        let types = escape(&token.types);
        format!("{}{TOKENS}/{kind}/{session}/{number}/{digest}/{types}/{address}", self.prefix)
    }

    /// Parses the key of a token; `None` if it is not one of ours.
    pub(crate) fn token(&self, key: &str) -> Option<Token> {
        let rest = key.strip_prefix(&self.prefix)?.strip_prefix(TOKENS)?.strip_prefix('/')?;
        let mut chunks = rest.splitn(6, '/');
        let kind = match chunks.next()? {
            "pub" => EndpointKind::Publisher,
            "sub" => EndpointKind::Subscription,
            "srv" => EndpointKind::Service,
            _ => return None,
        };
        Some(Token {
            kind,
            session: chunks.next()?.to_owned(),
            number: chunks.next()?.parse().ok()?,
            digest: chunks.next()?.to_owned(),
            types: unescape(chunks.next()?)?,
            address: chunks.next()?.to_owned(),
        })
    }
}

/// Percent-encodes characters with a meaning in key expressions.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for &byte in text.as_bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' => out.push(char::from(byte)),
            b'_' | b'-' | b'.' | b':' | b'<' | b'>' | b',' | b'(' | b')' => {
                out.push(char::from(byte));
            }
            _ => out.push_str(&format!("%{byte:02x}")),
        }
    }
    out
}

fn unescape(text: &str) -> Option<String> {
    let mut out = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&byte, tail)) = rest.split_first() {
        rest = tail;
        if byte == b'%' {
            let (digits, tail) = rest.split_at_checked(2)?;
            out.push(u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?);
            rest = tail;
        } else {
            out.push(byte);
        }
    }
    String::from_utf8(out).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_says_what_was_put_into_it() {
        for prefix in ["", "lab/robots"] {
            let keys = Keys::new(prefix);
            let token = Token {
                kind: EndpointKind::Service,
                session: "1f".to_owned(),
                number: 7,
                digest: "abc-def".to_owned(),
                types: "::demo::état/2 (8 bytes, 100%) -> sequence<long,3>*".to_owned(),
                address: "demo/poses/left".to_owned(),
            };
            let key = keys.of_token(&token);
            assert!(OwnedKeyExpr::new(key.clone()).is_ok(), "{key}");
            assert_eq!(keys.token(&key), Some(token));
        }
    }

    #[test]
    fn keys_of_others_are_no_tokens() {
        let keys = Keys::new("lab");
        for key in ["demo/position", "lab/@genom/pub/1", "@genom/pub/1/2/3/4/5", "lab/@genom/x"] {
            assert_eq!(keys.token(key), None, "{key}");
        }
        assert_eq!(keys.token("lab/@genom/pub/1/2/3/%zz/demo/p"), None);
    }

    #[test]
    fn an_address_with_wild_cards_has_no_key() {
        assert!(Keys::new("").of(&Address::new("demo", "*")).is_err());
        assert!(Keys::new("").of(&Address::new("demo", "a/**")).is_err());
        assert!(Keys::new("").of(&Address::new("demo", "position")).is_ok());
    }
}
