//! Assigns the arguments of a call to registers, on platforms with separate banks for integers and
//! floating-point numbers. Prepared at load, so that most codels are called without libffi, which
//! computes the assignment at each call. One of the few unsafe modules.
#![allow(unsafe_code)]

use std::ffi::c_void;

use super::{Class, Scalar};

/// Most integer arguments: in registers, then on the stack.
const INTEGERS: usize = 14;
/// Most floating-point arguments, all in registers.
const FLOATS: usize = 8;

/// Whether the platform's calling convention is of this kind.
const SUITED: bool = cfg!(all(
    target_os = "linux",
    target_endian = "little",
    any(target_arch = "x86_64", target_arch = "aarch64")
));

/// Register or stack slot of each argument of a call.
#[derive(Debug)]
pub(super) struct RegisterPlan {
    arguments: Box<[Argument]>,
    integers: usize,
}

/// How to read an argument, and its index among those of its bank.
#[derive(Clone, Copy, Debug)]
struct Argument {
    /// `None` for a pointer.
    scalar: Option<Scalar>,
    slot: usize,
}

/// The arguments of one call.
pub(super) struct Values {
    /// Integers and pointers, extended to 64 bits.
    pub(super) integers: [u64; INTEGERS],
    /// Bits of floating-point numbers; a `float` is in the lower half.
    pub(super) floats: [u64; FLOATS],
}

impl RegisterPlan {
    /// The plan for these arguments; `None` when libffi has to be used.
    pub(super) fn new(classes: &[Class]) -> Option<Self> {
        let (mut integers, mut floats) = (0, 0);
        let mut next = |class: &Class| {
            let scalar = match class {
                Class::Value(scalar) => Some(*scalar),
                Class::Held | Class::Address => None,
            };
            let rank = match scalar {
                Some(Scalar::F32 | Scalar::F64) => &mut floats,
                _ => &mut integers,
            };
            *rank += 1;
            Argument { scalar, slot: *rank - 1 }
        };
        let arguments = classes.iter().map(&mut next).collect();
        (SUITED && integers <= INTEGERS && floats <= FLOATS).then_some(Self { arguments, integers })
    }

    /// Number of integers and pointers.
    pub(super) fn integers(&self) -> usize {
        self.integers
    }

    /// Reads the arguments.
    ///
    /// # Safety
    /// `places` has an address for each argument, which points to a value of its class.
    #[inline]
    pub(super) unsafe fn read(&self, places: &[*mut c_void]) -> Values {
        let mut values = Values { integers: [0; INTEGERS], floats: [0; FLOATS] };
        for (argument, &at) in self.arguments.iter().zip(places) {
            let Argument { scalar, slot } = *argument;
            // SAFETY: the address points to a value of this type; slots are below the limits that
            // `new` checked.
            unsafe {
                let word = match scalar {
                    None | Some(Scalar::I64 | Scalar::U64 | Scalar::F64) => at.cast::<u64>().read(),
                    Some(Scalar::Bool | Scalar::U8) => u64::from(at.cast::<u8>().read()),
                    Some(Scalar::U16) => u64::from(at.cast::<u16>().read()),
                    Some(Scalar::U32 | Scalar::F32) => u64::from(at.cast::<u32>().read()),
                    Some(Scalar::I8) => i64::from(at.cast::<i8>().read()).cast_unsigned(),
                    Some(Scalar::I16) => i64::from(at.cast::<i16>().read()).cast_unsigned(),
                    Some(Scalar::I32) => i64::from(at.cast::<i32>().read()).cast_unsigned(),
                };
                let bank: &mut [u64] = match scalar {
                    Some(Scalar::F32 | Scalar::F64) => &mut values.floats,
                    _ => &mut values.integers,
                };
                *bank.get_unchecked_mut(slot) = word;
            }
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_and_floats_are_numbered_apart_and_extended() {
        let classes = [
            Class::Value(Scalar::F64),
            Class::Value(Scalar::I8),
            Class::Address,
            Class::Value(Scalar::F32),
            Class::Value(Scalar::U8),
        ];
        // Other platforms have no such plan, as the other test shows.
        let Some(plan) = RegisterPlan::new(&classes) else { return };
        let (mut d, mut i, mut f, mut u) = (1.5_f64, -2_i8, 2.5_f32, 200_u8);
        let mut address = 0x1234_usize;
        let places: [*mut c_void; 5] = [
            (&raw mut d).cast(),
            (&raw mut i).cast(),
            (&raw mut address).cast(),
            (&raw mut f).cast(),
            (&raw mut u).cast(),
        ];
        // SAFETY: the addresses point to values of the classes.
        let values = unsafe { plan.read(&places) };
        assert_eq!(values.integers[..4], [u64::MAX - 1, 0x1234, 200, 0]);
        assert_eq!(values.floats[..3], [1.5_f64.to_bits(), 2.5_f32.to_bits().into(), 0]);
        assert_eq!(plan.integers(), 3);
    }

    #[test]
    fn more_arguments_than_are_passed_this_way_are_left_to_libffi() {
        assert!(RegisterPlan::new(&[Class::Address; 15]).is_none());
        assert!(RegisterPlan::new(&[Class::Value(Scalar::F32); 9]).is_none());
        assert_eq!(RegisterPlan::new(&[Class::Address; 14]).is_some(), SUITED);
    }
}
