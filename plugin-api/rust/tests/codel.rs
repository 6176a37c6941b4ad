//! Calls codels as a host does: through the table, with C arguments and a C context.

#![allow(clippy::panic, clippy::unwrap_used, reason = "it is a test")]

use std::ffi::{CStr, CString, c_char, c_void};
use std::mem::transmute;

use genom::abi::{ABI_MAJOR, Kind, Passing};
use genom::{
    BoundedString, Context, ContextInterface, Data, Event, Exception, InPort, MultipleOutPort,
    OutPort, Text, Thrown, event,
};

#[derive(Clone, Copy, Debug, PartialEq, Data)]
#[genom(name = "::demo::point")]
#[repr(C)]
struct Point {
    x: f64,
    y: f32,
}

#[derive(Clone, Copy, Exception)]
#[genom(name = "::demo::TOO_FAR")]
#[repr(C)]
struct TooFar {
    distance: f64,
    what: BoundedString<16>,
}

#[genom::codel]
fn mixed(
    scale: f32,
    fast: bool,
    name: &CStr,
    from: &Point,
    to: &mut Point,
    label: &mut Text,
    context: &Context,
) -> Result<Event, Thrown> {
    if !fast {
        let what = BoundedString::new(&name.to_string_lossy());
        return Err(TooFar { distance: f64::from(scale), what }.raise(context));
    }
    *to = Point { x: from.x * f64::from(scale), y: from.y };
    label.set(&name.to_string_lossy());
    Ok(event!("::demo::pause::main"))
}

#[genom::codel]
fn explodes(at: i64) {
    assert!(at == 0, "exploded at {at}");
}

struct Grenade;

impl Drop for Grenade {
    fn drop(&mut self) {
        panic!("the payload explodes too");
    }
}

#[genom::codel]
fn explodes_twice() {
    std::panic::panic_any(Grenade);
}

#[genom::codel]
fn relay(input: &mut InPort<Point>, output: &mut OutPort<Point>, context: &Context) -> Event {
    match input.latest(context).copied() {
        Some(point) if output.publish(point, context).is_ok() => event!("::demo::ether"),
        _ => event!("::demo::stop"),
    }
}

#[genom::codel]
fn opens(many: &mut MultipleOutPort<i32>, context: &Context) -> Result<(), Thrown> {
    many.open(c"a", context)?;
    if let Some(value) = many.data(c"a", context) {
        *value = 7;
    }
    many.write(c"a", context)?;
    many.close(c"b", context)
}

genom::remote! {
    /// A service of another component.
    struct Locate(range: f64, precise: bool, name: &CStr, from: &Point, to: &mut Point);
}

#[genom::codel]
fn asks(locate: &mut Locate, to: &mut Point, context: &Context) -> Result<(), Thrown> {
    let from = Point { x: 1.0, y: 2.0 };
    locate.call(3.0, true, c"door", &from, to, context)
}

genom::component! {
    description: "tank.gen",
    codels: [mixed, explodes, explodes_twice, relay, opens, asks],
    exceptions: [TooFar],
}

unsafe extern "C" {
    safe static genom_component: genom::abi::Component;
    safe static genom_description: c_char;
}

/// Data behind the test's context: the exception recorded last, and its detail.
#[derive(Default)]
struct Recorded {
    exception: Option<&'static CStr>,
    detail: Vec<u8>,
}

extern "C" fn raise(
    exception: *const c_char,
    detail: *const c_void,
    size: usize,
    context: *const ContextInterface,
) -> *const c_char {
    // SAFETY: `with_context` put a `Recorded` behind `data`; `detail` is `size` bytes.
    unsafe {
        let recorded = &mut *(*context).data.cast::<Recorded>();
        recorded.exception = Some(CStr::from_ptr(exception));
        recorded.detail = match size {
            0 => Vec::new(),
            _ => std::slice::from_raw_parts(detail.cast(), size).to_vec(),
        };
    }
    exception
}

