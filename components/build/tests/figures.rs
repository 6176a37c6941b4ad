//! The codels of the two papers' figures: the axis moves at constant speed and ends at the goal.

#![allow(clippy::panic, clippy::unwrap_used, reason = "it is a test")]

use std::cell::Cell;
use std::ffi::{CStr, c_char, c_void};

use genom_components::{Paths, Purpose, build};
use libloading::{Library, Symbol};

#[repr(C)]
struct Context {
    raise: extern "C" fn(*const c_char, *const c_void, usize, *const Context) -> *const c_char,
    raised: extern "C" fn(*mut *const c_char, *const Context) -> *const c_void,
    data: *mut c_void,
}

#[repr(C)]
struct Port {
    data: extern "C" fn(*const Context) -> *mut f64,
    write: extern "C" fn(*const Context) -> *const c_char,
}

thread_local! {
    static POSITION: Cell<f64> = const { Cell::new(0.0) };
    static WRITTEN: Cell<usize> = const { Cell::new(0) };
}

extern "C" fn raise(
    exception: *const c_char,
    _: *const c_void,
    _: usize,
    _: *const Context,
) -> *const c_char {
    exception
}

extern "C" fn raised(_: *mut *const c_char, _: *const Context) -> *const c_void {
    std::ptr::null()
}

extern "C" fn data(_: *const Context) -> *mut f64 {
    POSITION.with(Cell::as_ptr)
}

extern "C" fn write(_: *const Context) -> *const c_char {
    WRITTEN.set(WRITTEN.get() + 1);
    std::ptr::null()
}

const CONTEXT: Context = Context { raise, raised, data: std::ptr::null_mut() };
const PORT: Port = Port { data, write };

type Stop = extern "C" fn(*const Context) -> *const c_char;
type OnVelocity = extern "C" fn(*mut f64, *const Context) -> *const c_char;
type Servo = extern "C" fn(f64, *mut f64, *const Port, *const Context) -> *const c_char;

fn text(event: *const c_char) -> String {
    // SAFETY: events are NUL-terminated constants of the library, which is loaded.
    unsafe { CStr::from_ptr(event) }.to_str().unwrap().to_owned()
}

/// Runs `goto` of a figure, and returns the number of periods it took.
fn goto(library: &Library, goal: f64, velocity: &mut f64) -> usize {
    // SAFETY: the figures' codels have these types (dialects.md, C signatures).
    let (init, servo, stop) = unsafe {
        let init: Symbol<'_, OnVelocity> = library.get(c"demo_init_velocity").unwrap();
        let servo: Symbol<'_, Servo> = library.get(c"demo_servo").unwrap();
        let stop: Symbol<'_, Stop> = library.get(c"demo_stop").unwrap();
        (init, servo, stop)
    };
    POSITION.set(0.0);
    WRITTEN.set(0);
    assert_eq!(text(init(velocity, &CONTEXT)), "::demo::main");
    loop {
        match text(servo(goal, velocity, &PORT, &CONTEXT)).as_str() {
            "::demo::main" => assert!(WRITTEN.get() < 10_000, "the servo never arrives"),
            "::demo::stop" => break,
            other => panic!("{other}"),
        }
    }
    assert_eq!(POSITION.get(), goal);
    assert_eq!(text(stop(&CONTEXT)), "::demo::ether");
    let end = text(servo(f64::NAN, velocity, &PORT, &CONTEXT));
    assert_eq!(end, "::demo::SERVO_ERROR");
    WRITTEN.get()
}

fn figure(name: &str) -> Library {
    let artifact = build(&Paths::of_workspace().unwrap(), name, Purpose::Test).unwrap();
    // SAFETY: a library of codels runs no code when it is loaded.
    unsafe { Library::new(artifact.library) }.unwrap()
}

#[test]
fn the_figure_of_2010_moves_at_one_metre_a_second() {
    let library = figure("demo-2010");
    let mut velocity = 0.0;
    let periods = goto(&library, 1.0, &mut velocity);
    assert!((200..=201).contains(&periods), "{periods} periods of 5 ms");
    assert_eq!(goto(&library, -0.5, &mut velocity), periods.div_ceil(2));
}

#[test]
fn the_figure_of_2011_keeps_the_speed_that_was_set() {
    let library = figure("demo-2011");
    // SAFETY: as in `goto`.
    let check: Symbol<'_, OnVelocity> = unsafe { library.get(c"demo_chk_velocity") }.unwrap();
    let mut velocity = 7.0;
    assert!(check(&mut velocity, &CONTEXT).is_null());
    assert_eq!(velocity, 2.0, "within what the axis can do");
    let periods = goto(&library, 1.0, &mut velocity);
    assert!((100..=101).contains(&periods), "{periods} periods of 5 ms");

    velocity = f64::NAN;
    assert!(check(&mut velocity, &CONTEXT).is_null());
    assert_eq!(velocity, 0.01);
}
