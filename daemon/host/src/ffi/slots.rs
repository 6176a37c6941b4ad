//! C functions with one argument, a pointer, that are compiled in advance. Each has a slot for what
//! it calls.
//!
//! A closure of libffi stores all registers of arguments, and works out from its interface where the
//! arguments are: some 30 ns a call, for methods that codels call at each tick. These functions do
//! without. There is a fixed number of them in a process; when all are taken, closures are made.
//! One of the few unsafe modules.
#![allow(unsafe_code)]

use std::ffi::c_void;
use std::ptr::{null, null_mut};
use std::sync::atomic::{AtomicPtr, Ordering};

use super::arguments::{Arguments, Bound};

const COLUMNS: usize = 16;
const ROWS: usize = 64;

type Function = unsafe extern "C" fn(*const c_void) -> *const c_void;

/// What a function calls: the beginning of a [`Filled`], whose type only `enter` knows.
struct Target {
    enter: unsafe fn(*const Target, Arguments<'_>) -> *const c_void,
}

#[repr(C)]
struct Filled<T> {
    target: Target,
    bound: Bound<T>,
}

/// Target of each function; null if the function is free.
static SLOTS: [[AtomicPtr<Target>; COLUMNS]; ROWS] =
    [const { [const { AtomicPtr::new(null_mut()) }; COLUMNS] }; ROWS];

#[rustfmt::skip]
static FUNCTIONS: [[Function; COLUMNS]; ROWS] = [
    row::<0>(), row::<1>(), row::<2>(), row::<3>(), row::<4>(), row::<5>(), row::<6>(), row::<7>(),
    row::<8>(), row::<9>(), row::<10>(), row::<11>(), row::<12>(), row::<13>(), row::<14>(), row::<15>(),
    row::<16>(), row::<17>(), row::<18>(), row::<19>(), row::<20>(), row::<21>(), row::<22>(), row::<23>(),
    row::<24>(), row::<25>(), row::<26>(), row::<27>(), row::<28>(), row::<29>(), row::<30>(), row::<31>(),
    row::<32>(), row::<33>(), row::<34>(), row::<35>(), row::<36>(), row::<37>(), row::<38>(), row::<39>(),
    row::<40>(), row::<41>(), row::<42>(), row::<43>(), row::<44>(), row::<45>(), row::<46>(), row::<47>(),
    row::<48>(), row::<49>(), row::<50>(), row::<51>(), row::<52>(), row::<53>(), row::<54>(), row::<55>(),
    row::<56>(), row::<57>(), row::<58>(), row::<59>(), row::<60>(), row::<61>(), row::<62>(), row::<63>(),
];

#[rustfmt::skip]
const fn row<const ROW: usize>() -> [Function; COLUMNS] {
    [
        call::<ROW, 0>, call::<ROW, 1>, call::<ROW, 2>, call::<ROW, 3>,
        call::<ROW, 4>, call::<ROW, 5>, call::<ROW, 6>, call::<ROW, 7>,
        call::<ROW, 8>, call::<ROW, 9>, call::<ROW, 10>, call::<ROW, 11>,
        call::<ROW, 12>, call::<ROW, 13>, call::<ROW, 14>, call::<ROW, 15>,
    ]
}

unsafe extern "C" fn call<const ROW: usize, const COLUMN: usize>(
    argument: *const c_void,
) -> *const c_void {
    let target = SLOTS[ROW][COLUMN].load(Ordering::Acquire);
    if target.is_null() {
        // Its component is gone, and with it whatever this function was.
        return null();
    }
    let place = (&raw const argument).cast();
    // SAFETY: the target is dropped after the threads that call the function have ended
    // ([`Taken`]); `place` is the address of the only argument.
    unsafe { ((*target).enter)(target, Arguments::at(&raw const place)) }
}

/// # Safety
/// `target` is that of a [`Filled<T>`].
unsafe fn enter<T>(target: *const Target, arguments: Arguments<'_>) -> *const c_void {
    // SAFETY: the caller's promise; the target is its first field.
    let filled = unsafe { &*target.cast::<Filled<T>>() };
    filled.bound.run(arguments)
}

/// A function that was free. Dropping this frees it: no thread may be calling it then.
pub(super) struct Taken<T> {
    slot: &'static AtomicPtr<Target>,
    code: usize,
    filled: *mut Filled<T>,
}

// SAFETY: it owns `filled`, whose data is `Send` and `Sync`.
unsafe impl<T: Send + Sync> Send for Taken<T> {}
// SAFETY: as above; nothing changes until it is dropped.
unsafe impl<T: Send + Sync> Sync for Taken<T> {}

impl<T: Send + Sync + 'static> Taken<T> {
    /// Takes a function that is free; gives back what it would have called if there is none.
    pub(super) fn new(bound: Bound<T>) -> Result<Self, Bound<T>> {
        let target = Target { enter: enter::<T> };
        let filled = Box::into_raw(Box::new(Filled { target, bound }));
        let all = SLOTS.iter().flatten().zip(FUNCTIONS.iter().flatten());
        for (slot, function) in all {
            let taken = slot.compare_exchange(
                null_mut(),
                filled.cast(),
                Ordering::AcqRel,
                Ordering::Relaxed,
            );
            if taken.is_ok() {
                return Ok(Self { slot, code: *function as usize, filled });
            }
        }
        // SAFETY: it comes from a box, and no slot has it.
        Err(unsafe { Box::from_raw(filled) }.bound)
    }

    /// Its address, for C code to call.
    pub(super) fn address(&self) -> usize {
        self.code
    }
}

impl<T> Drop for Taken<T> {
    fn drop(&mut self) {
        self.slot.store(null_mut(), Ordering::Release);
        // SAFETY: it comes from a box; the slot no longer has it, and nobody is calling the
        // function.
        drop(unsafe { Box::from_raw(self.filled) });
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Class, NativeFunction};
    use super::*;

    /// Returns its data, as an address, if the argument is that address.
    fn same(data: &usize, arguments: Arguments<'_>) -> *const c_void {
        if arguments.pointer(0) as usize == *data { *data as *const c_void } else { null() }
    }

    #[test]
    fn functions_are_taken_first_closures_made_then_and_each_has_its_own_data() {
        for _ in 0..2 {
            let made: Vec<_> = (1..=ROWS * COLUMNS + 1)
                .map(|data| NativeFunction::new(&[Class::Address], same, data).unwrap())
                .collect();
            let in_advance = |code: usize| FUNCTIONS.iter().flatten().any(|f| *f as usize == code);
            assert!(in_advance(made[0].address()), "what was given back is taken again");
            assert!(!in_advance(made[ROWS * COLUMNS].address()));
            for (rank, function) in made.iter().enumerate() {
                let data = (rank + 1) as *const c_void;
                // SAFETY: a function of this signature, which lives as long as `made`.
                let returned =
                    unsafe { std::mem::transmute::<usize, Function>(function.address())(data) };
                assert_eq!(returned, data);
            }
        }
    }

    #[test]
    fn a_method_that_panics_returns_null() {
        fn panics(_: &(), _: Arguments<'_>) -> *const c_void {
            panic!("a method");
        }
        let made = NativeFunction::new(&[Class::Address], panics, ()).unwrap();
        // SAFETY: as above.
        let call = unsafe { std::mem::transmute::<usize, Function>(made.address()) };
        // SAFETY: the function takes any pointer.
        assert!(unsafe { call(null()) }.is_null());
    }
}