extern "C" fn raised(
    exception: *mut *const c_char,
    context: *const ContextInterface,
) -> *const c_void {
    // SAFETY: as in `raise`.
    unsafe {
        let recorded = &*(*context).data.cast::<Recorded>();
        *exception = recorded.exception.map_or(std::ptr::null(), CStr::as_ptr);
        recorded.detail.as_ptr().cast()
    }
}

fn with_context<R>(call: impl FnOnce(*const ContextInterface) -> R) -> (R, Recorded) {
    let mut recorded = Recorded::default();
    let data = (&raw mut recorded).cast();
    let result = call(&ContextInterface { raise, raised, data });
    (result, recorded)
}

fn function(name: &str) -> *const c_void {
    // SAFETY: the table is a constant of this program.
    let codels = unsafe { genom_component.codels.as_slice() };
    codels.iter().find(|codel| name_of(codel.name) == name).unwrap().function
}

fn name_of(name: *const c_char) -> &'static str {
    // SAFETY: names and events are NUL-terminated constants.
    unsafe { CStr::from_ptr(name) }.to_str().unwrap()
}

type Mixed = extern "C" fn(
    f32,
    u8,
    *const c_char,
    *const Point,
    *mut Point,
    *mut *mut c_char,
    *const ContextInterface,
) -> *const c_char;

#[test]
fn arguments_travel_by_value_and_by_address() {
    // SAFETY: the C signature of `mixed` by genom3.md 5.5.
    let mixed: Mixed = unsafe { transmute(function("mixed")) };
    let from = Point { x: 2.0, y: 3.0 };
    let mut to = Point { x: 0.0, y: 0.0 };
    let mut label = Text::default();
    let address = (&raw mut label).cast();
    let (event, recorded) =
        with_context(|cx| mixed(1.5, 1, c"left".as_ptr(), &from, &mut to, address, cx));
    assert_eq!(name_of(event), "::demo::pause::main");
    assert_eq!(to, Point { x: 3.0, y: 3.0 });
    assert_eq!(label.to_str(), "left");
    assert_eq!(recorded.exception, None);
}

#[test]
fn an_exception_reaches_the_host_with_its_detail() {
    // SAFETY: the C signature of `mixed` by genom3.md 5.5.
    let mixed: Mixed = unsafe { transmute(function("mixed")) };
    let (mut from, mut label) = (Point { x: 0.0, y: 0.0 }, Text::default());
    let (from, address) = (&raw mut from, (&raw mut label).cast());
    let (event, recorded) =
        with_context(|cx| mixed(9.0, 0, std::ptr::null(), from, from, address, cx));
    assert_eq!(name_of(event), "::demo::TOO_FAR");
    assert_eq!(recorded.exception, Some(c"::demo::TOO_FAR"));
    assert_eq!(recorded.detail.len(), size_of::<TooFar>());
    assert_eq!(recorded.detail[..8], 9.0_f64.to_ne_bytes());
}

#[test]
fn a_panic_becomes_unkex_with_its_message() {
    type Explodes = extern "C" fn(i64, *const ContextInterface) -> *const c_char;
    // SAFETY: the C signature of `explodes` by genom3.md 5.5.
    let explodes: Explodes = unsafe { transmute(function("explodes")) };
    let (event, _) = with_context(|cx| explodes(0, cx));
    assert!(event.is_null(), "genom_ok");

    let (event, recorded) = with_context(|cx| explodes(3, cx));
    assert_eq!(name_of(event), "::genom::unkex");
    assert_eq!(recorded.detail.len(), 128);
    let what = CStr::from_bytes_until_nul(&recorded.detail).unwrap();
    assert_eq!(what, CString::new("exploded at 3").unwrap().as_c_str());
}

#[test]
fn a_panic_whose_payload_panics_stays_in_the_codel() {
    type Explodes = extern "C" fn(*const ContextInterface) -> *const c_char;
    // SAFETY: the C signature of `explodes_twice` by genom3.md 5.5.
    let explodes: Explodes = unsafe { transmute(function("explodes_twice")) };
    let (event, recorded) = with_context(|cx| explodes(cx));
    assert_eq!(name_of(event), "::genom::unkex");
    let what = CStr::from_bytes_until_nul(&recorded.detail).unwrap();
    assert_eq!(what, c"the codel panicked");
}

