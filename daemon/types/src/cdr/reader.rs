//! Reads the parts of CDR. The bytes are not trusted.

use crate::cdr::error::{CdrError, CdrProblem};
use crate::cdr::step::Step;
use crate::graph::{Graph, Ix};
use crate::layout::MAX_NESTING;

/// Bytes that decoding any message may allocate, in addition to [`PER_BYTE`]: empty strings and
/// sequences take much less on the wire than in memory.
const FREE_MEMORY: usize = 1 << 26;

/// Bytes that decoding may allocate for each byte of the message.
const PER_BYTE: usize = 64;

/// The error is boxed so that a result is one word, returned in a register.
pub(super) type Parsed<T = ()> = Result<T, Box<CdrError>>;

/// A payload, and how far it was read.
pub(super) struct Reader<'a> {
    pub(super) graph: &'a Graph,
    payload: &'a [u8],
    pub(super) at: usize,
    pub(super) swap: bool,
    /// Bytes that may still be allocated.
    budget: usize,
}

impl<'a> Reader<'a> {
    /// Of a value that starts at `from`.
    pub(super) fn new(graph: &'a Graph, payload: &'a [u8], from: usize, swap: bool) -> Self {
        let budget = FREE_MEMORY.saturating_add(payload.len().saturating_mul(PER_BYTE));
        Self { graph, payload, at: from, swap, budget }
    }

    #[cold]
    pub(super) fn error(&self, ix: Ix, problem: CdrProblem) -> Box<CdrError> {
        Box::new(CdrError { ty: self.graph.node(ix).name.clone(), at: self.at, problem })
    }

    /// Aligns, then takes the next `bytes` bytes.
    #[inline(always)]
    pub(super) fn take(&mut self, ix: Ix, align: usize, bytes: usize) -> Parsed<&'a [u8]> {
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
    fn word(&mut self, ix: Ix, align: usize) -> Parsed<u32> {
        let bytes = self.take(ix, align, 4)?;
        let word = <[u8; 4]>::try_from(bytes).map_or(0, u32::from_le_bytes);
        Ok(if self.swap { word.swap_bytes() } else { word })
    }

    /// The length of a sequence of 0 or 1 elements, which stands for an optional.
    pub(super) fn presence(&mut self, ix: Ix, align: usize) -> Parsed<bool> {
        match self.word(ix, align)? {
            0 => Ok(false),
            1 => Ok(true),
            length => {
                let length = length as usize;
                Err(self.error(ix, CdrProblem::Length { length, most: 1 }))
            }
        }
    }

    /// Bytes that are booleans.
    pub(super) fn booleans(&mut self, ix: Ix, count: usize) -> Parsed<&'a [u8]> {
        let from = self.take(ix, 1, count)?;
        match from.iter().find(|&&byte| byte > 1) {
            Some(&wrong) => Err(self.error(ix, CdrProblem::Boolean(wrong))),
            None => Ok(from),
        }
    }

    /// Enums below `limit`, each with its index.
    #[inline(always)]
    pub(super) fn enums(
        &mut self,
        ix: Ix,
        align: usize,
        (count, limit): (usize, u32),
        mut each: impl FnMut(usize, u32),
    ) -> Parsed {
        let from = self.take(ix, align, 4 * count)?;
        for (index, bytes) in from.chunks_exact(4).enumerate() {
            let word = <[u8; 4]>::try_from(bytes).map_or(0, u32::from_le_bytes);
            let value = if self.swap { word.swap_bytes() } else { word };
            if value >= limit {
                return Err(self.error(ix, CdrProblem::Enumerator { value, count: limit }));
            }
            each(index, value);
        }
        Ok(())
    }

    /// A text without its NUL.
    #[inline(always)]
    pub(super) fn text(&mut self, step: &Step, bound: Option<usize>) -> Parsed<&'a [u8]> {
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
        match std::str::from_utf8(text) {
            Ok(_) => Ok(text),
            Err(_) => Err(self.error(step.ix, CdrProblem::Utf8)),
        }
    }

    /// The length of a sequence. One that the remaining bytes cannot hold, or that takes too much
    /// memory, is refused before anything is allocated.
    pub(super) fn length(
        &mut self,
        step: &Step,
        (element, bound): (Ix, Option<usize>),
        nests: bool,
        depth: usize,
    ) -> Parsed<usize> {
        let ix = step.ix;
        let length = self.word(ix, step.align)? as usize;
        let node = self.graph.node(element);
        let left = self.payload.len() - self.at.min(self.payload.len());
        let most = (left / node.least_wire.max(1)).min(bound.unwrap_or(usize::MAX));
        if length > most {
            return Err(self.error(ix, CdrProblem::Length { length, most }));
        }
        if nests && length > 0 && depth >= MAX_NESTING {
            return Err(self.error(ix, CdrProblem::Deep(MAX_NESTING)));
        }
        if bound.is_none() {
            match self.budget.checked_sub(length.saturating_mul(node.layout.size)) {
                Some(budget) => self.budget = budget,
                None => return Err(self.error(ix, CdrProblem::Memory)),
            }
        }
        Ok(length)
    }
}
