//! Paths to data inside C++ values. One of the few unsafe modules.
#![allow(unsafe_code)]

use genom_types::{CompiledPath, PathStep};

use super::error::CxxPathError;
use super::layout::{CxxType, Shape};
use super::life::Vector;
use super::transfer::bounded_length;

/// The path from a root type to a datum in C++; corresponds to `CompiledPath` in C.
#[derive(Clone, Debug)]
pub(crate) struct CxxPath {
    target: CxxType,
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
    /// For a bounded sequence: offset of its length, and the bound.
    bounded: Option<(usize, usize)>,
}

impl CxxPath {
    /// Resolves a path that is valid in C.
    ///
    /// # Errors
    /// The path has no equivalent in C++.
    pub(crate) fn new(root: &CxxType, steps: &[PathStep]) -> Result<Self, CxxPathError> {
        let mut path = Self { target: root.clone(), hops: Vec::new(), offset: 0 };
        steps.iter().try_for_each(|step| path.step(*step))?;
        Ok(path)
    }

    fn step(&mut self, step: PathStep) -> Result<(), CxxPathError> {
        while let Shape::Optional { element, at, .. } = self.target.node().shape {
            self.offset += at;
            self.target = self.target.at(element);
        }
        let here = self.target.clone();
        let (element, bounded) = match (&here.node().shape, step) {
            (Shape::Struct { parts }, PathStep::Member(rank)) => {
                let part = parts.get(rank).ok_or(CxxPathError::Member)?;
                self.offset += part.at;
                self.target = here.at(part.node);
                return Ok(());
            }
            (Shape::Array { element, .. }, PathStep::Index(index)) => {
                self.target = here.at(*element);
                self.offset += index as usize * self.target.size();
                return Ok(());
            }
            (Shape::Plain, _) => {
                // From here on the layout is that of C.
                let inside = CompiledPath::new(here.c(), &[step])?;
                self.offset += inside.constant_offset().ok_or(CxxPathError::Sequence)?;
                self.target = CxxType::new(inside.target())?;
                return Ok(());
            }
            (Shape::Vector { element }, PathStep::Index(_)) => (*element, None),
            (Shape::Bounded { element, bound, length_at }, PathStep::Index(_)) => {
                (*element, Some((*length_at, *bound)))
            }
            (Shape::Flags, PathStep::Index(_)) => return Err(CxxPathError::Bit),
            _ => return Err(CxxPathError::Part { ty: here.c().name().to_owned() }),
        };
        let PathStep::Index(index) = step else { return Ok(()) };
        self.target = here.at(element);
        self.hops.push(Hop {
            offset: std::mem::take(&mut self.offset),
            index: index as usize,
            size: self.target.size(),
            bounded,
        });
        Ok(())
    }

    /// The type of the datum it leads to.
    pub(crate) fn target(&self) -> &CxxType {
        &self.target
    }

    /// Offset of the datum from the root in bytes, when no sequence is on the path.
    pub(crate) fn constant_offset(&self) -> Option<usize> {
        self.hops.is_empty().then_some(self.offset)
    }

    /// Address of the datum; `None` when a sequence on the path is too short.
    ///
    /// # Safety
    /// `root` holds a value of the root type that nobody changes meanwhile.
    pub(crate) unsafe fn locate(&self, root: *mut u8) -> Option<*mut u8> {
        let mut at = root;
        for hop in &self.hops {
            // SAFETY: offsets come from the layouts, so a sequence lies there; elements below
            // its length are values.
            unsafe {
                at = at.add(hop.offset);
                let (first, length) = match hop.bounded {
                    Some((length_at, bound)) => (at, bounded_length(at, length_at, bound)),
                    None => {
                        let vector = at.cast::<Vector>().read();
                        (vector.begin, vector.length(hop.size))
                    }
                };
                if hop.index >= length {
                    return None;
                }
                at = first.add(hop.index * hop.size);
            }
        }
        // SAFETY: as above.
        Some(unsafe { at.add(self.offset) })
    }
}