/// Handle of a simple port, as a host lays it out (genom3.md 5.7).
#[repr(C)]
struct Handle(
    extern "C" fn(*const ContextInterface) -> *mut Point,
    extern "C" fn(*const ContextInterface) -> *const c_char,
);

type Method = extern "C" fn(*const c_char, *const ContextInterface) -> *const c_char;

/// A handle of a multiple out port.
#[repr(C)]
struct MultipleHandle(
    extern "C" fn(*const c_char, *const ContextInterface) -> *mut i32,
    Method,
    Method,
    Method,
);

#[test]
fn ports_are_used_through_the_hosts_handles() {
    static mut INPUT: Point = Point { x: 4.0, y: 5.0 };
    static mut OUTPUT: Point = Point { x: 0.0, y: 0.0 };
    extern "C" fn input(_: *const ContextInterface) -> *mut Point {
        &raw mut INPUT
    }
    extern "C" fn output(_: *const ContextInterface) -> *mut Point {
        &raw mut OUTPUT
    }
    extern "C" fn ok(_: *const ContextInterface) -> *const c_char {
        std::ptr::null()
    }
    extern "C" fn refuses(context: *const ContextInterface) -> *const c_char {
        raise(c"::genom::no_such_inport".as_ptr(), std::ptr::null(), 0, context)
    }
    type Relay =
        extern "C" fn(*const Handle, *const Handle, *const ContextInterface) -> *const c_char;

    // SAFETY: the C signature of `relay`; a handle is two function pointers (genom3.md 5.7).
    let relay: Relay = unsafe { transmute(function("relay")) };
    let out = Handle(output, ok);
    let (event, _) = with_context(|cx| relay(&Handle(input, ok), &out, cx));
    assert_eq!(name_of(event), "::demo::ether");
    // SAFETY: no other thread uses it.
    assert_eq!(unsafe { OUTPUT }, Point { x: 4.0, y: 5.0 });

    let (event, recorded) = with_context(|cx| relay(&Handle(input, refuses), &out, cx));
    assert_eq!(name_of(event), "::demo::stop", "an unconnected port has no latest value");
    assert_eq!(recorded.exception, Some(c"::genom::no_such_inport"));
}

#[test]
fn methods_of_a_multiple_port_carry_the_element() {
    static mut VALUE: i32 = 0;
    extern "C" fn data(id: *const c_char, _: *const ContextInterface) -> *mut i32 {
        if name_of(id) == "a" { &raw mut VALUE } else { std::ptr::null_mut() }
    }
    extern "C" fn ok(_: *const c_char, _: *const ContextInterface) -> *const c_char {
        std::ptr::null()
    }
    extern "C" fn close(id: *const c_char, context: *const ContextInterface) -> *const c_char {
        assert_eq!(name_of(id), "b");
        raise(c"::genom::syserr".as_ptr(), (&raw const ENOENT).cast(), 4, context)
    }
    static ENOENT: i32 = 2;
    type Opens = extern "C" fn(*const MultipleHandle, *const ContextInterface) -> *const c_char;

    // SAFETY: the C signature of `opens` (genom3.md 5.7).
    let opens: Opens = unsafe { transmute(function("opens")) };
    let (event, recorded) = with_context(|cx| opens(&MultipleHandle(data, ok, ok, close), cx));
    assert_eq!(name_of(event), "::genom::syserr");
    assert_eq!(recorded.detail, 2_i32.to_ne_bytes());
    // SAFETY: no other thread uses it.
    assert_eq!(unsafe { VALUE }, 7);
}

