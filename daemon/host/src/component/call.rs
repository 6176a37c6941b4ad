//! A codel bound to the memory of one run.

use std::ffi::c_void;

use genom_description::model::CodelIx;

use super::codel::{From, Prepared};
use super::inner::Inner;
use super::way::Way;
use crate::ffi::Class;

/// A codel with its arguments.
pub(super) struct Call {
    pub(super) codel: CodelIx,
    /// For libffi: the address of the value of each argument, and of the context.
    pub(super) arguments: Box<[*mut c_void]>,
    /// Values of arguments that are pointers; `arguments` points here.
    pub(super) pointers: Box<[*mut c_void]>,
    /// Index of each argument behind a sequence, whose address is found before each call.
    pub(super) dynamic: Box<[(usize, *mut u8)]>,
}

/// Values in which the paths of arguments begin.
pub(super) struct Roots {
    pub(super) ids: *mut u8,
    pub(super) input: *mut u8,
    pub(super) output: *mut u8,
    pub(super) local: *mut u8,
}

impl Roots {
    /// The path of an argument and the value it begins in; `None` for handles.
    fn way<'a>(&self, from: &'a From) -> Option<(&'a Way, *mut u8)> {
        match from {
            From::Ids(way) => Some((way, self.ids)),
            From::Input(way) => Some((way, self.input)),
            From::Output(way) => Some((way, self.output)),
            From::Local(way) => Some((way, self.local)),
            From::Port(_) | From::Remote(_) => None,
        }
    }
}

impl Call {
    pub(super) fn new(inner: &Inner, codel: CodelIx, prepared: &Prepared, roots: &Roots) -> Self {
        let count = prepared.arguments.len();
        let all = count + usize::from(prepared.context);
        let mut call = Self {
            codel,
            arguments: vec![std::ptr::null_mut(); all].into(),
            pointers: vec![std::ptr::null_mut(); all].into(),
            dynamic: Box::default(),
        };
        let mut dynamic = Vec::new();
        for (rank, argument) in prepared.arguments.iter().enumerate() {
            let at = match &argument.from {
                From::Port(port) => inner.ports.handle(*port).cast_mut().cast(),
                From::Remote(remote) => inner.remotes.handle(*remote).cast_mut().cast(),
                from => {
                    let Some((way, root)) = roots.way(from) else { continue };
                    match way.constant_offset() {
                        Some(offset) => root.wrapping_add(offset),
                        None => {
                            dynamic.push((rank, root));
                            continue;
                        }
                    }
                }
            };
            call.set(rank, argument.class, at);
        }
        // The context, which is set at each call.
        if prepared.context {
            call.set(count, Class::Address, std::ptr::null_mut());
        }
        call.dynamic = dynamic.into();
        call
    }

    /// Sets argument `rank` to the datum at `at`, by value or by address (genom3.md 5.5).
    pub(super) fn set(&mut self, rank: usize, class: Class, at: *mut u8) {
        self.arguments[rank] = match class {
            Class::Value(_) | Class::Held => at.cast(),
            Class::Address => {
                self.pointers[rank] = at.cast();
                (&raw mut self.pointers[rank]).cast()
            }
        };
    }
}
