//! Ports (genom3.md 5.7, 7.8).

use std::ffi::{CStr, c_char};
use std::fmt;
use std::marker::PhantomData;

use crate::abi::{Passing, TypeDescriptor};
use crate::argument::ByMut;
use crate::context::ContextInterface;
use crate::{Context, Data, Thrown};

type Raw = *const ContextInterface;

#[repr(C)]
struct Handle<T> {
    data: unsafe extern "C" fn(Raw) -> *mut T,
    /// `read` of an in port, or `write` of an out port.
    exchange: unsafe extern "C" fn(Raw) -> *const c_char,
}

#[repr(C)]
struct MultipleInHandle<T> {
    data: unsafe extern "C" fn(*const c_char, Raw) -> *mut T,
    read: unsafe extern "C" fn(*const c_char, Raw) -> *const c_char,
}

#[repr(C)]
struct MultipleOutHandle<T> {
    data: unsafe extern "C" fn(*const c_char, Raw) -> *mut T,
    write: unsafe extern "C" fn(*const c_char, Raw) -> *const c_char,
    open: unsafe extern "C" fn(*const c_char, Raw) -> *const c_char,
    close: unsafe extern "C" fn(*const c_char, Raw) -> *const c_char,
}

/// Converts the result of a method: `genom_ok`, or an exception that the port recorded in the
/// context.
pub(crate) fn checked(event: *const c_char) -> Result<(), Thrown> {
    if event.is_null() { Ok(()) } else { Err(Thrown(event)) }
}

macro_rules! port {
    ($(#[$doc:meta])* $name:ident, $handle:ident, $passing:ident) => {
        $(#[$doc])*
        pub struct $name<T> {
            handle: *const $handle<T>,
            /// Points to a buffer of `T`, which only this codel uses while it runs.
            data: PhantomData<*mut T>,
        }

        impl<T> fmt::Debug for $name<T> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(stringify!($name))
            }
        }

        impl<T: Data> $name<T> {
            fn methods(&self) -> &$handle<T> {
                // SAFETY: the host's handle outlives the call of the codel it was passed to
                // (`hold`), and a port is only ever lent to the codel for that time.
                unsafe { &*self.handle }
            }
        }

        impl<T: Data> ByMut for $name<T> {
            type Abi = *const std::ffi::c_void;
            type Held = Self;
            const PASSING: Passing = Passing::$passing;
            const TYPE: *const TypeDescriptor = T::TYPE;

            unsafe fn hold(abi: *const std::ffi::c_void) -> Self {
                Self { handle: abi.cast(), data: PhantomData }
            }

            fn lend(held: &mut Self) -> &mut Self {
                held
            }
        }
    };
}

port! {
    /// `port in T`: the last value read stays until the next [`read`](Self::read).
    ///
    /// ```
    /// use genom::{Context, Event, InPort, OutPort, Thrown, event};
    ///
    /// #[genom::codel]
    /// fn demo_follow(
    ///     target: &mut InPort<f64>,
    ///     command: &mut OutPort<f64>,
    ///     context: &Context,
    /// ) -> Result<Event, Thrown> {
    ///     // Nothing to follow: the port is unconnected, or was never written.
    ///     let Some(target) = target.latest(context).copied() else {
    ///         return Ok(event!("::demo::pause::wait"));
    ///     };
    ///     command.publish(0.5 * target, context)?;
    ///     Ok(event!("::demo::pause::follow"))
    /// }
    /// # fn main() {}
    /// ```
    InPort, Handle, IN_PORT
}

port! {
    /// `port out T`: [`write`](Self::write) publishes the content of the buffer.
    OutPort, Handle, OUT_PORT
}

port! {
    /// `port multiple in T`: elements identified by name, which supervisors connect.
    MultipleInPort, MultipleInHandle, MULTIPLE_IN_PORT
}

port! {
    /// `port multiple out T`: elements identified by name, which codels open and close.
    ///
    /// ```
    /// use genom::{Context, Event, MultipleOutPort, Thrown, event};
    ///
    /// #[genom::codel]
    /// fn demo_announce(
    ///     ranges: &mut MultipleOutPort<f64>,
    ///     context: &Context,
    /// ) -> Result<Event, Thrown> {
    ///     ranges.open(c"left", context)?;
    ///     if let Some(range) = ranges.data(c"left", context) {
    ///         *range = 1.5;
    ///     }
    ///     ranges.write(c"left", context)?;
    ///     Ok(event!("::demo::ether"))
    /// }
    /// # fn main() {}
    /// ```
    MultipleOutPort, MultipleOutHandle, MULTIPLE_OUT_PORT
}

