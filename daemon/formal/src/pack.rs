//! States as bytes: a few dozen for each, so that millions fit into memory.

use crate::action::End;
use crate::state::{At, Life, Mode, Pc, Pending, Phase, Place, Run, State, Step, Task, Worker};
use genom_timing::Lock;

/// A value that can be written as bytes, and read back.
pub(crate) trait Pack: Sized {
    /// Writes it.
    fn put(&self, out: &mut Vec<u8>);
    /// Reads what was written; something else if the bytes are not that.
    fn take(from: &mut &[u8]) -> Self;
}

/// The bytes of a state.
pub(crate) fn packed(state: &State) -> Box<[u8]> {
    let mut out = Vec::with_capacity(64);
    state.put(&mut out);
    out.into_boxed_slice()
}

/// Writes the bytes of a state over what was there.
pub(crate) fn pack(state: &State, out: &mut Vec<u8>) {
    out.clear();
    state.put(out);
}

/// The state of these bytes.
pub(crate) fn unpacked(mut bytes: &[u8]) -> State {
    State::take(&mut bytes)
}

impl Pack for u8 {
    fn put(&self, out: &mut Vec<u8>) {
        out.push(*self);
    }

    fn take(from: &mut &[u8]) -> Self {
        let Some((first, rest)) = from.split_first() else { return 0 };
        *from = rest;
        *first
    }
}

/// Seven bits in a byte, the lowest first; the eighth says that more follow.
impl Pack for u32 {
    fn put(&self, out: &mut Vec<u8>) {
        let mut left = *self;
        while left > 0x7f {
            out.push((left & 0x7f) as u8 | 0x80);
            left >>= 7;
        }
        out.push(left as u8);
    }

    fn take(from: &mut &[u8]) -> Self {
        let (mut number, mut shift) = (0, 0);
        loop {
            let byte = u8::take(from);
            number |= u32::from(byte & 0x7f) << shift;
            shift += 7;
            if byte & 0x80 == 0 || shift > 28 {
                return number;
            }
        }
    }
}

impl Pack for u16 {
    fn put(&self, out: &mut Vec<u8>) {
        u32::from(*self).put(out);
    }

    fn take(from: &mut &[u8]) -> Self {
        Self::try_from(u32::take(from)).unwrap_or(Self::MAX)
    }
}

impl Pack for bool {
    fn put(&self, out: &mut Vec<u8>) {
        out.push(u8::from(*self));
    }

    fn take(from: &mut &[u8]) -> Self {
        u8::take(from) != 0
    }
}

impl<T: Pack> Pack for Vec<T> {
    fn put(&self, out: &mut Vec<u8>) {
        u32::try_from(self.len()).unwrap_or(u32::MAX).put(out);
        self.iter().for_each(|item| item.put(out));
    }

    fn take(from: &mut &[u8]) -> Self {
        let count = u32::take(from);
        (0..count).map(|_| T::take(from)).collect()
    }
}

impl<A: Pack, B: Pack> Pack for (A, B) {
    fn put(&self, out: &mut Vec<u8>) {
        self.0.put(out);
        self.1.put(out);
    }

    fn take(from: &mut &[u8]) -> Self {
        (A::take(from), B::take(from))
    }
}

/// Enumerations: a number for each variant, then its fields.
macro_rules! variants {
    ($type:ty { $($tag:literal => $variant:pat => $make:expr, [$($field:ident: $of:ty),*];)* }) => {
        impl Pack for $type {
            #[allow(unused_variables)]
            fn put(&self, out: &mut Vec<u8>) {
                match self {
                    $($variant => { out.push($tag); $($field.put(out);)* })*
                }
            }

            fn take(from: &mut &[u8]) -> Self {
                let tag = u8::take(from);
                $(if tag == $tag { $(let $field = <$of>::take(from);)* return $make; })*
                Self::default()
            }
        }
    };
}
/// Structures: their fields in order.
macro_rules! fields {
    ($type:ident { $($field:ident),* }) => {
        impl Pack for $type {
            fn put(&self, out: &mut Vec<u8>) {
                $(self.$field.put(out);)*
            }

            fn take(from: &mut &[u8]) -> Self {
                $(let $field = Pack::take(from);)*
                $type { $($field),* }
            }
        }
    };
}

variants! { Phase {
    0 => Self::Starting(task) => Self::Starting(task), [task: u16];
    1 => Self::Running => Self::Running, [];
    2 => Self::Stopping(step) => Self::Stopping(step), [step: Step];
    3 => Self::Stopped => Self::Stopped, [];
} }
variants! { Step {
    0 => Self::Activities => Self::Activities, [];
    1 => Self::Permanent(task) => Self::Permanent(task), [task: u16];
} }
variants! { At {
    0 => Self::Absent => Self::Absent, [];
    1 => Self::Sleep => Self::Sleep, [];
    2 => Self::Begin { tick } => Self::Begin { tick }, [tick: bool];
    3 => Self::Codel { run, place } => Self::Codel { run, place }, [run: u16, place: u16];
    4 => Self::Fetch { run } => Self::Fetch { run }, [run: u16];
    5 => Self::Wake => Self::Wake, [];
} }
variants! { Life {
    0 => Self::Init => Self::Init, [];
    1 => Self::Run => Self::Run, [];
    2 => Self::Stop => Self::Stop, [];
    3 => Self::Cancelled => Self::Cancelled, [];
} }
variants! { Mode {
    0 => Self::Done => Self::Done, [];
    1 => Self::Asleep => Self::Asleep, [];
    2 => Self::Paused => Self::Paused, [];
    3 => Self::Ready => Self::Ready, [];
} }
variants! { Option<End> {
    0 => None => None, [];
    1 => Some(End::Success) => Some(End::Success), [];
    2 => Some(End::Interrupted) => Some(End::Interrupted), [];
    3 => Some(End::Failed) => Some(End::Failed), [];
} }
variants! { Pc {
    0 => Self::Work(item) => Self::Work(item), [item: u16];
    1 => Self::Wake(ok) => Self::Wake(ok), [ok: bool];
    2 => Self::Conclude => Self::Conclude, [];
} }
fields! { Place { state, mode } }
fields! { Run { machine, life, at_stop, asked, places, end, number } }
fields! { Task { at, runs, inbox, outbox, fired, runnable, again, moved, late, young } }
fields! { Pending { service, number } }
fields! { Worker { service, pc } }
fields! { Lock { held, queue } }
fields! { State { phase, tasks, pending, workers, lock, ran, failed, next } }
