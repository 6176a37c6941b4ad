//! Decodes CDR into C layout. The bytes are not trusted.

use crate::cdr::error::{CdrError, CdrProblem};
use crate::cdr::plan::plan;
use crate::cdr::step::{Run, Step, What};
use crate::graph::{Graph, Ix, Shape};
use crate::layout::MAX_NESTING;
use crate::memory::{Edit, elements, resize, set_text};

/// Bytes that decoding any message may allocate, in addition to [`PER_BYTE`]: empty strings and
/// sequences take much less on the wire than in memory.
const FREE_MEMORY: usize = 1 << 26;

/// Bytes that decoding may allocate for each byte of the message.
const PER_BYTE: usize = 64;

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
    let budget = FREE_MEMORY.saturating_add(payload.len().saturating_mul(PER_BYTE));
    let mut reader = Reader { graph, payload, at: from, swap: big_endian, budget };
    // SAFETY: the caller's promise.
    unsafe { reader.value(ix, at, 0) }.map_err(|error| *error)
}

/// The error is boxed so that a result is one word, returned in a register.
type Decoded = Result<(), Box<CdrError>>;

struct Reader<'a> {
    graph: &'a Graph,
    payload: &'a [u8],
    at: usize,
    swap: bool,
    /// Bytes that may still be allocated.
    budget: usize,
}

impl<'a> Reader<'a> {
    #[cold]
    fn error(&self, ix: Ix, problem: CdrProblem) -> Box<CdrError> {
        Box::new(CdrError { ty: self.graph.node(ix).name.clone(), at: self.at, problem })
    }

