//! Key expressions as `rmw_zenoh_cpp` uses them: of topics and services, and of the liveliness
//! tokens by which nodes and their ends are known.

use zenoh::key_expr::OwnedKeyExpr;

use super::quality::Quality;
use crate::rmw::{EndError, Gid, Named};

/// First chunk of all tokens. Because of the `@`, `**` does not match it.
const TOKENS: &str = "@ros2_lv";

/// Greatest size of the key of a token, in bytes.
const LONGEST: usize = 4096;

/// Type hash of Humble, which has none.
pub(crate) const NO_HASH: &str = "TypeHashNotSupported";

/// The key of a topic or service: `0/demo/position/demo::msg::dds_::State_/RIHS01_..`.
pub(crate) fn of(domain: u16, of: &Named) -> Result<OwnedKeyExpr, EndError> {
    let hash = of.hash.as_ref().ok_or_else(|| EndError::NoHash(of.ty.clone()))?;
    Ok(of_found(domain, &of.name, &of.ty.to_dds(""), hash)?)
}

/// The same with the type as tokens spell it.
pub(crate) fn of_found(
    domain: u16,
    name: &str,
    ty: &str,
    hash: &str,
) -> zenoh::Result<OwnedKeyExpr> {
    OwnedKeyExpr::new(format!("{domain}/{name}/{ty}/{hash}"))
}

/// Last chunk of the token of an in port that also reads [`of_buffers`].
const BUFFERS: &str = "backends:cpu:";

/// Begins the chunk of a token that tells where buffers of messages may lie.
const BACKENDS: &str = "backends:";

/// The key on which publishers of Lyrical and later write messages with a `uint8[]` or `char[]` for
/// those subscriptions of which the token says so. Others get such messages on `key` from some
/// versions, and not at all from others.
pub(crate) fn of_buffers(key: &str) -> String {
    format!("{key}/_buf_cpu")
}

/// A key expression that matches all tokens of a domain.
pub(crate) fn all_tokens(domain: u16) -> String {
    format!("{TOKENS}/{domain}/**")
}

/// Kind of an end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Publisher,
    Subscription,
    Server,
    Client,
}

impl Kind {
    const ALL: [(Self, &'static str); 4] = [
        (Self::Publisher, "MP"),
        (Self::Subscription, "MS"),
        (Self::Server, "SS"),
        (Self::Client, "SC"),
    ];

    fn spelled(self) -> &'static str {
        Self::ALL.iter().find(|(kind, _)| *kind == self).map_or("", |(_, spelled)| spelled)
    }
}

/// Identifies an end or node: its session, and its number there.
pub(crate) type Id = (String, u64);

/// A node, as tokens name it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Node {
    pub(crate) session: String,
    pub(crate) number: u64,
    /// With its leading slash: `/`, `/lab/arm`.
    pub(crate) namespace: String,
    pub(crate) name: String,
}

/// An end, as its token tells of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct End {
    pub(crate) node: Node,
    pub(crate) number: u64,
    pub(crate) kind: Kind,
    /// Without the leading slash.
    pub(crate) name: String,
    /// Name of the type in DDS: `std_msgs::msg::dds_::String_`.
    pub(crate) ty: String,
    pub(crate) hash: String,
    pub(crate) quality: Quality,
    /// Whether it reads [`of_buffers`], too.
    pub(crate) buffers: bool,
}

fn mangled(name: &str) -> String {
    name.replace('/', "%")
}

fn unmangled(text: &str) -> String {
    text.replace('%', "/")
}

impl Node {
    /// The key of the node's token.
    pub(crate) fn token(&self, domain: u16) -> String {
        self.with(domain, self.number, "NN")
    }

    fn with(&self, domain: u16, number: u64, kind: &str) -> String {
        let Self { session, number: node, namespace, name } = self;
        // No enclave.
        format!(
            "{TOKENS}/{domain}/{session}/{node}/{number}/{kind}/%/{}/{name}",
            mangled(namespace)
        )
    }
}

impl End {
    pub(crate) fn id(&self) -> Id {
        (self.node.session.clone(), self.number)
    }

    /// The key of the end's token.
    pub(crate) fn token(&self, domain: u16) -> String {
        let Self { node, number, kind, name, ty, hash, quality, buffers } = self;
        let node = node.with(domain, *number, kind.spelled());
        let (name, ty) = (mangled(name), mangled(ty));
        let last = if *buffers { ["/", BUFFERS].concat() } else { String::new() };
        format!("{node}/%{name}/{ty}/{hash}/{}{last}", quality.encoded())
    }

