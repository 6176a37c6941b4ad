//! Names typed on the command line: `component/port`, and their spelling in a URL.

/// `component/name`, as typed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Path2 {
    /// Instance name of the component.
    pub(crate) component: String,
    /// Port, or `port/element`.
    pub(crate) name: String,
}

impl std::str::FromStr for Path2 {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('/') {
            Some((component, name)) if !component.is_empty() && !name.is_empty() => {
                Ok(Self { component: component.to_owned(), name: name.to_owned() })
            }
            _ => Err("expected COMPONENT/PORT, for instance demo/position".to_owned()),
        }
    }
}

impl std::fmt::Display for Path2 {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.component, self.name)
    }
}

impl Path2 {
    /// The port, and the element of a multiple port.
    pub(crate) fn port(&self) -> (&str, Option<&str>) {
        match self.name.split_once('/') {
            Some((port, element)) => (port, Some(element)),
            None => (&self.name, None),
        }
    }
}

/// A path of the RPC from its segments, each percent-encoded.
pub(crate) fn url<'a>(segments: impl IntoIterator<Item = &'a str>) -> String {
    let mut path = String::new();
    for segment in segments {
        path.push('/');
        path.push_str(&encode(segment));
    }
    path
}

/// Percent-encodes everything but unreserved characters (RFC 3986, 2.3).
pub(crate) fn encode(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for byte in text.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~".contains(&byte) {
            out.push(char::from(byte));
        } else {
            out.push_str(&format!("%{byte:02X}"));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_may_have_an_element() {
        let path: Path2 = "demo/cameras/left".parse().unwrap();
        assert_eq!((path.component.as_str(), path.port()), ("demo", ("cameras", Some("left"))));
        assert!("demo".parse::<Path2>().is_err());
        assert!("demo/".parse::<Path2>().is_err());
    }

    #[test]
    fn names_never_leave_their_segment() {
        assert_eq!(url(["components", "a/b?c d"]), "/components/a%2Fb%3Fc%20d");
    }
}
