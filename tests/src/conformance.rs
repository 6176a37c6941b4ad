//! The table of properties and backends, made from the output of the conformance tests.
//!
//! Properties and backends are not listed here: they are taken from the names of the tests.

use std::collections::BTreeMap;
use std::fmt;

/// Result of one property on one backend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The test passed.
    Holds,
    /// The test failed.
    Fails,
}

/// Results by property and backend.
#[derive(Debug, Default)]
pub struct Table {
    backends: Vec<String>,
    properties: BTreeMap<String, BTreeMap<String, Outcome>>,
}

impl Table {
    /// Parses lines like `test shm::many_ports_do_not_mix ... ok`; ignores others.
    pub fn read(&mut self, printed: &str) {
        for line in printed.lines() {
            let Some((name, outcome)) =
                line.strip_prefix("test ").and_then(|line| line.split_once(" ... "))
            else {
                continue;
            };
            let Some((backend, property)) = name.split_once("::") else { continue };
            if !self.backends.iter().any(|known| known == backend) {
                self.backends.push(backend.to_owned());
            }
            let outcome = if outcome.trim() == "ok" { Outcome::Holds } else { Outcome::Fails };
            let row = self.properties.entry(property.replace('_', " ")).or_default();
            row.insert(backend.to_owned(), outcome);
        }
    }

    /// Whether there are results, and all of them passed.
    #[must_use]
    pub fn is_green(&self) -> bool {
        let whole = |row: &BTreeMap<String, Outcome>| {
            row.len() == self.backends.len() && row.values().all(|of| *of == Outcome::Holds)
        };
        !self.properties.is_empty() && self.properties.values().all(whole)
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.properties.keys().map(String::len).max().unwrap_or_default();
        write!(f, "{:width$}", "")?;
        for backend in &self.backends {
            write!(f, "  {backend:>7}")?;
        }
        for (property, row) in &self.properties {
            write!(f, "\n{property:width$}")?;
            for backend in &self.backends {
                let mark = match row.get(backend) {
                    Some(Outcome::Holds) => "ok",
                    Some(Outcome::Fails) => "FAILS",
                    None => "missing",
                };
                write!(f, "  {mark:>7}")?;
            }
        }
        write!(f, "\n{} properties, {} backends", self.properties.len(), self.backends.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_green_only_when_each_property_holds_on_each_backend() {
        let mut table = Table::default();
        assert!(!table.is_green(), "nothing ran");
        table
            .read("running 2 tests\ntest local::ports_mix_not ... ok\n\ntest result: ok. 2 passed");
        assert!(table.is_green());
        table.read("test shm::ports_mix_not ... ok\ntest shm::samples_travel ... ok");
        assert!(!table.is_green(), "one is missing on local");
        table.read("test local::samples_travel ... ok");
        assert!(table.is_green());
        assert_eq!(
            table.to_string(),
            "                  local      shm\n\
             ports mix not        ok       ok\n\
             samples travel       ok       ok\n\
             2 properties, 2 backends"
        );
        table.read("test shm::samples_travel ... FAILED");
        assert!(!table.is_green() && table.to_string().contains("FAILS"));
    }
}
