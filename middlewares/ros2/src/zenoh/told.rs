//! What daemons tell each other of their ends, which is more than ROS does: full types and digests.
//! Each end has a liveliness token for it, beside the one by which ROS nodes know it.

use genom_middleware::EndpointKind;

use super::keys::Id;

/// First chunk of these tokens.
const TOKENS: &str = "@genom_ros2";

/// Greatest size of such a token, in bytes. The types of a service are spelled out in it.
const TOKEN: usize = 64 << 10;

/// Numbers of ends that share a chunk of their tokens. zenoh compares each key that is declared with
/// all others at the same place in the tree of keys: thousands side by side would take seconds.
const BESIDE: u64 = 64;

/// An end of a daemon.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Told {
    pub(crate) kind: EndpointKind,
    /// With the namespace in front.
    pub(crate) address: String,
    pub(crate) digest: String,
    /// The types as error messages spell them.
    pub(crate) types: String,
}

pub(crate) fn all_tokens(domain: u16) -> String {
    format!("{TOKENS}/{domain}/**")
}

const KINDS: [(EndpointKind, &str); 3] = [
    (EndpointKind::Publisher, "pub"),
    (EndpointKind::Subscription, "sub"),
    (EndpointKind::Service, "srv"),
];

impl Told {
    pub(crate) fn token(&self, domain: u16, (session, number): &Id) -> String {
        let kind = KINDS.iter().find(|(kind, _)| *kind == self.kind).map_or("", |(_, kind)| kind);
        let [digest, types, address] =
            [&self.digest, &self.types, &self.address].map(|text| escaped(text));
        let group = number / BESIDE;
        format!("{TOKENS}/{domain}/{session}/{group}/{number}/{kind}/{digest}/{types}/{address}")
    }

    /// Parses the key of a token; `None` if it is none.
    pub(crate) fn parse(key: &str) -> Option<(Id, Self)> {
        // Escaped, its texts are three times as long at most.
        if key.len() > TOKEN {
            return None;
        }
        let mut chunks = key.strip_prefix(TOKENS)?.strip_prefix('/')?.split('/');
        let _domain = chunks.next()?;
        let session = chunks.next()?.to_owned();
        let _group = chunks.next()?;
        let id = (session, chunks.next()?.parse().ok()?);
        let kind = chunks.next()?;
        let (kind, _) = KINDS.into_iter().find(|(_, spelled)| *spelled == kind)?;
        let mut text = || unescaped(chunks.next()?).filter(|text| !text.contains(char::is_control));
        let (digest, types, address) = (text()?, text()?, text()?);
        chunks.next().is_none().then_some((id, Self { kind, address, digest, types }))
    }
}

/// Percent-encodes all that is not a letter, a digit or one of `_-.:`; an empty text is `%`.
fn escaped(text: &str) -> String {
    use std::fmt::Write as _;
    let mut out = String::new();
    for byte in text.bytes() {
        if byte.is_ascii_alphanumeric() || b"_-.:".contains(&byte) {
            out.push(char::from(byte));
        } else {
            _ = write!(out, "%{byte:02x}");
        }
    }
    if out.is_empty() { "%".to_owned() } else { out }
}

fn unescaped(text: &str) -> Option<String> {
    if text == "%" {
        return Some(String::new());
    }
    let mut out = Vec::new();
    let mut bytes = text.bytes();
    while let Some(byte) = bytes.next() {
        if byte != b'%' {
            out.push(byte);
            continue;
        }
        let digits = [bytes.next()?, bytes.next()?];
        let digits = std::str::from_utf8(&digits).ok()?;
        out.push(u8::from_str_radix(digits, 16).ok()?);
    }
    String::from_utf8(out).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_told_comes_back_as_it_was_whatever_is_in_it() {
        let told = Told {
            kind: EndpointKind::Service,
            address: "lab/arm/demo/poses/left".into(),
            digest: String::new(),
            types: "::demo::in (8 bytes, *$#?%/é) -> ::demo::out".into(),
        };
        let id = ("aac3178e".to_owned(), 12);
        let key = told.token(7, &id);
        assert!(zenoh::key_expr::OwnedKeyExpr::new(key.clone()).is_ok(), "{key}");
        assert_eq!(Told::parse(&key), Some((id, told)));
        for cut in 0..key.rfind('/').unwrap() {
            assert_eq!(Told::parse(&key[..cut]), None, "{cut} bytes");
        }
        assert_eq!(Told::parse(&format!("{key}/more")), None);
        assert_eq!(Told::parse("@genom_ros2/0/a/0/1/pub/d/%zz/x"), None);
        assert_eq!(Told::parse("@genom_ros2/0/a/0/1/pub/d/%ff/x"), None);
        assert_eq!(Told::parse("@genom_ros2/0/a/0/1/pub/d/t%1b/x"), None);
        let long = "x".repeat(TOKEN);
        assert_eq!(Told::parse(&format!("@genom_ros2/0/a/0/1/pub/d/t/{long}")), None);
    }
}
