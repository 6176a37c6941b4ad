//! Encodes values in C layout as CDR.

use std::mem::MaybeUninit;

use crate::cdr::error::{CdrError, CdrProblem};
use crate::cdr::plan::plan;
use crate::cdr::step::{Run, Step, What};
use crate::graph::{Graph, Ix, Shape};
use crate::layout::MAX_NESTING;
use crate::memory::{elements, integer, text};

/// Appends a value to a payload that starts at `start` in `out`; on error `out` is as before.
///
/// # Safety
/// `at` holds a value of the node that nobody changes meanwhile.
pub(crate) unsafe fn encode(
    graph: &Graph,
    ix: Ix,
    at: *const u8,
    start: usize,
    out: &mut Vec<u8>,
) -> Result<(), CdrError> {
    let (base, length, room) = (out.as_mut_ptr(), out.len(), out.capacity());
    let mut writer = Writer { graph, base, length, room, start, more: out };
    // SAFETY: the caller's promise.
    unsafe { writer.value(ix, at, 0) }.map_err(|error| *error)?;
    let length = writer.length;
    // SAFETY: so many bytes were written, where `more` said that there is room.
    unsafe { out.set_len(length) };
    Ok(())
}

/// Writes a payload into `out`, which must hold its [`size`](super::size) and [`SLACK`] bytes more,
/// all of which may be written; returns the size of the payload. An error when the payload turns
/// out larger.
///
/// # Safety
/// As [`encode`].
pub(crate) unsafe fn encode_into(
    graph: &Graph,
    ix: Ix,
    at: *const u8,
    out: &mut [MaybeUninit<u8>],
) -> Result<usize, CdrError> {
    let (base, room) = (out.as_mut_ptr().cast(), out.len());
    let mut spill = Spill { from: base, rest: None };
    let mut writer = Writer { graph, base, length: 0, room, start: 0, more: &mut spill };
    // SAFETY: the caller's promise.
    unsafe { writer.value(ix, at, 0) }.map_err(|error| *error)?;
    if writer.base != base {
        let problem = CdrProblem::Truncated { needed: writer.length, left: out.len() };
        return Err(CdrError { ty: graph.node(ix).name.clone(), at: 0, problem });
    }
    Ok(writer.length)
}

/// Bytes after the encoded value that the encoder may overwrite.
pub const SLACK: usize = 16;

/// The error is boxed so that a result is one word, returned in a register.
type Encoded = Result<(), Box<CdrError>>;

/// Provides memory when the encoder has no room left.
trait More {
    /// Returns memory that begins with the `length` bytes written so far and has room for `bytes`
    /// more: its address and its whole size.
    ///
    /// # Safety
    /// `length` bytes were written to the previous memory.
    unsafe fn more(&mut self, length: usize, bytes: usize) -> (*mut u8, usize);
}

impl More for Vec<u8> {
    unsafe fn more(&mut self, length: usize, bytes: usize) -> (*mut u8, usize) {
        let before = self.len();
        // SAFETY: they were written, says the caller; `reserve` then moves them along.
        unsafe { self.set_len(length) };
        self.reserve(bytes);
        // Encoding may fail half-way: until it has succeeded, the output keeps its old length.
        self.truncate(before);
        (self.as_mut_ptr(), self.capacity())
    }
}

/// Memory for a value that turns out larger than measured, which happens only when a codel changes
/// it meanwhile: encoding then continues in a buffer of its own and ends as an error.
struct Spill {
    from: *const u8,
    rest: Option<Vec<u8>>,
}

impl More for Spill {
    unsafe fn more(&mut self, length: usize, bytes: usize) -> (*mut u8, usize) {
        let rest = self.rest.get_or_insert_with(|| {
            // SAFETY: so many bytes lie there, says the caller.
            unsafe { std::slice::from_raw_parts(self.from, length) }.to_vec()
        });
        // SAFETY: the caller's promise.
        unsafe { rest.more(length, bytes) }
    }
}

struct Writer<'a> {
    graph: &'a Graph,
    base: *mut u8,
    /// Bytes written at `base`.
    length: usize,
    /// Size of the memory at `base`.
    room: usize,
    /// Where the payload starts: alignment counts from there.
    start: usize,
    more: &'a mut dyn More,
}

impl<'a> Writer<'a> {
    /// Makes room for `bytes` bytes; returns where they begin.
    #[inline(always)]
    fn end(&mut self, bytes: usize) -> *mut u8 {
        if self.room - self.length < bytes {
            self.grow(bytes);
        }
        // SAFETY: the length is within the room.
        unsafe { self.base.add(self.length) }
    }

