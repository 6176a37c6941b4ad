//! A path from a value to a datum inside it, resolved once to offsets.

use thiserror::Error;

use crate::data_type::DataType;
use crate::graph::Shape;
use crate::memory::SequenceHeader;

/// One step of a path. An optional on the way takes no step: the path leads into its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PathStep {
    /// Member of a struct, union or exception, by index.
    Member(usize),
    /// Element of an array or sequence.
    Index(u32),
}

/// Why a path cannot be resolved.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PathError {
    /// A member that the type does not have.
    #[error("{ty} has no member number {index}")]
    Member {
        /// Spelling of the type.
        ty: String,
        /// The member asked for.
        index: usize,
    },
    /// An index beyond the length of an array or the bound of a sequence.
    #[error("{ty} has no element [{index}]; the last one is before [{length}]")]
    Element {
        /// Spelling of the type.
        ty: String,
        /// The element asked for.
        index: u32,
        /// Length of the array or bound of the sequence.
        length: usize,
    },
    /// An index into something that is neither array nor sequence.
    #[error("{ty} is no array and no sequence; it has no element [{index}]")]
    NotIndexed {
        /// Spelling of the type.
        ty: String,
        /// The element asked for.
        index: u32,
    },
}

/// A resolved path from a root type to a datum: offsets to add, and a check of the length at each
/// sequence on the way.
#[derive(Clone, Debug)]
pub struct CompiledPath {
    root: DataType,
    target: DataType,
    hops: Vec<Hop>,
    /// Offset of the datum from where the last hop ended, in bytes.
    offset: usize,
}

/// A sequence on the path.
#[derive(Clone, Copy, Debug)]
struct Hop {
    /// Offset of the sequence from where the previous hop ended, in bytes.
    offset: usize,
    index: usize,
    /// Size of an element in bytes.
    size: usize,
    /// Offset of the buffer in a bounded sequence; `None` for an unbounded one, whose buffer is
    /// behind a pointer.
    buffer: Option<usize>,
    bound: usize,
}

impl CompiledPath {
    /// Resolves a path. It leads through optionals whether or not they are present, and through
    /// union members whether or not they are selected: codels are given addresses of those too.
    ///
    /// # Errors
    /// A step does not exist in the type it starts from.
    pub fn new(root: &DataType, steps: &[PathStep]) -> Result<Self, PathError> {
        let mut path =
            Self { root: root.clone(), target: root.clone(), hops: Vec::new(), offset: 0 };
        for &step in steps {
            path.step(step)?;
        }
        Ok(path)
    }

    fn step(&mut self, step: PathStep) -> Result<(), PathError> {
        while let Shape::Optional { element } = self.target.node().shape {
            self.offset += self.target.layout().offsets[0];
            self.target = self.target.at(element);
        }
        let here = self.target.clone();
        let name = || here.name().to_owned();
        match (&here.node().shape, step) {
            (Shape::Struct { members } | Shape::Union { members, .. }, PathStep::Member(index)) => {
                let part =
                    members.get(index).ok_or_else(|| PathError::Member { ty: name(), index })?;
                self.offset += part.offset;
                self.target = here.at(part.ix);
            }
            (&Shape::Array { element, length }, PathStep::Index(index)) => {
                if index as usize >= length {
                    return Err(PathError::Element { ty: name(), index, length });
                }
                self.target = here.at(element);
                self.offset += index as usize * self.target.size();
            }
            (&Shape::Sequence { element, bound }, PathStep::Index(index)) => {
                if let Some(length) = bound.filter(|&bound| index as usize >= bound) {
                    return Err(PathError::Element { ty: name(), index, length });
                }
                self.target = here.at(element);
                self.hops.push(Hop {
                    offset: std::mem::take(&mut self.offset),
                    index: index as usize,
                    size: self.target.size(),
                    buffer: bound.map(|_| here.layout().offsets[2]),
                    bound: bound.unwrap_or(usize::MAX),
                });
            }
            (_, PathStep::Member(index)) => {
                return Err(PathError::Member { ty: name(), index });
            }
            (_, PathStep::Index(index)) => {
                return Err(PathError::NotIndexed { ty: name(), index });
            }
        }
        Ok(())
    }

    /// The type it starts from.
    #[must_use]
    pub fn root(&self) -> &DataType {
        &self.root
    }

    /// The type of the datum it leads to.
    #[must_use]
    pub fn target(&self) -> &DataType {
        &self.target
    }

    /// Offset of the datum from the root in bytes, when no sequence is on the path.
    #[must_use]
    pub fn constant_offset(&self) -> Option<usize> {
        self.hops.is_empty().then_some(self.offset)
    }

    /// Address of the datum; `None` when a sequence on the path is too short.
    ///
    /// # Safety
    /// `root` holds a value of the root type that nobody changes meanwhile.
    #[must_use]
    pub unsafe fn locate(&self, root: *mut u8) -> Option<*mut u8> {
        let mut at = root;
        for hop in &self.hops {
            // SAFETY: offsets come from the layouts, so a sequence lies there; elements below
            // its readable length are values.
            unsafe {
                at = at.add(hop.offset);
                let (buffer, length) = match hop.buffer {
                    Some(offset) => {
                        let length = at.add(4).cast::<u32>().read() as usize;
                        (at.add(offset), length.min(hop.bound))
                    }
                    None => {
                        let header = at.cast::<SequenceHeader>().read();
                        (header.buffer, header.readable())
                    }
                };
                if hop.index >= length {
                    return None;
                }
                at = buffer.add(hop.index * hop.size);
            }
        }
        // SAFETY: as above.
        Some(unsafe { at.add(self.offset) })
    }
}