    /// Aligns, then takes the next `bytes` bytes.
    #[inline(always)]
    fn take(&mut self, ix: Ix, align: usize, bytes: usize) -> Result<&'a [u8], Box<CdrError>> {
        let start = self.at + (self.at.wrapping_neg() & (align - 1));
        let left = self.payload.len().saturating_sub(start);
        if bytes > left {
            return Err(self.error(ix, CdrProblem::Truncated { needed: bytes, left }));
        }
        if bytes > 0 {
            self.at = start + bytes;
        }
        Ok(self.payload.get(start..start + bytes).unwrap_or(&[]))
    }

    #[inline(always)]
    fn word(&mut self, ix: Ix, align: usize) -> Result<u32, Box<CdrError>> {
        let bytes = self.take(ix, align, 4)?;
        let word = <[u8; 4]>::try_from(bytes).map_or(0, u32::from_le_bytes);
        Ok(if self.swap { word.swap_bytes() } else { word })
    }

    /// # Safety
    /// As [`decode`].
    unsafe fn value(&mut self, ix: Ix, at: *mut u8, depth: usize) -> Decoded {
        for step in &plan(self.graph, ix, self.swap).steps {
            // SAFETY: a plan's offsets lie inside the value, which holds what the step says.
            unsafe { self.step(step, at.add(step.offset), depth) }?;
        }
        Ok(())
    }

    /// # Safety
    /// `at` holds what the step says.
    #[inline(always)]
    unsafe fn step(&mut self, step: &Step, at: *mut u8, depth: usize) -> Decoded {
        let ix = step.ix;
        // SAFETY (all below): the caller's promise, and lengths checked before use.
        match step.what {
            // SAFETY: as above.
            What::Copy { bytes, unit } => unsafe { self.copy(ix, step.align, at, bytes, unit) },
            // SAFETY: as above.
            What::Booleans { count } => unsafe { self.booleans(ix, at, count) },
            // SAFETY: as above.
            What::Enums { count, limit } => unsafe { self.enums(ix, step.align, at, count, limit) },
            // SAFETY: as above.
            What::Text { bound } => unsafe { self.text(step, at, bound) },
            What::Sequence { element, bound, run } => {
                let length = self.word(ix, step.align)? as usize;
                // SAFETY: as above.
                unsafe { self.sequence(ix, at, (element, bound), run, length, depth) }
            }
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

    /// The length of a sequence of 0 or 1 elements, which stands for an optional.
    fn presence(&mut self, ix: Ix, align: usize) -> Result<bool, Box<CdrError>> {
        match self.word(ix, align)? {
            0 => Ok(false),
            1 => Ok(true),
            length => {
                let length = length as usize;
                Err(self.error(ix, CdrProblem::Length { length, most: 1 }))
            }
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
    ) -> Decoded {
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
    unsafe fn booleans(&mut self, ix: Ix, at: *mut u8, count: usize) -> Decoded {
        let from = self.take(ix, 1, count)?;
        if let Some(&wrong) = from.iter().find(|&&byte| byte > 1) {
            return Err(self.error(ix, CdrProblem::Boolean(wrong)));
        }
        // SAFETY: the caller's promise.
        unsafe { std::ptr::copy_nonoverlapping(from.as_ptr(), at, count) };
        Ok(())
    }

    /// # Safety
    /// `at` has room for `count` enums.
    unsafe fn enums(
        &mut self,
        ix: Ix,
        align: usize,
        at: *mut u8,
        count: usize,
        limit: u32,
    ) -> Decoded {
        let from = self.take(ix, align, 4 * count)?;
        for (index, bytes) in from.chunks_exact(4).enumerate() {
            let word = <[u8; 4]>::try_from(bytes).map_or(0, u32::from_le_bytes);
            let value = if self.swap { word.swap_bytes() } else { word };
            if value >= limit {
                return Err(self.error(ix, CdrProblem::Enumerator { value, count: limit }));
            }
            // SAFETY: the caller's promise.
            unsafe { at.cast::<u32>().add(index).write(value) };
        }
        Ok(())
    }

    /// # Safety
    /// `at` holds a string with that bound.
    #[inline(always)]
    unsafe fn text(&mut self, step: &Step, at: *mut u8, bound: Option<usize>) -> Decoded {
        let length = self.word(step.ix, step.align)? as usize;
        let bytes = self.take(step.ix, 1, length)?;
        let text = match bytes {
            // Some writers encode an empty string without its NUL.
            [] => bytes,
            [text @ .., 0] if !text.contains(&0) => text,
            _ => return Err(self.error(step.ix, CdrProblem::Nul)),
        };
        if let Some(most) = bound.map(|bound| bound.saturating_sub(1))
            && text.len() > most
        {
            let length = text.len();
            return Err(self.error(step.ix, CdrProblem::Length { length, most }));
        }
        if std::str::from_utf8(text).is_err() {
            return Err(self.error(step.ix, CdrProblem::Utf8));
        }
        // SAFETY: the caller's promise; the text lies in the message.
        unsafe { set_text(at, bound, text) };
        Ok(())
    }

    /// # Safety
    /// `at` holds a sequence of such elements.
    unsafe fn sequence(
        &mut self,
        ix: Ix,
        at: *mut u8,
        (element, bound): (Ix, Option<usize>),
        run: Option<Run>,
        length: usize,
        depth: usize,
    ) -> Decoded {
        let node = self.graph.node(element);
        // A length that the remaining bytes cannot hold is refused before anything is allocated.
        let left = self.payload.len() - self.at.min(self.payload.len());
        let most = (left / node.least_wire.max(1)).min(bound.unwrap_or(usize::MAX));
        if length > most {
            return Err(self.error(ix, CdrProblem::Length { length, most }));
        }
        if run.is_none() && length > 0 && depth >= MAX_NESTING {
            return Err(self.error(ix, CdrProblem::Deep(MAX_NESTING)));
        }
        let size = node.layout.size;
        if bound.is_none() {
            match self.budget.checked_sub(length.saturating_mul(size)) {
                Some(budget) => self.budget = budget,
                None => return Err(self.error(ix, CdrProblem::Memory)),
            }
        }
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
                Some(Run::Booleans) => self.booleans(ix, buffer, length * size),
                Some(Run::Enums { limit }) => {
                    self.enums(element, 4, buffer, length * size / 4, limit)
                }
                None => (0..length)
                    .try_for_each(|index| self.value(element, buffer.add(index * size), depth + 1)),
            }
        }
    }

    /// # Safety
    /// `at` holds a union of that node.
    unsafe fn union(&mut self, ix: Ix, at: *mut u8, depth: usize) -> Decoded {
        let shape = &self.graph.node(ix).shape;
        let Shape::Union { switch, members, .. } = shape else { return Ok(()) };
        let mut word = 0u64;
        // SAFETY: a discriminant is a scalar of at most a word.
        unsafe { self.value(*switch, std::ptr::from_mut(&mut word).cast(), depth) }?;
        let value = Edit::scratch(self.graph, *switch, &mut word).view().integer();
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
}