    #[cold]
    fn grow(&mut self, bytes: usize) {
        // SAFETY: `length` bytes were written at `base`.
        (self.base, self.room) = unsafe { self.more.more(self.length, bytes) };
    }

    /// Pads to an alignment and appends bytes.
    ///
    /// # Safety
    /// `bytes` are readable at `from`, and not where this writes.
    #[inline(always)]
    unsafe fn put(&mut self, align: usize, from: *const u8, bytes: usize) {
        let pad = (self.length - self.start).wrapping_neg() & (align - 1);
        // Padding is always written as eight zero bytes, of which data overwrites the excess: no
        // branch.
        let end = self.end(bytes + SLACK);
        // SAFETY: there is room for the padding (at most 7 of the 8 bytes count) and the bytes.
        unsafe {
            end.cast::<u64>().write_unaligned(0);
            std::ptr::copy_nonoverlapping(from, end.add(pad), bytes);
        }
        self.length += pad + bytes;
    }

    #[inline(always)]
    fn word(&mut self, align: usize, word: u32) {
        // SAFETY: the word is readable.
        unsafe { self.put(align, (&raw const word).cast(), 4) }
    }

    #[cold]
    fn error(&self, ix: Ix, problem: CdrProblem) -> Box<CdrError> {
        let ty = self.graph.node(ix).name.clone();
        Box::new(CdrError { ty, at: self.length - self.start, problem })
    }

    /// # Safety
    /// As [`encode`].
    unsafe fn value(&mut self, ix: Ix, at: *const u8, depth: usize) -> Encoded {
        for step in &plan(self.graph, ix, false).steps {
            // SAFETY: a plan's offsets lie inside the value, which holds what the step says.
            unsafe { self.step(step, at.add(step.offset), depth) }?;
        }
        Ok(())
    }

    /// # Safety
    /// `at` holds what the step says.
    #[inline(always)]
    unsafe fn step(&mut self, step: &Step, at: *const u8, depth: usize) -> Encoded {
        // SAFETY (all below): the caller's promise, and lengths that `memory` vouches for.
        match step.what {
            // SAFETY: as above.
            What::Copy { bytes, .. } => unsafe { self.put(step.align, at, bytes) },
            // SAFETY: as above.
            What::Booleans { count } => unsafe { self.booleans(at, count) },
            // SAFETY: as above.
            What::Enums { count, limit } => unsafe {
                self.enums(step.ix, step.align, at, count, limit)?;
            },
            What::Text { bound } => {
                // SAFETY: as above.
                let text = unsafe { text(at, bound) };
                self.text(step, text, bound)?;
            }
            What::Sequence { element, bound, run } => {
                // SAFETY: as above.
                let (buffer, length) = unsafe { elements(self.graph, element, bound, at) };
                self.word(step.align, length as u32);
                if length == 0 {
                    return Ok(());
                }
                let size = self.graph.node(element).layout.size;
                // SAFETY: as above: `length` elements are values.
                unsafe {
                    match run {
                        Some(Run::Copy { align, .. }) => self.put(align, buffer, length * size),
                        Some(Run::Booleans) => self.booleans(buffer, length * size),
                        Some(Run::Enums { limit }) => {
                            self.enums(element, 1, buffer, length * size / 4, limit)?;
                        }
                        None if depth >= MAX_NESTING => {
                            return Err(self.error(step.ix, CdrProblem::Deep(MAX_NESTING)));
                        }
                        None => {
                            for index in 0..length {
                                self.value(element, buffer.add(index * size), depth + 1)?;
                            }
                        }
                    }
                }
            }
            What::Repeat { element, count } => {
                let size = self.graph.node(element).layout.size;
                for index in 0..count {
                    // SAFETY: as above.
                    unsafe { self.value(element, at.add(index * size), depth) }?;
                }
            }
            What::Optional { element, value } => {
                // SAFETY: as above; `_present` lies first.
                let present = unsafe { at.read() } != 0;
                self.word(step.align, present.into());
                if present {
                    // SAFETY: as above.
                    unsafe { self.value(element, at.add(value), depth) }?;
                }
            }
            // SAFETY: as above.
            What::Union => unsafe { self.union(step.ix, at, depth)? },
            What::Native => return Err(self.error(step.ix, CdrProblem::Native)),
        }
        Ok(())
    }

