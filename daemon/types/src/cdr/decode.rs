//! Decodes CDR into C layout. The bytes are not trusted.

use crate::cdr::error::{CdrError, CdrProblem};
use crate::cdr::plan::plan;
use crate::cdr::reader::{Parsed, Reader};
use crate::cdr::step::{Run, Step, What};
use crate::graph::{Graph, Ix, Shape};
use crate::memory::{Edit, elements, resize, set_text};

/// Reads a value that starts at `from` in a payload, reusing its buffers. On error the value is
/// partly old, partly new.
///
/// # Safety
/// `at` holds a value of the node that nobody else uses meanwhile.
pub(crate) unsafe fn decode(
    graph: &Graph,
    ix: Ix,
    at: *mut u8,
    payload: &[u8],
    from: usize,
    big_endian: bool,
) -> Result<(), CdrError> {
    let mut reader = Reader::new(graph, payload, from, big_endian);
    // SAFETY: the caller's promise.
    unsafe { reader.value(ix, at, 0) }.map_err(|error| *error)
}

impl Reader<'_> {
    /// # Safety
    /// As [`decode`].
    unsafe fn value(&mut self, ix: Ix, at: *mut u8, depth: usize) -> Parsed {
        for step in &plan(self.graph, ix, self.swap).steps {
            // SAFETY: a plan's offsets lie inside the value, which holds what the step says.
            unsafe { self.step(step, at.add(step.offset), depth) }?;
        }
        Ok(())
    }

    /// # Safety
    /// `at` holds what the step says.
    #[inline(always)]
    unsafe fn step(&mut self, step: &Step, at: *mut u8, depth: usize) -> Parsed {
        let ix = step.ix;
        // SAFETY (all below): the caller's promise, and lengths checked before use.
        match step.what {
            // SAFETY: as above.
            What::Copy { bytes, unit } => unsafe { self.copy(ix, step.align, at, bytes, unit) },
            // SAFETY: as above.
            What::Booleans { count } => unsafe { self.set_booleans(ix, at, count) },
            // SAFETY: as above.
            What::Enums { count, limit } => unsafe {
                self.set_enums(ix, step.align, at, (count, limit))
            },
            What::Text { bound } => {
                let text = self.text(step, bound)?;
                // SAFETY: as above; the text lies in the message.
                unsafe { set_text(at, bound, text) };
                Ok(())
            }
            // SAFETY: as above.
            What::Sequence { element, bound, run } => unsafe {
                self.sequence(step, at, (element, bound), run, depth)
            },
            What::Repeat { element, count } => {
                let size = self.graph.node(element).layout.size;
                for index in 0..count {
                    // SAFETY: as above.
                    unsafe { self.value(element, at.add(index * size), depth) }?;
                }
                Ok(())
            }
            What::Optional { element, value } => {
                let present = self.presence(ix, step.align)?;
                // SAFETY: this step is about an optional of that node.
                let mut edit = unsafe { Edit::new(self.graph, ix, at) };
                if !present {
                    edit.set_absent();
                    return Ok(());
                }
                edit.set_present();
                // SAFETY: as above.
                unsafe { self.value(element, at.add(value), depth) }
            }
            // SAFETY: as above.
            What::Union => unsafe { self.union(ix, at, depth) },
            What::Native => Err(self.error(ix, CdrProblem::Native)),
        }
    }

    /// # Safety
    /// `at` has room for the bytes.
    #[inline(always)]
    unsafe fn copy(
        &mut self,
        ix: Ix,
        align: usize,
        at: *mut u8,
        bytes: usize,
        unit: usize,
    ) -> Parsed {
        let from = self.take(ix, align, bytes)?;
        // SAFETY: the caller's promise; `from` has that many bytes.
        unsafe { std::ptr::copy_nonoverlapping(from.as_ptr(), at, bytes) };
        if self.swap && unit > 1 {
            // SAFETY: the bytes were just written.
            let written = unsafe { std::slice::from_raw_parts_mut(at, bytes) };
            written.chunks_exact_mut(unit).for_each(<[u8]>::reverse);
        }
        Ok(())
    }

    /// # Safety
    /// `at` has room for `count` booleans.
    unsafe fn set_booleans(&mut self, ix: Ix, at: *mut u8, count: usize) -> Parsed {
        let from = self.booleans(ix, count)?;
        // SAFETY: the caller's promise.
        unsafe { std::ptr::copy_nonoverlapping(from.as_ptr(), at, count) };
        Ok(())
    }

    /// # Safety
    /// `at` has room for `count` enums.
    unsafe fn set_enums(
        &mut self,
        ix: Ix,
        align: usize,
        at: *mut u8,
        (count, limit): (usize, u32),
    ) -> Parsed {
        self.enums(ix, align, (count, limit), |index, value| {
            // SAFETY: the caller's promise.
            unsafe { at.cast::<u32>().add(index).write(value) };
        })
    }

    /// # Safety
    /// `at` holds a sequence of such elements.
    unsafe fn sequence(
        &mut self,
        step: &Step,
        at: *mut u8,
        (element, bound): (Ix, Option<usize>),
        run: Option<Run>,
        depth: usize,
    ) -> Parsed {
        let ix = step.ix;
        let length = self.length(step, (element, bound), run.is_none(), depth)?;
        let size = self.graph.node(element).layout.size;
        // SAFETY: the caller's promise.
        let Some(buffer) = (unsafe { resize(self.graph, (element, bound), at, length, depth) })
        else {
            return Err(self.error(ix, CdrProblem::Memory));
        };
        if length == 0 {
            return Ok(());
        }
        // SAFETY: the sequence now has `length` elements.
        unsafe {
            debug_assert_eq!(elements(self.graph, element, bound, at), (buffer, length));
            match run {
                Some(Run::Copy { align, unit }) => {
                    self.copy(ix, align, buffer, length * size, unit)
                }
                Some(Run::Booleans) => self.set_booleans(ix, buffer, length * size),
                Some(Run::Enums { limit }) => {
                    self.set_enums(element, 4, buffer, (length * size / 4, limit))
                }
                None => (0..length)
                    .try_for_each(|index| self.value(element, buffer.add(index * size), depth + 1)),
            }
        }
    }

    /// # Safety
    /// `at` holds a union of that node.
    unsafe fn union(&mut self, ix: Ix, at: *mut u8, depth: usize) -> Parsed {
        let shape = &self.graph.node(ix).shape;
        let Shape::Union { switch, members, .. } = shape else { return Ok(()) };
        let value = self.discriminant(*switch, depth)?;
        // SAFETY: the caller's promise.
        unsafe { Edit::new(self.graph, ix, at) }.select(value);
        let selected = shape.selected(value);
        for (rank, part) in members.iter().enumerate() {
            let present = self.presence(ix, 4)?;
            if present != (selected == Some(rank)) {
                return Err(self.error(ix, CdrProblem::Union));
            }
            if present {
                // SAFETY: the discriminant selects this member.
                unsafe { self.value(part.ix, at.add(part.offset), depth) }?;
            }
        }
        Ok(())
    }
    /// The discriminant of a union, which is of this type.
    pub(super) fn discriminant(&mut self, switch: Ix, depth: usize) -> Parsed<i128> {
        let mut word = 0u64;
        // SAFETY: a discriminant is a scalar of at most a word.
        unsafe { self.value(switch, std::ptr::from_mut(&mut word).cast(), depth) }?;
        Ok(Edit::scratch(self.graph, switch, &mut word).view().integer())
    }
}
