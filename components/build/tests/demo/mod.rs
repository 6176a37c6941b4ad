//! Calls the codels of a demo library directly, with ports and a context that only store values.

use std::cell::Cell;
use std::ffi::{CStr, c_char, c_void};
use std::path::Path;

use libloading::{Library, Symbol};

/// `struct demo_state`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct State {
    pub position: f64,
    pub velocity: f64,
}

/// `struct demo_ids`.
#[derive(Default)]
#[repr(C)]
pub struct Ids {
    pub velocity: f64,
    pub current: State,
    pub halted: u8,
}

#[repr(C)]
struct Context {
    raise: extern "C" fn(*const c_char, *const c_void, usize, *const Context) -> *const c_char,
    raised: extern "C" fn(*mut *const c_char, *const Context) -> *const c_void,
    data: *mut c_void,
}

#[repr(C)]
struct Port<T> {
    data: extern "C" fn(*const Context) -> *mut T,
    exchange: extern "C" fn(*const Context) -> *const c_char,
}

// Codels run in the thread of the test, so that thread-local variables are sufficient.
thread_local! {
    static GAIN: Cell<Option<f64>> = const { Cell::new(None) };
    static GAIN_BUFFER: Cell<f64> = const { Cell::new(0.0) };
    static SAMPLE: Cell<State> = const { Cell::new(State { position: 0.0, velocity: 0.0 }) };
    static WRITTEN: Cell<usize> = const { Cell::new(0) };
    static DETAIL: Cell<[f64; 3]> = const { Cell::new([0.0; 3]) };
}

extern "C" fn raise(
    exception: *const c_char,
    detail: *const c_void,
    size: usize,
    _: *const Context,
) -> *const c_char {
    if size == 88 {
        // SAFETY: OUT_OF_RANGE begins with three doubles.
        DETAIL.set(unsafe { *detail.cast() });
    }
    exception
}

extern "C" fn raised(_: *mut *const c_char, _: *const Context) -> *const c_void {
    std::ptr::null()
}

extern "C" fn gain_data(_: *const Context) -> *mut f64 {
    GAIN_BUFFER.with(Cell::as_ptr)
}

extern "C" fn gain_read(_: *const Context) -> *const c_char {
    match GAIN.get() {
        Some(gain) => {
            GAIN_BUFFER.set(gain);
            std::ptr::null()
        }
        None => c"::genom::no_such_inport".as_ptr(),
    }
}

extern "C" fn position_data(_: *const Context) -> *mut State {
    SAMPLE.with(Cell::as_ptr)
}

extern "C" fn position_write(_: *const Context) -> *const c_char {
    WRITTEN.set(WRITTEN.get() + 1);
    std::ptr::null()
}

const CONTEXT: Context = Context { raise, raised, data: std::ptr::null_mut() };
const PARAMETER: Port<f64> = Port { data: gain_data, exchange: gain_read };
const POSITION: Port<State> = Port { data: position_data, exchange: position_write };

/// A loaded demo and its IDS.
pub struct Demo {
    /// Never unloaded, because the events that codels return point into it.
    library: &'static Library,
    pub ids: Ids,
}

macro_rules! call {
    ($demo:expr, $name:literal, ($($ty:ty),*), $($argument:expr),*) => {{
        type Codel = extern "C" fn($($ty,)* *const Context) -> *const c_char;
        // SAFETY: the codel of this name has these parameters in demo.gen (genom3.md 5.5).
        unsafe {
            let codel: Symbol<'_, Codel> = $demo.library.get($name).unwrap();
            let event = codel($($argument,)* &CONTEXT);
            if event.is_null() { "" } else { CStr::from_ptr(event).to_str().unwrap() }
        }
    }};
}

type InPort = *const Port<f64>;
type OutPort = *const Port<State>;

impl Demo {
    /// Loads the library, and runs its start codel.
    pub fn start(library: &Path) -> (Self, &'static str) {
        // SAFETY: a library of codels runs no code when it is loaded.
        let library = Box::leak(Box::new(unsafe { Library::new(library) }.unwrap()));
        let mut demo = Self { library, ids: Ids::default() };
        GAIN.set(None);
        let ids: *mut Ids = &mut demo.ids;
        let event = call!(demo, c"demo_init", (*mut Ids, OutPort), ids, &POSITION);
        (demo, event)
    }

    /// Sets the value of port `parameter`; `None`: not connected.
    pub fn set_gain(gain: Option<f64>) {
        GAIN.set(gain);
    }

    /// The last sample on port `position`, and the number of samples so far.
    pub fn published() -> (State, usize) {
        (SAMPLE.get(), WRITTEN.get())
    }

    pub fn begin(&mut self) -> &'static str {
        let halted: *mut u8 = &mut self.ids.halted;
        call!(self, c"demo_begin", (*mut u8), halted)
    }

    pub fn servo(&mut self, goal: f64) -> &'static str {
        let (velocity, halted) = (self.ids.velocity, self.ids.halted);
        let current: *mut State = &mut self.ids.current;
        call!(
            self,
            c"demo_servo",
            (f64, f64, u8, *mut State, InPort, OutPort),
            goal,
            velocity,
            halted,
            current,
            &PARAMETER,
            &POSITION
        )
    }

    pub fn brake(&mut self) -> &'static str {
        let current: *mut State = &mut self.ids.current;
        call!(self, c"demo_brake", (*mut State, OutPort), current, &POSITION)
    }

    pub fn halt(&mut self) -> &'static str {
        let current: *mut State = &mut self.ids.current;
        let halted: *mut u8 = &mut self.ids.halted;
        call!(self, c"demo_halt", (*mut State, *mut u8, OutPort), current, halted, &POSITION)
    }

    pub fn reset(&mut self) -> &'static str {
        let current: *mut State = &mut self.ids.current;
        call!(self, c"demo_reset", (*mut State), current)
    }

    pub fn check_velocity(&self, velocity: f64) -> &'static str {
        call!(self, c"demo_check_velocity", (f64), velocity)
    }

    pub fn check_goal(&self, goal: f64) -> &'static str {
        call!(self, c"demo_check_goal", (f64), goal)
    }

    /// `value, lower, upper` of the OUT_OF_RANGE thrown last.
    pub fn detail() -> [f64; 3] {
        DETAIL.get()
    }
}