impl<T: Data> InPort<T> {
    /// Reads the latest published value into the buffer.
    ///
    /// # Errors
    /// `::genom::no_such_inport` if the port is not connected, `::genom::port_io`,
    /// `::genom::serialization`.
    pub fn read(&mut self, context: &Context) -> Result<(), Thrown> {
        // SAFETY: a method of the host's handle, with the context of the running codel.
        checked(unsafe { (self.methods().exchange)(context.as_raw()) })
    }

    /// The value read last; `None` if there is none.
    #[must_use]
    pub fn data(&self, context: &Context) -> Option<&T> {
        // SAFETY: null or the port's buffer, which changes at `read` only, and no other codel
        // uses the port meanwhile (genom3.md 4.5).
        unsafe { (self.methods().data)(context.as_raw()).as_ref() }
    }

    /// Reads and returns the latest published value; `None` if the port is not connected or was
    /// never written.
    pub fn latest(&mut self, context: &Context) -> Option<&T> {
        self.read(context).ok()?;
        self.data(context)
    }
}

impl<T: Data> OutPort<T> {
    /// The buffer, to be modified in place.
    #[must_use]
    pub fn data(&mut self, context: &Context) -> Option<&mut T> {
        // SAFETY: null or the port's buffer, that no other codel uses meanwhile (4.5).
        unsafe { (self.methods().data)(context.as_raw()).as_mut() }
    }

    /// Publishes the buffer.
    ///
    /// # Errors
    /// `::genom::port_io`, `::genom::serialization`.
    pub fn write(&mut self, context: &Context) -> Result<(), Thrown> {
        // SAFETY: a method of the host's handle, with the context of the running codel.
        checked(unsafe { (self.methods().exchange)(context.as_raw()) })
    }

    /// Stores `value` in the buffer and publishes it.
    ///
    /// # Errors
    /// As for [`write`](Self::write).
    pub fn publish(&mut self, value: T, context: &Context) -> Result<(), Thrown> {
        if let Some(data) = self.data(context) {
            *data = value;
        }
        self.write(context)
    }
}

impl<T: Data> MultipleInPort<T> {
    /// Reads the latest value published to element `id` into its buffer.
    ///
    /// # Errors
    /// `::genom::no_such_inport` if there is no such element or it is not connected,
    /// `::genom::port_io`, `::genom::serialization`.
    pub fn read(&mut self, id: &CStr, context: &Context) -> Result<(), Thrown> {
        // SAFETY: a method of the host's handle, with the context of the running codel.
        checked(unsafe { (self.methods().read)(id.as_ptr(), context.as_raw()) })
    }

    /// The value of element `id` that was read last; `None` if there is none.
    #[must_use]
    pub fn data(&self, id: &CStr, context: &Context) -> Option<&T> {
        // SAFETY: as for `InPort::data`.
        unsafe { (self.methods().data)(id.as_ptr(), context.as_raw()).as_ref() }
    }
}

impl<T: Data> MultipleOutPort<T> {
    /// Creates element `id`, if it does not exist yet.
    ///
    /// # Errors
    /// `::genom::port_io`.
    pub fn open(&mut self, id: &CStr, context: &Context) -> Result<(), Thrown> {
        // SAFETY: a method of the host's handle, with the context of the running codel.
        checked(unsafe { (self.methods().open)(id.as_ptr(), context.as_raw()) })
    }

    /// Removes element `id`.
    ///
    /// # Errors
    /// `::genom::syserr` when there is no such element.
    pub fn close(&mut self, id: &CStr, context: &Context) -> Result<(), Thrown> {
        // SAFETY: a method of the host's handle, with the context of the running codel.
        checked(unsafe { (self.methods().close)(id.as_ptr(), context.as_raw()) })
    }

    /// The buffer of element `id`, to be modified in place; `None` if there is no such element.
    #[must_use]
    pub fn data(&mut self, id: &CStr, context: &Context) -> Option<&mut T> {
        // SAFETY: as for `OutPort::data`.
        unsafe { (self.methods().data)(id.as_ptr(), context.as_raw()).as_mut() }
    }

    /// Publishes the buffer of element `id`.
    ///
    /// # Errors
    /// `::genom::no_such_outport` when there is no such element, `::genom::port_io`,
    /// `::genom::serialization`.
    pub fn write(&mut self, id: &CStr, context: &Context) -> Result<(), Thrown> {
        // SAFETY: a method of the host's handle, with the context of the running codel.
        checked(unsafe { (self.methods().write)(id.as_ptr(), context.as_raw()) })
    }
}
