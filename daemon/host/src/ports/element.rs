//! One buffer of a port, and what it is bound to. One of the few unsafe modules.
#![allow(unsafe_code)]

use std::cell::UnsafeCell;
use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use genom_description::model::PortDirection;
use genom_middleware::{PublishError, Publisher, ReadError, Reading, Subscription};
use genom_types::{DataType, Record, Zones};

use super::snapshot::Snapshot;
use crate::cxx::{CxxType, Object};

/// Why a method of a port failed (genom3.md 7.8).
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Failure {
    NoSuchInport,
    NoSuchOutport,
    PortIo,
    Serialization,
    /// With a message.
    Middleware(String),
    /// With an `errno` value.
    System(i32),
}

/// A simple port, or one element of a multiple one.
///
/// Codels that share a port exclude each other (genom3.md 4.5). Methods called in violation of
/// that, by threads of a library, fail instead of causing a data race.
pub(super) struct Element {
    inner: UnsafeCell<Inner>,
    /// Address of the buffer, which never changes.
    address: usize,
    /// Guard zones around the buffer.
    zones: Zones,
    /// Whether `data` returns the buffer (otherwise null).
    visible: AtomicBool,
    /// Whether a thread is using `inner`.
    busy: AtomicBool,
    snapshot: Snapshot,
    /// Values that codels have written, on all elements of the port.
    written: Arc<AtomicU64>,
}

struct Inner {
    buffer: Record,
    /// The object that codels in C++ use: `read` fills it from the buffer, `write` copies it into
    /// the buffer.
    object: Option<Object>,
    link: Link,
}

/// What an element is bound to.
pub(super) enum Link {
    /// An in port.
    In(Option<Box<dyn Subscription>>),
    /// An out port.
    Out(Option<Box<dyn Publisher>>),
}

impl Link {
    /// An element without a connection.
    pub(super) fn unbound(direction: PortDirection) -> Self {
        match direction {
            PortDirection::In => Self::In(None),
            PortDirection::Out => Self::Out(None),
        }
    }
}

// SAFETY: `inner` is accessed through `with` only, which admits one thread at a time.
unsafe impl Sync for Element {}
// SAFETY: all fields are `Send`.
unsafe impl Send for Element {}

impl Element {
    /// An empty buffer, with a C++ object for codels in that language.
    pub(super) fn new(
        ty: &DataType,
        cxx: Option<&CxxType>,
        link: Link,
        written: &Arc<AtomicU64>,
    ) -> Self {
        let mut buffer = Record::new(ty);
        let object = cxx.map(Object::new);
        let address = object.as_ref().map_or(buffer.as_mut_ptr(), Object::at) as usize;
        let zones = object.as_ref().map_or(buffer.zones(), Object::zones);
        let visible = AtomicBool::new(matches!(link, Link::Out(_)));
        Self {
            inner: UnsafeCell::new(Inner { buffer, object, link }),
            address,
            zones,
            visible,
            busy: AtomicBool::new(false),
            snapshot: Snapshot::new(ty),
            written: Arc::clone(written),
        }
    }

    /// Runs `work`, unless another thread is using the element.
    fn with<R>(&self, work: impl FnOnce(&mut Inner) -> R) -> Option<R> {
        if self.busy.swap(true, Ordering::Acquire) {
            return None;
        }
        let release = Release(&self.busy);
        // SAFETY: `busy` was clear and is set now: no other thread is here until it is cleared.
        let result = work(unsafe { &mut *self.inner.get() });
        drop(release);
        Some(result)
    }

    /// Address of the buffer; 0 while there is no value (genom3.md 7.8).
    pub(super) fn data(&self) -> usize {
        if self.visible.load(Ordering::Relaxed) { self.address } else { 0 }
    }

    /// Guard zones around the buffer.
    pub(super) fn zones(&self) -> Zones {
        self.zones
    }

    /// Drops ownership of buffers that are in `seen`, since other records own them too.
    pub(super) fn give_up_shared(&self, seen: &mut HashSet<usize>) {
        let _ = self.with(|inner| inner.buffer.give_up_shared(seen));
    }

