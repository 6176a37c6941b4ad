//! The rights that routes require.

use std::collections::{BTreeMap, HashMap};

use genom_protocol::Right;
use genom_protocol::routes::Method;

/// The right that each route requires, or none if anybody may use it.
#[derive(Clone, Debug, Default)]
pub struct Rights(HashMap<&'static str, BTreeMap<&'static str, Option<Right>>>);

/// What a request requires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// Nothing: anybody may make it.
    Open,
    /// This right.
    Right(Right),
    /// The path exists, but does not support the method.
    NoSuchMethod,
    /// There is no such path; only authenticated clients are told so.
    NoSuchPath,
}

impl Rights {
    /// From rows of method, path in the router's form, and right.
    #[must_use]
    pub fn of(rows: impl IntoIterator<Item = (Method, &'static str, Option<Right>)>) -> Self {
        let mut rights = Self::default();
        for (method, path, right) in rows {
            rights.0.entry(path).or_default().insert(method.as_str(), right);
        }
        rights
    }

    /// What a request requires; `path` is that of the matching route, if there is one.
    pub(crate) fn wanted(&self, method: &str, path: Option<&str>) -> Wanted {
        let Some(path) = path else { return Wanted::NoSuchPath };
        // A route without a row is restricted to `admin`.
        let Some(methods) = self.0.get(path) else { return Wanted::Right(Right::Admin) };
        match methods.get(method) {
            Some(None) => Wanted::Open,
            Some(Some(right)) => Wanted::Right(*right),
            None => Wanted::NoSuchMethod,
        }
    }

    /// The methods of a path, as HTTP lists them (`Allow`).
    pub(crate) fn allowed(&self, path: &str) -> String {
        let methods = self.0.get(path).into_iter().flat_map(BTreeMap::keys).copied();
        let methods: Vec<_> = methods
            .flat_map(|one| if one == "GET" { vec!["GET", "HEAD"] } else { vec![one] })
            .collect();
        methods.join(",")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_route_without_a_row_is_for_administrators() {
        let rights = Rights::of([
            (Method::Get, "/a", None),
            (Method::Get, "/b", Some(Right::Read)),
            (Method::Delete, "/b", Some(Right::Wire)),
        ]);
        assert_eq!(rights.wanted("GET", Some("/a")), Wanted::Open);
        assert_eq!(rights.wanted("DELETE", Some("/b")), Wanted::Right(Right::Wire));
        assert_eq!(rights.wanted("PATCH", Some("/b")), Wanted::NoSuchMethod);
        assert_eq!(rights.wanted("GET", Some("/c")), Wanted::Right(Right::Admin));
        assert_eq!(rights.wanted("GET", None), Wanted::NoSuchPath);
        assert_eq!(rights.allowed("/b"), "DELETE,GET,HEAD");
    }
}
