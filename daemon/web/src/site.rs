//! Which requests come from the console's own pages.
//!
//! A browser sends cookies with requests that any page makes. Three checks keep other pages out:
//!
//! * `Host` must be an IP address, `localhost`, or a name of the configuration. A page elsewhere can
//!   make its own name stand for 127.0.0.1 (DNS rebinding), but its requests then have that name.
//! * `Origin` must be this host. Cookies do not depend on the port, so a page of another server on
//!   the same machine sends them, too, but it has another origin. What changes something must name
//!   its origin; every browser does.
//! * `Sec-Fetch-Site`, where the browser sends it, must say the same.

use axum::http::{HeaderMap, HeaderName, Method, header};
use genom_doors::{one_header, own_name};

/// Header by which a browser says how the page that makes a request is related to its address.
const SITE: HeaderName = HeaderName::from_static("sec-fetch-site");

/// The names of the console.
#[derive(Clone, Debug)]
pub(crate) struct Site {
    /// `http` or `https`.
    pub(crate) scheme: &'static str,
    /// Names besides IP addresses and `localhost`.
    pub(crate) hosts: Vec<String>,
}

/// What a request is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// A page without data, which links elsewhere may open.
    Page,
    /// Everything else.
    Data,
}

/// Why a request is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Foreign {
    /// The name could be anybody's.
    #[error("this host name is none of the console's")]
    Host,
    /// Another page made the request.
    #[error("requests from other web pages are not served")]
    Page,
    /// It changes something, and nothing says which page made it.
    #[error("a request that changes something names its origin")]
    NoOrigin,
}

impl Site {
    /// Whether a request was made by a page of this console, or by the user.
    pub(crate) fn admit(
        &self,
        purpose: Purpose,
        method: &Method,
        headers: &HeaderMap,
    ) -> Result<(), Foreign> {
        let host = one_header(headers, &header::HOST).ok_or(Foreign::Host)?;
        if !own_name(host, &self.hosts) {
            return Err(Foreign::Host);
        }
        if headers.contains_key(header::ORIGIN) {
            let origin =
                one_header(headers, &header::ORIGIN).and_then(|origin| origin.split_once("://"));
            let own = |(scheme, name): (&str, &str)| {
                scheme == self.scheme && name.eq_ignore_ascii_case(host)
            };
            if !origin.is_some_and(own) {
                return Err(Foreign::Page);
            }
        } else if !method.is_safe() {
            return Err(Foreign::NoOrigin);
        }
        let site = headers.get(SITE).map(|site| site.as_bytes());
        match (purpose, site) {
            (Purpose::Page, _) | (_, None | Some(b"same-origin" | b"none")) => Ok(()),
            _ => Err(Foreign::Page),
        }
    }
}

#[cfg(test)]
mod tests {
    use axum::http::HeaderValue;

    use super::*;

    fn judged(method: &str, headers: &[(&'static str, &str)]) -> Result<(), Foreign> {
        let site = Site { scheme: "http", hosts: vec!["robot.local".to_owned()] };
        let mut all = HeaderMap::new();
        for (name, value) in headers {
            all.append(*name, HeaderValue::from_str(value).unwrap());
        }
        site.admit(Purpose::Data, &method.parse().unwrap(), &all)
    }

    #[test]
    fn only_names_that_nobody_else_can_have_are_the_consoles() {
        for host in ["127.0.0.1:7380", "localhost:8080", "LocalHost", "[::1]:7380", "robot.local"] {
            assert_eq!(judged("GET", &[("host", host)]), Ok(()), "{host}");
        }
        for host in [
            "evil.example:7380",
            "localhost.evil.example",
            "127.0.0.1.evil.example",
            "robot.local.evil.example",
            "",
            "a b",
            "evil@127.0.0.1",
            "[::1",
            "2130706433",
        ] {
            assert_eq!(judged("GET", &[("host", host)]), Err(Foreign::Host), "{host}");
        }
        assert_eq!(judged("GET", &[]), Err(Foreign::Host));
        let twice = [("host", "localhost"), ("host", "localhost")];
        assert_eq!(judged("GET", &twice), Err(Foreign::Host));
    }

    #[test]
    fn a_page_of_another_origin_is_refused_also_on_the_same_machine() {
        let host = ("host", "127.0.0.1:7380");
        let from = |origin| judged("POST", &[host, ("origin", origin)]);
        assert_eq!(from("http://127.0.0.1:7380"), Ok(()));
        for origin in [
            "http://127.0.0.1:9999",
            "http://localhost:7380",
            "https://127.0.0.1:7380",
            "http://evil.example",
            "null",
            "",
            "127.0.0.1:7380",
        ] {
            assert_eq!(from(origin), Err(Foreign::Page), "{origin}");
        }
    }

    #[test]
    fn what_changes_something_names_its_origin() {
        let host = ("host", "127.0.0.1:7380");
        for method in ["POST", "PUT", "DELETE", "PATCH"] {
            assert_eq!(judged(method, &[host]), Err(Foreign::NoOrigin), "{method}");
        }
        assert_eq!(judged("GET", &[host]), Ok(()));
    }

    #[test]
    fn the_word_of_the_browser_counts_where_it_gives_it() {
        let from = |site| judged("GET", &[("host", "127.0.0.1:7380"), ("sec-fetch-site", site)]);
        assert_eq!((from("same-origin"), from("none")), (Ok(()), Ok(())));
        for other in ["cross-site", "same-site", "what?"] {
            assert_eq!(from(other), Err(Foreign::Page), "{other}");
        }
        // A link elsewhere may open a page, which holds no data.
        let site = Site { scheme: "http", hosts: Vec::new() };
        let mut headers = HeaderMap::new();
        headers.append("host", HeaderValue::from_static("localhost:1"));
        headers.append("sec-fetch-site", HeaderValue::from_static("cross-site"));
        assert_eq!(site.admit(Purpose::Page, &Method::GET, &headers), Ok(()));
    }
}