    /// Stores the next value in the buffer.
    pub(super) fn read(&self) -> Result<(), Failure> {
        let read = self.with(|inner| {
            let Link::In(Some(subscription)) = &mut inner.link else {
                return Err(Failure::NoSuchInport);
            };
            let reading = subscription.read(&mut inner.buffer);
            self.visible
                .store(matches!(reading, Ok(Reading::New | Reading::Same)), Ordering::Relaxed);
            match reading {
                Ok(Reading::New) => {
                    if let Some(object) = &mut inner.object {
                        object.set(&inner.buffer);
                    }
                    // SAFETY: `with` admits one caller at a time.
                    unsafe { self.snapshot.offer(&inner.buffer) };
                    Ok(())
                }
                Ok(Reading::Same | Reading::Never) => Ok(()),
                Err(ReadError::Serialization) => Err(Failure::Serialization),
                Err(_) => Err(Failure::PortIo),
            }
        });
        read.unwrap_or(Err(Failure::PortIo))
    }

    /// Publishes the buffer.
    pub(super) fn write(&self) -> Result<(), Failure> {
        let written = self.with(|inner| {
            if let Some(object) = &inner.object {
                object.get(&mut inner.buffer);
            }
            Self::publish(&self.snapshot, &mut inner.link, &inner.buffer)?;
            self.written.fetch_add(1, Ordering::Relaxed);
            Ok(())
        });
        written.unwrap_or(Err(Failure::PortIo))
    }

    /// Publishes a value other than the buffer's.
    pub(super) fn write_value(&self, value: &Record) -> Result<(), Failure> {
        let written = self.with(|inner| Self::publish(&self.snapshot, &mut inner.link, value));
        written.unwrap_or(Err(Failure::PortIo))
    }

    /// Puts back the last value: an out port publishes it, an in port shows it.
    pub(super) fn restore(&self, value: &Record) -> Result<(), Failure> {
        let restored = self.with(|inner| {
            inner.buffer.copy_from(value).map_err(|_| Failure::Serialization)?;
            if let Some(object) = &mut inner.object {
                object.set(&inner.buffer);
            }
            if let Link::Out(_) = inner.link {
                return Self::publish(&self.snapshot, &mut inner.link, &inner.buffer);
            }
            self.visible.store(true, Ordering::Relaxed);
            // SAFETY: `with` admits one caller at a time.
            unsafe { self.snapshot.offer(&inner.buffer) };
            Ok(())
        });
        restored.unwrap_or(Err(Failure::PortIo))
    }

    /// Publishes a value. Called within `with` only.
    fn publish(snapshot: &Snapshot, link: &mut Link, value: &Record) -> Result<(), Failure> {
        let Link::Out(Some(publisher)) = link else { return Err(Failure::NoSuchOutport) };
        publisher.publish(value).map_err(|error| match error {
            PublishError::Serialization => Failure::Serialization,
            _ => Failure::PortIo,
        })?;
        // SAFETY: `with` admits one caller at a time.
        unsafe { snapshot.offer(value) };
        Ok(())
    }

    /// Binds the element; returns what it was bound to. Not for codels, since it waits.
    pub(super) fn bind(&self, link: Link) -> Link {
        let mut link = Some(link);
        loop {
            let exchanged = self.with(|inner| {
                let new = link.take()?;
                // An in port has no value until one of the new connection was read.
                self.visible.store(matches!(new, Link::Out(_)), Ordering::Relaxed);
                Some(std::mem::replace(&mut inner.link, new))
            });
            if let Some(Some(old)) = exchanged {
                return old;
            }
            std::thread::yield_now();
        }
    }

    /// Result of `look` for the last value read or written.
    pub(super) fn look<T>(&self, look: impl FnOnce(&Record) -> T) -> Option<T> {
        self.snapshot.look(look)
    }

    /// The last value read or written, if it was copied.
    pub(super) fn last(&self) -> Option<Record> {
        self.snapshot.last()
    }
}

/// Clears the flag, also when the middleware panics.
struct Release<'a>(&'a AtomicBool);

impl Drop for Release<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Release);
    }
}
