//! C++ values of types known at run time: construction, destruction, and exchange with values in C
//! layout. One of the few unsafe modules.
#![allow(unsafe_code)]

use std::fmt;

use genom_types::{Record, Room, Zones};

use super::layout::CxxType;
use super::life::{drop_inside, make};
use super::transfer::{assign, read, write};

/// An owned C++ value, at an address that never changes.
pub(crate) struct Object {
    ty: CxxType,
    room: Room,
}

// SAFETY: the object owns the value, and nothing in it is bound to a thread.
unsafe impl Send for Object {}
// SAFETY: through a shared reference the value is only read.
unsafe impl Sync for Object {}

impl fmt::Debug for Object {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Object({})", self.ty.c().name())
    }
}

impl Object {
    /// An empty value; numbers are zero.
    pub(crate) fn new(ty: &CxxType) -> Self {
        let room = Room::new(ty.size());
        // SAFETY: fresh, zeroed memory of the type's size and alignment.
        unsafe { make(&ty.graph, ty.node, room.at()) };
        Self { ty: ty.clone(), room }
    }

    /// Address of the C++ value.
    pub(crate) fn at(&self) -> *mut u8 {
        self.room.at()
    }

    /// The guard zones around the value, which show whether something was written past it.
    pub(crate) fn zones(&self) -> Zones {
        self.room.zones()
    }

    /// Type of the value.
    pub(crate) fn ty(&self) -> &CxxType {
        &self.ty
    }

    /// Makes the value empty.
    pub(crate) fn clear(&mut self) {
        // SAFETY: the object owns the value, which is constructed again after it was destroyed.
        unsafe {
            drop_inside(&self.ty.graph, self.ty.node, self.room.at());
            self.room.at().write_bytes(0, self.ty.size());
            make(&self.ty.graph, self.ty.node, self.room.at());
        }
    }

    /// Sets the value to that of `from`, which has the same type.
    pub(crate) fn set(&mut self, from: &Record) {
        // SAFETY: both hold values of the type; callers use the same type for both.
        unsafe { to_cxx(&self.ty, from.as_ptr(), self.room.at()) }
    }

    /// Copies the value to `to`, which has the same type.
    pub(crate) fn get(&self, to: &mut Record) {
        // SAFETY: as above.
        unsafe { to_c(&self.ty, self.room.at(), to.as_mut_ptr()) }
    }
}

impl Drop for Object {
    fn drop(&mut self) {
        // SAFETY: it has held a value since it was made.
        unsafe { drop_inside(&self.ty.graph, self.ty.node, self.room.at()) }
    }
}

/// Makes the C++ value at `to` equal to the C value at `from`.
///
/// # Safety
/// Both hold values of the type, in their languages, that nobody else uses meanwhile.
pub(crate) unsafe fn to_cxx(ty: &CxxType, from: *const u8, to: *mut u8) {
    // SAFETY: the caller's promise.
    unsafe { read(&ty.graph, ty.node, from, to, 0) }
}

/// Makes the C value at `to` equal to the C++ value at `from`.
///
/// # Safety
/// As for [`to_cxx`].
pub(crate) unsafe fn to_c(ty: &CxxType, from: *const u8, to: *mut u8) {
    // SAFETY: the caller's promise.
    unsafe { write(&ty.graph, ty.node, from, to, 0) }
}

/// Makes one C++ value equal to another.
///
/// # Safety
/// As for [`to_cxx`].
pub(crate) unsafe fn copy(ty: &CxxType, from: *const u8, to: *mut u8) {
    // SAFETY: the caller's promise.
    unsafe { assign(&ty.graph, ty.node, from, to, 0) }
}

/// Constructs a C++ value in the memory at `to`, equal to the C value at `from`.
///
/// # Safety
/// `to` is memory for the type, and `from` holds a value of it.
pub(super) unsafe fn construct(ty: &CxxType, from: *const u8, to: *mut u8) {
    // SAFETY: the caller's promise.
    unsafe {
        to.write_bytes(0, ty.size());
        make(&ty.graph, ty.node, to);
        to_cxx(ty, from, to);
    }
}

/// Destroys the C++ value at `at`.
///
/// # Safety
/// `at` holds a value of the type, which is not used any more.
pub(super) unsafe fn destroy(ty: &CxxType, at: *mut u8) {
    // SAFETY: the caller's promise.
    unsafe { drop_inside(&ty.graph, ty.node, at) }
}
