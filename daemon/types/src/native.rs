//! `native` members of a type, pointers to what only codels know, and what becomes of them when another
//! library goes on with a value.

use std::collections::{BTreeMap, BTreeSet};

use crate::{DataType, Kind};

/// Whether a path, with indices, is that of a native member of this type.
#[must_use]
pub fn is_native(ty: &DataType, path: &str) -> bool {
    let parts = path.split('[').map(|part| part.split_once(']').map_or(part, |(_, rest)| rest));
    declared(ty).contains_key(&parts.collect::<String>())
}

/// A native member.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Native {
    /// Name of its type in C.
    pub name: String,
    /// Whether its place does not depend on values.
    pub fixed: bool,
}

/// Native members of a type by their paths, without indices.
#[must_use]
pub fn declared(ty: &DataType) -> BTreeMap<String, Native> {
    fn add(ty: &DataType, path: &str, fixed: bool, all: &mut BTreeMap<String, Native>) {
        if ty.is_fixed_size() {
            return;
        }
        if let Kind::Native { name } = ty.kind() {
            all.insert(path.to_owned(), Native { name: name.to_c(), fixed });
        }
        let inside = fixed && matches!(ty.kind(), Kind::Array { .. } | Kind::Struct { .. });
        if let Some(element) = ty.element() {
            add(&element, path, inside, all);
        }
        for rank in 0..ty.member_count() {
            if let (Some(member), Some(name)) = (ty.member(rank), ty.member_name(rank)) {
                add(&member, &joined(path, name), inside, all);
            }
        }
    }
    let mut all = BTreeMap::new();
    add(ty, "", true, &mut all);
    all
}

fn joined(path: &str, member: &str) -> String {
    if path.is_empty() { member.to_owned() } else { format!("{path}.{member}") }
}

/// A part of a record: its type, and its offset.
type Part<'a> = (&'a DataType, usize);

/// A native member that values of two types have at the same path.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'a> {
    /// Its path with indices.
    pub path: &'a str,
    /// And without.
    pub plain: &'a str,
    /// Name of its first type in descriptions, and its offset in the value.
    pub old: (&'a str, usize),
    /// Name of its second type in C, and its offset.
    pub new: (&'a str, usize),
}

/// Calls a function for each native member that is in values of both types, outside of sequences,
/// optionals and unions.
///
/// # Errors
/// Those of the function, after which it is not called again.
pub fn for_each_pair<E>(
    old: &DataType,
    new: &DataType,
    each: &mut dyn FnMut(Pair<'_>) -> Result<(), E>,
) -> Result<(), E> {
    let mut walk = Walk { each, path: String::new(), plain: String::new() };
    walk.value((old, 0), (new, 0))
}

/// Goes through two types at the same time.
struct Walk<'a, E> {
    each: &'a mut dyn FnMut(Pair<'_>) -> Result<(), E>,
    /// Where it is: with indices, and without.
    path: String,
    plain: String,
}

impl<E> Walk<'_, E> {
    fn value(&mut self, (old, from): Part<'_>, (new, to): Part<'_>) -> Result<(), E> {
        if new.is_fixed_size() {
            return Ok(());
        }
        match (old.kind(), new.kind()) {
            (Kind::Native { name: old }, Kind::Native { name: new }) => {
                let (old, new) = (old.to_string(), new.to_c());
                let (path, plain) = (self.path.as_str(), self.plain.as_str());
                (self.each)(Pair { path, plain, old: (&old, from), new: (&new, to) })
            }
            (Kind::Array { length: before, .. }, Kind::Array { length, .. }) => {
                let (Some(old), Some(new)) = (old.element(), new.element()) else { return Ok(()) };
                let path = self.path.len();
                for index in 0..(*before).min(*length) as usize {
                    self.path.push_str(&format!("[{index}]"));
                    let (from, to) = (from + index * old.size(), to + index * new.size());
                    self.value((&old, from), (&new, to))?;
                    self.path.truncate(path);
                }
                Ok(())
            }
            (Kind::Struct { .. }, Kind::Struct { .. }) => self.members((old, from), (new, to)),
            _ => Ok(()),
        }
    }

    fn members(&mut self, (old, from): Part<'_>, (new, to): Part<'_>) -> Result<(), E> {
        for rank in 0..new.member_count() {
            let Some(name) = new.member_name(rank) else { continue };
            let Some(before) = old.member_index(name) else { continue };
            let (Some(was), Some(is)) = (old.member(before), new.member(rank)) else { continue };
            let (Some(at), Some(to_at)) = (old.member_offset(before), new.member_offset(rank))
            else {
                continue;
            };
            let (path, plain) = (self.path.clone(), self.plain.clone());
            (self.path, self.plain) = (joined(&path, name), joined(&plain, name));
            self.value((&was, from + at), (&is, to + to_at))?;
            (self.path, self.plain) = (path, plain);
        }
        Ok(())
    }
}

/// Whose data is converted.
#[derive(Clone, Copy, Debug)]
pub struct Former<'a> {
    /// Instance name.
    pub instance: &'a str,
    /// Version of the component before.
    pub version: &'a str,
    /// Digest of its description.
    pub digest: &'a str,
}

/// A function refused what it was given.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{function} of the new library returned {status} for {member} of the ids")]
pub struct NotConverted {
    /// Its name.
    pub function: String,
    /// Path of the member.
    pub member: String,
    /// What it returned.
    pub status: i32,
}

/// Name of the function that converts a native type.
#[must_use]
pub fn symbol(native: &str) -> String {
    format!("genom_convert_{native}")
}

/// A line for each native member of the IDS: what became of it. Those of `done` were
/// converted, and types for which `offers` is true have a function.
#[must_use]
pub fn lines(
    from: &DataType,
    to: &DataType,
    done: &BTreeSet<String>,
    offers: impl Fn(&str) -> bool,
) -> Vec<String> {
    let (old, new) = (declared(from), declared(to));
    let now = new.iter().map(|(path, member)| {
        let name = symbol(&member.name);
        if done.contains(path) {
            format!("{path} is converted by {name}")
        } else if !old.contains_key(path) {
            format!("{path} is new")
        } else if !member.fixed {
            format!(
                "{path} starts anew: native data in sequences, optionals and unions is not converted"
            )
        } else if offers(&member.name) {
            format!("{path} starts anew: it has another place")
        } else {
            format!("{path} starts anew: the library has no {name}")
        }
    });
    let gone = old.keys().filter(|path| !new.contains_key(*path));
    now.chain(gone.map(|path| format!("{path} is gone"))).collect()
}