    /// # Safety
    /// `count` booleans lie at `at`.
    unsafe fn booleans(&mut self, at: *const u8, count: usize) {
        // SAFETY: the caller's promise. C code may store any byte in a boolean: all but 0 are true.
        let bytes = unsafe { std::slice::from_raw_parts(at, count) };
        let end = self.end(count + SLACK);
        for (index, &byte) in bytes.iter().enumerate() {
            // SAFETY: there is room for `count` bytes.
            unsafe { end.add(index).write(u8::from(byte != 0)) };
        }
        self.length += count;
    }

    /// # Safety
    /// `count` enums lie at `at`.
    unsafe fn enums(
        &mut self,
        ix: Ix,
        align: usize,
        at: *const u8,
        count: usize,
        limit: u32,
    ) -> Encoded {
        // SAFETY: the caller's promise.
        let values = unsafe { std::slice::from_raw_parts(at.cast::<u32>(), count) };
        if let Some(&value) = values.iter().find(|&&value| value >= limit) {
            return Err(self.error(ix, CdrProblem::Enumerator { value, count: limit }));
        }
        // SAFETY: the caller's promise.
        unsafe { self.put(align, at, 4 * count) };
        Ok(())
    }

    #[inline(always)]
    fn text(&mut self, step: &Step, text: &[u8], bound: Option<usize>) -> Encoded {
        if !text.is_ascii() && std::str::from_utf8(text).is_err() {
            return Err(self.error(step.ix, CdrProblem::Utf8));
        }
        let bytes = fitting(text, bound);
        let pad = (self.length - self.start).wrapping_neg() & (step.align - 1);
        let end = self.end(bytes + SLACK);
        // SAFETY: there is room for padding (at most 3 bytes count), length, text and NUL; `text`
        // has that many bytes.
        unsafe {
            end.cast::<u64>().write_unaligned(0);
            let end = end.add(pad);
            end.cast::<u32>().write_unaligned(bytes as u32 + 1);
            copy_short(text.as_ptr(), end.add(4), bytes);
            end.add(4 + bytes).write(0);
        }
        self.length += pad + 4 + bytes + 1;
        Ok(())
    }

    /// # Safety
    /// `at` holds a union of that node.
    unsafe fn union(&mut self, ix: Ix, at: *const u8, depth: usize) -> Encoded {
        let shape = &self.graph.node(ix).shape;
        let Shape::Union { switch, members, .. } = shape else { return Ok(()) };
        // SAFETY: the caller's promise; the discriminant lies first.
        let selected = unsafe {
            self.value(*switch, at, depth)?;
            shape.selected(integer(&self.graph.node(*switch).shape, at))
        };
        for (rank, part) in members.iter().enumerate() {
            let present = selected == Some(rank);
            self.word(4, present.into());
            if present {
                // SAFETY: the discriminant selects this member.
                unsafe { self.value(part.ix, at.add(part.offset), depth) }?;
            }
        }
        Ok(())
    }
}

/// How many bytes of a string are encoded.
pub(crate) fn fitting(text: &[u8], bound: Option<usize>) -> usize {
    // A full `char[n]` without NUL: the wire takes one byte less (genom3.md 5.2).
    let most = bound.map_or(u32::MAX as usize - 1, |bound| bound.saturating_sub(1));
    if text.len() > most { whole_characters(text, most) } else { text.len() }
}

/// The longest prefix of at most `most` bytes that cuts no character of valid UTF-8.
fn whole_characters(text: &[u8], most: usize) -> usize {
    let continues = |&at: &usize| text.get(at).is_some_and(|byte| byte & 0xc0 == 0x80);
    (0..=most).rev().find(|at| !continues(at)).unwrap_or(0)
}

/// Copies bytes. For short ones, as names and frame ids are, a call of memcpy would cost more than
/// the copy.
///
/// # Safety
/// Both addresses have that many bytes and do not overlap.
#[inline(always)]
unsafe fn copy_short(from: *const u8, to: *mut u8, bytes: usize) {
    // SAFETY: each arm stays within the bytes; two halves may overlap each other.
    unsafe {
        match bytes {
            8..=16 => {
                let last = from.add(bytes - 8).cast::<u64>().read_unaligned();
                to.cast::<u64>().write_unaligned(from.cast::<u64>().read_unaligned());
                to.add(bytes - 8).cast::<u64>().write_unaligned(last);
            }
            4..=7 => {
                let last = from.add(bytes - 4).cast::<u32>().read_unaligned();
                to.cast::<u32>().write_unaligned(from.cast::<u32>().read_unaligned());
                to.add(bytes - 4).cast::<u32>().write_unaligned(last);
            }
            _ => std::ptr::copy_nonoverlapping(from, to, bytes),
        }
    }
}
