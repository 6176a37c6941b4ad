//! The form in which samples cross: a message in CDR, or the C layout.

use genom_middleware::PublishError;
use genom_types::{DataType, Record};

/// How samples of a port cross.
#[derive(Clone, Debug)]
pub(crate) struct Form {
    pub(crate) ty: DataType,
    /// In their C layout, as the library wants it for types of fixed size.
    pub(crate) layout: bool,
}

impl Form {
    pub(crate) fn new(ty: &DataType, wants_layout: bool) -> Self {
        // Compile the encoding plan now, so that the first write need not.
        ty.prepare();
        Self { ty: ty.clone(), layout: wants_layout && ty.is_fixed_size() }
    }

    /// Initial size in bytes of a buffer for samples.
    pub(crate) fn room(&self) -> usize {
        let size = self.ty.size();
        if self.ty.is_fixed_size() { size + size / 8 + 64 } else { size * 4 + 64 }
    }

    /// Writes a sample into an empty buffer.
    pub(crate) fn pack(&self, value: &Record, out: &mut Vec<u8>) -> Result<(), PublishError> {
        if !self.layout {
            return value.encode_message(out).map_err(|_| PublishError::Serialization);
        }
        let bytes = value.bytes().ok_or(PublishError::Serialization)?;
        out.extend_from_slice(bytes);
        Ok(())
    }

    /// Reads a sample in C layout. `into` is unchanged if it is none.
    pub(crate) fn unpack(&self, sample: &[u8], into: &mut Record) -> bool {
        into.set_bytes(sample).is_ok()
    }
}
