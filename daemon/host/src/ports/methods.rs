//! The C functions of a port's handle (genom3.md 5.7): one for each method of each port.

use std::ffi::{c_char, c_void};
use std::sync::Arc;

use genom_description::model::PortDirection;

use super::buffers::Buffers;
use super::element::{Element, Failure};
use super::multiple::{ENAMETOOLONG, Elements, LONGEST};
use crate::detail::{MWERR, MWERR_WHAT, SYSERR, put_text};
use crate::ffi::{Arguments, Callback, Class, NativeFunction};
use crate::shared::Shared;

/// State of a simple port's methods.
#[derive(Clone)]
struct Simple {
    element: Arc<Element>,
    shared: Arc<Shared>,
}

/// State of a multiple port's methods.
#[derive(Clone)]
struct Multiple {
    elements: Arc<Elements>,
    shared: Arc<Shared>,
}

/// The functions of a handle, in the order of its struct.
pub(super) fn functions(
    direction: PortDirection,
    buffers: &Buffers,
    shared: &Arc<Shared>,
) -> Option<Vec<NativeFunction>> {
    match buffers {
        Buffers::Simple(element) => {
            let data = Simple { element: Arc::clone(element), shared: Arc::clone(shared) };
            let methods: [Callback<Simple>; 2] = match direction {
                PortDirection::In => [simple_data, simple_read],
                PortDirection::Out => [simple_data, simple_write],
            };
            // genom_context self
            make(&[Class::Address], &methods, &data)
        }
        Buffers::Multiple(elements) => {
            let data = Multiple { elements: Arc::clone(elements), shared: Arc::clone(shared) };
            let methods: &[Callback<Multiple>] = match direction {
                PortDirection::In => &[multiple_data, multiple_read],
                PortDirection::Out => {
                    &[multiple_data, multiple_write, multiple_open, multiple_close]
                }
            };
            // const char *id, genom_context self
            make(&[Class::Address, Class::Address], methods, &data)
        }
    }
}

fn make<T: Clone + Send + Sync + 'static>(
    arguments: &[Class],
    methods: &[Callback<T>],
    data: &T,
) -> Option<Vec<NativeFunction>> {
    let function = |method: &Callback<T>| NativeFunction::new(arguments, *method, data.clone());
    methods.iter().map(function).collect()
}

fn simple_data(port: &Simple, _: Arguments<'_>) -> *const c_void {
    port.element.data() as *const c_void
}

fn simple_read(port: &Simple, arguments: Arguments<'_>) -> *const c_void {
    tell(&port.shared, port.element.read(), arguments.pointer(0))
}

fn simple_write(port: &Simple, arguments: Arguments<'_>) -> *const c_void {
    tell(&port.shared, port.element.write(), arguments.pointer(0))
}

fn multiple_data(port: &Multiple, arguments: Arguments<'_>) -> *const c_void {
    named(port, arguments).map_or(0, |element| element.data()) as *const c_void
}

fn multiple_read(port: &Multiple, arguments: Arguments<'_>) -> *const c_void {
    let read = named(port, arguments).ok_or(Failure::NoSuchInport).and_then(|e| e.read());
    tell(&port.shared, read, arguments.pointer(1))
}

fn multiple_write(port: &Multiple, arguments: Arguments<'_>) -> *const c_void {
    let written = named(port, arguments).ok_or(Failure::NoSuchOutport).and_then(|e| e.write());
    tell(&port.shared, written, arguments.pointer(1))
}

fn multiple_open(port: &Multiple, arguments: Arguments<'_>) -> *const c_void {
    let opened = match arguments.text(0, LONGEST) {
        // Codels can shorten the name and try again.
        None if !arguments.pointer(0).is_null() => Err(Failure::System(ENAMETOOLONG)),
        name => port.elements.open(name),
    };
    tell(&port.shared, opened, arguments.pointer(1))
}

fn multiple_close(port: &Multiple, arguments: Arguments<'_>) -> *const c_void {
    let closed = port.elements.close(arguments.text(0, LONGEST));
    tell(&port.shared, closed, arguments.pointer(1))
}

/// The element that the first argument names.
fn named(port: &Multiple, arguments: Arguments<'_>) -> Option<Arc<Element>> {
    port.elements.get(arguments.text(0, LONGEST)?)
}

/// The event for a result: an exception is recorded in the context that the codel passed, and the
/// event is the library's own pointer (genom3.md 5.3, 7.8).
fn tell(shared: &Shared, result: Result<(), Failure>, context: *mut u8) -> *const c_void {
    let Err(failure) = result else { return std::ptr::null() };
    let (name, detail) = exception(&failure);
    let event: *const c_char = shared.throw(context, name, &detail);
    event.cast()
}

/// The exception for a failure, and its detail in C layout.
pub(super) fn exception(failure: &Failure) -> (&'static str, Vec<u8>) {
    match failure {
        Failure::NoSuchInport => ("::genom::no_such_inport", Vec::new()),
        Failure::NoSuchOutport => ("::genom::no_such_outport", Vec::new()),
        Failure::PortIo => ("::genom::port_io", Vec::new()),
        Failure::Serialization => ("::genom::serialization", Vec::new()),
        Failure::Middleware(what) => {
            let mut detail = vec![0; MWERR_WHAT];
            put_text(&mut detail, what);
            (MWERR, detail)
        }
        Failure::System(code) => (SYSERR, code.to_ne_bytes().to_vec()),
    }
}
