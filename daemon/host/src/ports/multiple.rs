//! The elements of a multiple port, by name.

use std::collections::{BTreeMap, HashSet};
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use genom_description::model::{PortDirection, PortIx};
use genom_runtime::body::Opener;
use genom_types::{DataType, Record};

use super::element::{Element, Failure, Link};
use crate::cxx::CxxType;

/// Longest name of an element, in bytes.
pub(super) const LONGEST: usize = 128;
/// `errno` of an element that does not exist.
const ENOENT: i32 = 2;
/// `errno` of a name longer than [`LONGEST`].
pub(super) const ENAMETOOLONG: i32 = 36;

/// The elements of one multiple port.
pub(super) struct Elements {
    port: PortIx,
    direction: PortDirection,
    ty: DataType,
    cxx: Option<CxxType>,
    elements: Mutex<BTreeMap<Box<[u8]>, Arc<Element>>>,
    written: Arc<AtomicU64>,
    opener: Arc<OnceLock<Box<dyn Opener>>>,
}

impl Elements {
    /// Without elements.
    pub(super) fn new(
        port: PortIx,
        direction: PortDirection,
        ty: &DataType,
        cxx: Option<&CxxType>,
        opener: Arc<OnceLock<Box<dyn Opener>>>,
        written: Arc<AtomicU64>,
    ) -> Self {
        let (cxx, ty, elements) = (cxx.cloned(), ty.clone(), Mutex::default());
        Self { port, direction, ty, cxx, elements, written, opener }
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<Box<[u8]>, Arc<Element>>> {
        self.elements.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The element with this name.
    pub(super) fn get(&self, name: &[u8]) -> Option<Arc<Element>> {
        self.lock().get(name).map(Arc::clone)
    }

    /// Drops ownership of buffers that are in `seen`, since other records own them too.
    pub(super) fn give_up_shared(&self, seen: &mut HashSet<usize>) {
        self.lock().values().for_each(|element| element.give_up_shared(seen));
    }

    /// The element with this name, created if it does not exist.
    fn get_or_make(&self, name: &str) -> Arc<Element> {
        let cxx = self.cxx.as_ref();
        let link = || Link::unbound(self.direction);
        let make = || Arc::new(Element::new(&self.ty, cxx, link(), &self.written));
        Arc::clone(self.lock().entry(name.as_bytes().into()).or_insert_with(make))
    }

    /// Binds an element. One that is disconnected stays, with its buffer, since a codel may hold
    /// its address.
    pub(super) fn bind(&self, name: &str, link: Link) {
        drop(self.get_or_make(name).bind(link));
    }

    /// Opens an element of an out port; one that is open already is kept (genom3.md 7.8).
    pub(super) fn open(&self, name: Option<&[u8]>) -> Result<(), Failure> {
        let name = checked(name)?;
        if self.get(name.as_bytes()).is_some() {
            return Ok(());
        }
        let opener = self.opener.get().ok_or(Failure::NoSuchOutport)?;
        let publisher =
            opener.open(self.port, name).map_err(|error| Failure::Middleware(error.to_string()))?;
        self.bind(name, Link::Out(Some(publisher)));
        Ok(())
    }

    /// Puts back the last value of an element. One of an out port is opened; one of an in port that
    /// is not connected does not exist.
    pub(super) fn restore(&self, name: &str, value: &Record) -> Result<(), Failure> {
        if self.direction == PortDirection::Out {
            self.open(Some(name.as_bytes()))?;
        }
        self.get(name.as_bytes()).map_or(Ok(()), |element| element.restore(value))
    }

    /// Closes an element of an out port.
    pub(super) fn close(&self, name: Option<&[u8]>) -> Result<(), Failure> {
        let removed = name.and_then(|name| self.lock().remove(name));
        let element = removed.ok_or(Failure::System(ENOENT))?;
        drop(element.bind(Link::Out(None)));
        if let (Some(opener), Some(name)) = (self.opener.get(), name) {
            // It was opened with this name, so it is UTF-8.
            opener.close(self.port, &String::from_utf8_lossy(name));
        }
        Ok(())
    }
}

/// Checks a name that becomes part of an address. It may contain slashes, as in `left/jpeg`: the
/// first one of an address ends the instance, the second the port, and others belong to the
/// element.
fn checked(name: Option<&[u8]>) -> Result<&str, Failure> {
    let refuse = |why: &str| Err(Failure::Middleware(format!("name of a port's element: {why}")));
    let Some(name) = name else { return refuse("NULL") };
    match std::str::from_utf8(name) {
        Ok("") => refuse("empty"),
        Ok(name) if name.split('/').any(str::is_empty) => {
            refuse(&format!("{name:?} has nothing before, after or between its slashes"))
        }
        Ok(name) if name.chars().any(|c| c.is_control() || c.is_whitespace()) => {
            refuse(&format!("{name:?} has a blank or a control character"))
        }
        Ok(name) => Ok(name),
        Err(_) => refuse("no UTF-8"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_would_break_an_address_are_refused() {
        assert!(matches!(checked(None), Err(Failure::Middleware(_))));
        for name in [&b""[..], b"/", b"/a", b"a/", b"a//b", b"a b", b"\xff", b"\n"] {
            assert!(matches!(checked(Some(name)), Err(Failure::Middleware(_))), "{name:?}");
        }
        for name in ["left_arm-1", "left/jpeg", "a/b/c"] {
            assert_eq!(checked(Some(name.as_bytes())), Ok(name));
        }
    }
}