    /// Parses the key of an end's token. `None` for nodes, and for what is no token.
    pub(crate) fn parse(key: &str) -> Option<Self> {
        if !is_plain(key) {
            return None;
        }
        let mut chunks = key.strip_prefix(TOKENS)?.strip_prefix('/')?.split('/');
        let _domain = chunks.next()?;
        let session = chunks.next()?.to_owned();
        let node = chunks.next()?.parse().ok()?;
        let number = chunks.next()?.parse().ok()?;
        let kind = chunks.next()?;
        let (kind, _) = Kind::ALL.into_iter().find(|(_, spelled)| *spelled == kind)?;
        let _enclave = chunks.next()?;
        let namespace = unmangled(chunks.next()?);
        let node = Node { session, number: node, namespace, name: unmangled(chunks.next()?) };
        let name = unmangled(chunks.next()?).trim_start_matches('/').to_owned();
        let (ty, hash) = (unmangled(chunks.next()?), unmangled(chunks.next()?));
        let quality = Quality::parse(chunks.next()?)?;
        // Later distributions may add chunks.
        let buffers = chunks.any(|chunk| chunk.starts_with(BACKENDS));
        (!name.is_empty() && !ty.is_empty()).then_some(Self {
            node,
            number,
            kind,
            name,
            ty,
            hash,
            quality,
            buffers,
        })
    }
}

/// Whether a token is that of a node. Of these, nothing is needed.
pub(crate) fn is_of_node(key: &str) -> bool {
    is_plain(key) && key.split('/').nth(5) == Some("NN")
}

/// Whether the key of a token is short enough, and may be printed. Names of ROS have 256 characters
/// at most.
pub(crate) fn is_plain(key: &str) -> bool {
    key.len() <= LONGEST && !key.contains(char::is_control)
}

/// The gid of the end with this token, as `rmw_zenoh_cpp` computes it.
pub(crate) fn gid(token: &str) -> Gid {
    twox_hash::XxHash3_128::oneshot(token.as_bytes()).to_le_bytes()
}

#[cfg(test)]
mod tests {
    use genom_rosidl::TypeName;

    use super::*;

    /// As in the design document of `rmw_zenoh`.
    const TOKEN: &str = "@ros2_lv/0/aac3178e146ba6f1fc6e6a4085e77f21/0/10/MP/%/%/talker/%chatter/\
                         std_msgs::msg::dds_::String_/RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1\
                         288021743503259e948f6b1a18/::,7:,:,:,,";

    #[test]
    fn tokens_are_those_of_rmw_zenoh_and_come_back_as_they_were() {
        let end = End::parse(TOKEN).unwrap();
        assert_eq!((end.name.as_str(), end.node.name.as_str()), ("chatter", "talker"));
        assert_eq!((end.node.namespace.as_str(), end.number, end.kind), ("/", 10, Kind::Publisher));
        assert_eq!(end.ty, "std_msgs::msg::dds_::String_");
        assert_eq!(end.token(0), TOKEN);
        let with_buffers = format!("{TOKEN}/backends:cpu:");
        let other = End { buffers: true, ..end.clone() };
        assert_eq!(End::parse(&with_buffers), Some(other.clone()));
        assert_eq!(other.token(0), with_buffers);
        let node = end.node.token(0);
        assert_eq!(node, "@ros2_lv/0/aac3178e146ba6f1fc6e6a4085e77f21/0/0/NN/%/%/talker");
        assert_eq!(End::parse(&node), None);
        assert!(is_of_node(&node) && !is_of_node(TOKEN));
    }

    #[test]
    fn names_of_several_parts_are_one_chunk_in_a_token_and_several_in_a_key() {
        let mut end = End::parse(TOKEN).unwrap();
        end.name = "lab/arm/demo/position".to_owned();
        end.node.namespace = "/lab/arm".to_owned();
        let token = end.token(7);
        assert!(token.contains("/MP/%/%lab%arm/talker/%lab%arm%demo%position/"), "{token}");
        assert_eq!(End::parse(&token), Some(end));
        let ty = TypeName::new("std_msgs", "msg", "String");
        let mut named = Named { name: "lab/arm/p".into(), ty, hash: Some("RIHS01_0".into()) };
        let key = of(7, &named).unwrap();
        assert_eq!(key.as_str(), "7/lab/arm/p/std_msgs::msg::dds_::String_/RIHS01_0");
        named.hash = None;
        assert!(of(7, &named).unwrap_err().to_string().starts_with("std_msgs/msg/String has no"));
    }

    #[test]
    fn what_is_no_token_is_left_out() {
        let cut = |end: usize| TOKEN.get(..end).and_then(End::parse);
        assert!((0..TOKEN.len() - 12).all(|end| cut(end).is_none()));
        for (from, to) in [("MP", "XX"), ("/10/", "/ten/"), ("%chatter", "%"), ("@ros2_lv", "@x")] {
            assert_eq!(End::parse(&TOKEN.replace(from, to)), None, "{to}");
        }
        for name in ["%\u{1b}[2J".to_owned(), format!("%{}", "a".repeat(LONGEST))] {
            let token = TOKEN.replace("%chatter", &name);
            assert_eq!(End::parse(&token), None);
            assert!(!is_of_node(&token.replace("/MP/", "/NN/")));
        }
    }
}
