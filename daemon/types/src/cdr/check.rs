//! Whether bytes are a value of a type, as decoding them would find, without a place to decode them
//! to: for who passes messages on.

use crate::cdr::error::{CdrError, CdrProblem};
use crate::cdr::open;
use crate::cdr::plan::plan;
use crate::cdr::reader::{Parsed, Reader};
use crate::cdr::step::{Run, Step, What};
use crate::data_type::DataType;
use crate::graph::{Ix, Shape};

impl DataType {
    /// Size of the message at the beginning of these bytes, if they begin with one that
    /// [`Record::decode_message`](crate::Record::decode_message) would read; bytes after it pad it.
    ///
    /// # Errors
    /// As when it is read.
    pub fn check_message(&self, message: &[u8]) -> Result<usize, CdrError> {
        let (payload, big_endian) = open(self, message)?;
        let mut reader = Reader::new(self.graph(), payload, 0, big_endian);
        reader.pass(self.ix(), 0).map_err(|error| *error)?;
        Ok(message.len() - payload.len() + reader.at)
    }
}

impl Reader<'_> {
    fn pass(&mut self, ix: Ix, depth: usize) -> Parsed {
        plan(self.graph, ix, self.swap).steps.iter().try_for_each(|step| self.pass_by(step, depth))
    }

    fn pass_by(&mut self, step: &Step, depth: usize) -> Parsed {
        let ix = step.ix;
        match step.what {
            What::Copy { bytes, .. } => self.take(ix, step.align, bytes).map(drop),
            What::Booleans { count } => self.booleans(ix, count).map(drop),
            What::Enums { count, limit } => self.enums(ix, step.align, (count, limit), |_, _| {}),
            What::Text { bound } => self.text(step, bound).map(drop),
            What::Sequence { element, bound, run } => {
                let length = self.length(step, (element, bound), run.is_none(), depth)?;
                self.pass_elements(ix, element, run, length, depth)
            }
            What::Repeat { element, count } => {
                (0..count).try_for_each(|_| self.pass(element, depth))
            }
            What::Optional { element, .. } => match self.presence(ix, step.align)? {
                true => self.pass(element, depth),
                false => Ok(()),
            },
            What::Union => self.pass_union(ix, depth),
            What::Native => Err(self.error(ix, CdrProblem::Native)),
        }
    }

    fn pass_elements(
        &mut self,
        ix: Ix,
        element: Ix,
        run: Option<Run>,
        length: usize,
        depth: usize,
    ) -> Parsed {
        if length == 0 {
            return Ok(());
        }
        let bytes = length * self.graph.node(element).layout.size;
        match run {
            Some(Run::Copy { align, .. }) => self.take(ix, align, bytes).map(drop),
            Some(Run::Booleans) => self.booleans(ix, bytes).map(drop),
            Some(Run::Enums { limit }) => self.enums(element, 4, (bytes / 4, limit), |_, _| {}),
            None => (0..length).try_for_each(|_| self.pass(element, depth + 1)),
        }
    }

    fn pass_union(&mut self, ix: Ix, depth: usize) -> Parsed {
        let shape = &self.graph.node(ix).shape;
        let Shape::Union { switch, members, .. } = shape else { return Ok(()) };
        let selected = shape.selected(self.discriminant(*switch, depth)?);
        for (rank, part) in members.iter().enumerate() {
            let present = self.presence(ix, 4)?;
            if present != (selected == Some(rank)) {
                return Err(self.error(ix, CdrProblem::Union));
            }
            if present {
                self.pass(part.ix, depth)?;
            }
        }
        Ok(())
    }
}
