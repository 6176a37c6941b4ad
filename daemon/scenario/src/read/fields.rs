//! The keys of a table, taken one by one; those that nobody takes are mistakes.

use std::cell::RefCell;
use std::ops::Range;

use genom_nearest::suggest;
use genom_protocol::Address;
use serde::de::DeserializeOwned;
use serde_json::Value;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use super::found::Found;
use super::value::{Shown, json};
use crate::duration::nanoseconds;

/// A value with its place.
pub(crate) type Spot<'t, 'i> = &'t Spanned<DeValue<'i>>;

/// A table that is read.
pub(crate) struct Fields<'f, 't, 'i> {
    table: &'t DeTable<'i>,
    /// The whole of it, for what is missing.
    pub(crate) span: Range<usize>,
    pub(crate) found: &'f Found,
    /// Keys that somebody asked for, in that order.
    asked: RefCell<Vec<&'static str>>,
}

impl<'f, 't, 'i> Fields<'f, 't, 'i> {
    pub(crate) fn new(table: &'t DeTable<'i>, span: Range<usize>, found: &'f Found) -> Self {
        Self { table, span, found, asked: RefCell::default() }
    }

    /// The table that a value is; a mistake if it is none.
    pub(crate) fn of(value: Spot<'t, 'i>, what: &str, found: &'f Found) -> Option<Self> {
        match value.get_ref() {
            DeValue::Table(table) => Some(Self::new(table, value.span(), found)),
            other => {
                found.add(value.span(), format!("{what} is a table, not {}", Shown(other)), None);
                None
            }
        }
    }

    /// The names of all keys, with their places.
    pub(crate) fn keys(&self) -> impl Iterator<Item = (&'t str, Range<usize>)> {
        self.table.keys().map(|key| (key.get_ref().as_ref(), key.span()))
    }

    /// The value of a key.
    pub(crate) fn get(&self, key: &'static str) -> Option<Spot<'t, 'i>> {
        self.asked.borrow_mut().push(key);
        self.table.get(key)
    }

    /// Keys that there may be, for suggestions.
    pub(crate) fn offer(&self, keys: impl IntoIterator<Item = &'static &'static str>) {
        self.asked.borrow_mut().extend(keys.into_iter().copied());
    }

    /// Whether there is such a key.
    pub(crate) fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    fn wrong<T>(&self, value: Spot<'_, '_>, key: &str, wanted: &str) -> Option<T> {
        let message = format!("`{key}` is {wanted}, not {}", Shown(value.get_ref()));
        self.found.add(value.span(), message, None);
        None
    }

    /// A text.
    pub(crate) fn text(&self, key: &'static str) -> Option<&'t str> {
        let value = self.get(key)?;
        value.get_ref().as_str().or_else(|| self.wrong(value, key, "a text"))
    }

    /// A boolean.
    pub(crate) fn boolean(&self, key: &'static str) -> Option<bool> {
        let value = self.get(key)?;
        value.get_ref().as_bool().or_else(|| self.wrong(value, key, "true or false"))
    }

    /// A whole number from `least`.
    pub(crate) fn count(&self, key: &'static str, least: u64) -> Option<u64> {
        let value = self.get(key)?;
        let number = json(value, self.found)?.as_u64().filter(|number| *number >= least);
        number.or_else(|| self.wrong(value, key, &format!("a whole number from {least}")))
    }

    /// The greatest difference of numbers; 0 if nothing is said.
    pub(crate) fn tolerance(&self) -> f64 {
        let read = || {
            let value = self.get("tolerance")?;
            let number = json(value, self.found)?.as_f64().filter(|it| *it >= 0.0);
            number.or_else(|| self.wrong(value, "tolerance", "a number from 0"))
        };
        read().unwrap_or(0.0)
    }

    /// A time, such as `10ms`.
    pub(crate) fn time(&self, key: &'static str) -> Option<u64> {
        let value = self.get(key)?;
        let Some(text) = value.get_ref().as_str() else {
            return self.wrong(value, key, "a time such as \"10ms\"");
        };
        let told = |error| self.found.add(value.span(), format!("`{key}`: {error}"), None);
        nanoseconds(text).map_err(told).ok()
    }

    /// `COMPONENT/NAME`.
    pub(crate) fn address(&self, key: &'static str) -> Option<Address> {
        let text = self.text(key)?;
        let told = |error: &dyn std::fmt::Display| {
            let span = self.table.get(key).map_or(self.span.clone(), Spanned::span);
            self.found.add(span, error.to_string(), None);
        };
        text.parse().map_err(|error| told(&error)).ok()
    }

    /// Any value, as JSON.
    pub(crate) fn value(&self, key: &'static str) -> Option<Value> {
        json(self.get(key)?, self.found)
    }

    /// A table of any members, as JSON.
    pub(crate) fn members(&self, key: &'static str) -> Option<Value> {
        let value = self.get(key)?;
        match json(value, self.found)? {
            members @ Value::Object(_) => Some(members),
            _ => self.wrong(value, key, "a table such as { goal = 1.0 }"),
        }
    }

    /// The elements of an array.
    pub(crate) fn list(&self, key: &'static str) -> impl Iterator<Item = Spot<'t, 'i>> {
        let value = self.get(key);
        let array = value.and_then(|value| match value.get_ref() {
            DeValue::Array(array) => Some(array),
            _ => self.wrong(value, key, "an array"),
        });
        array.into_iter().flat_map(|array| array.iter())
    }

    /// An array of texts.
    pub(crate) fn texts(&self, key: &'static str) -> Vec<&'t str> {
        let text = |value: Spot<'t, 'i>| {
            value.get_ref().as_str().or_else(|| self.wrong(value, key, "an array of texts"))
        };
        self.list(key).filter_map(text).collect()
    }

    /// Says that a key is missing.
    pub(crate) fn missing(&self, key: &str, help: &str) {
        self.found.add(self.span.clone(), format!("`{key}` is missing"), Some(help.to_owned()));
    }

    /// Keys that nobody asked for are mistakes.
    pub(crate) fn finish(self, what: &str) {
        let asked = self.asked.borrow();
        for (key, span) in self.keys() {
            if !asked.contains(&key) {
                let message = format!("{what} has no key `{key}`");
                self.found.add(span, message, Some(suggest(key, asked.iter().copied())));
            }
        }
    }
}

/// Reads a value as a type of the control plane; its mistakes are told at their places.
pub(crate) fn typed<T: DeserializeOwned>(
    value: Spot<'_, '_>,
    what: &str,
    found: &Found,
) -> Option<T> {
    let told = |error: toml::de::Error| {
        let message = error.message().trim().replace('\n', ", ");
        let help = genom_nearest::nearest_key(&message);
        let help = help.map(|key| format!("did you mean `{key}`?"));
        // What is unknown is told without the list of all that is known.
        let message = match message.split_once(", expected one of") {
            Some((short, _)) if help.is_some() => short.to_owned(),
            _ => message,
        };
        found.add(error.span().unwrap_or(value.span()), format!("{what}: {message}"), help);
    };
    T::deserialize(ValueDeserializer::from(value.clone())).map_err(told).ok()
}