#[test]
fn a_remote_is_called_with_c_arguments_and_its_exception_comes_back() {
    extern "C" fn locate(
        range: f64,
        precise: u8,
        name: *const c_char,
        from: *const Point,
        to: *mut Point,
        context: *const ContextInterface,
    ) -> *const c_char {
        assert_eq!((range, precise, name_of(name)), (3.0, 1, "door"));
        // SAFETY: the codel lends both points.
        unsafe {
            if (*to).x < 0.0 {
                return raise(c"::map::NO_DOOR".as_ptr(), std::ptr::null(), 0, context);
            }
            *to = Point { x: (*from).x + range, y: 0.0 };
        }
        std::ptr::null()
    }
    type Call = extern "C" fn(
        f64,
        u8,
        *const c_char,
        *const Point,
        *mut Point,
        *const ContextInterface,
    ) -> *const c_char;
    type Asks =
        extern "C" fn(*const [Call; 1], *mut Point, *const ContextInterface) -> *const c_char;

    // SAFETY: the C signature of `asks`; a remote is one function pointer (genom3.md 5.8).
    let asks: Asks = unsafe { transmute(function("asks")) };
    let mut to = Point { x: 0.0, y: 9.0 };
    let (event, _) = with_context(|cx| asks(&[locate], &mut to, cx));
    assert!(event.is_null());
    assert_eq!(to, Point { x: 4.0, y: 0.0 });

    to.x = -1.0;
    let (event, recorded) = with_context(|cx| asks(&[locate], &mut to, cx));
    assert_eq!(name_of(event), "::map::NO_DOOR");
    assert_eq!(recorded.exception, Some(c"::map::NO_DOOR"));
}

#[test]
fn the_table_tells_the_parameters_of_a_remote() {
    // SAFETY: the table is a constant of this program.
    let codels = unsafe { genom_component.codels.as_slice() };
    let asks = codels.iter().find(|codel| name_of(codel.name) == "asks").unwrap();
    // SAFETY: as above.
    let remote = unsafe { &asks.arguments.as_slice()[0] };
    // SAFETY: as above.
    let ty = unsafe { &*remote.ty };
    assert_eq!((remote.passing, ty.kind), (Passing::REMOTE, Kind::REMOTE));
    // SAFETY: as above.
    let seen: Vec<_> = unsafe { ty.members.as_slice() }
        .iter()
        .map(|member| (name_of(member.name), member.offset, unsafe { (*member.ty).kind }))
        .collect();
    assert_eq!(
        seen,
        [
            ("range", Passing::VALUE.0 as usize, Kind::DOUBLE),
            ("precise", Passing::VALUE.0 as usize, Kind::BOOLEAN),
            ("name", Passing::VALUE.0 as usize, Kind::STRING),
            ("from", Passing::SHARED.0 as usize, Kind::STRUCT),
            ("to", Passing::EXCLUSIVE.0 as usize, Kind::STRUCT),
        ]
    );
}

#[test]
fn the_table_tells_arguments_and_description() {
    assert_eq!(genom_component.abi_major, ABI_MAJOR);
    assert_eq!(genom_component.size as usize, size_of::<genom::abi::Component>());
    assert_eq!(name_of(genom_component.description), include_str!("tank.gen"));
    assert!(std::ptr::eq(genom_component.description, &genom_description));

    // SAFETY: the table is a constant of this program.
    let arguments = unsafe { genom_component.codels.as_slice()[0].arguments.as_slice() };
    let seen: Vec<_> = arguments
        .iter()
        .map(|argument| {
            // SAFETY: as above.
            (name_of(argument.name), argument.passing, unsafe { (*argument.ty).kind })
        })
        .collect();
    assert_eq!(
        seen,
        [
            ("scale", Passing::VALUE, Kind::FLOAT),
            ("fast", Passing::VALUE, Kind::BOOLEAN),
            ("name", Passing::VALUE, Kind::STRING),
            ("from", Passing::SHARED, Kind::STRUCT),
            ("to", Passing::EXCLUSIVE, Kind::STRUCT),
            ("label", Passing::EXCLUSIVE, Kind::STRING),
        ]
    );
    // SAFETY: as above.
    let ports = unsafe { genom_component.codels.as_slice()[3].arguments.as_slice() };
    assert_eq!(ports[0].passing, Passing::IN_PORT);
    assert_eq!(ports[1].passing, Passing::OUT_PORT);
    assert_eq!(ports[1].ty, Point::TYPE);
    // SAFETY: as above.
    let exceptions = unsafe { genom_component.exceptions.as_slice() };
    assert_eq!(exceptions, [TooFar::TYPE]);
}
