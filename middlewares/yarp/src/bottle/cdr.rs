//! Reads the samples of an outlet, which are CDR that was checked, and writes CDR for an intake,
//! which checks it.

/// A sample in CDR, and how far it was read.
pub(super) struct CdrReader<'a> {
    payload: &'a [u8],
    at: usize,
    big: bool,
}

/// The sample is cut: it was no message of the type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the sample is cut")]
pub(crate) struct Cut;

impl<'a> CdrReader<'a> {
    pub(super) fn new(message: &'a [u8]) -> Result<Self, Cut> {
        let (head, payload) = message.split_at_checked(4).ok_or(Cut)?;
        let big = head.get(1).is_some_and(|order| order & 1 == 0);
        Ok(Self { payload, at: 0, big })
    }

    /// Whether numbers are as bottles have them.
    pub(super) fn is_little(&self) -> bool {
        !self.big
    }

    /// The next `bytes` bytes, aligned as a number of `align` bytes.
    pub(super) fn bytes(&mut self, align: usize, bytes: usize) -> Result<&'a [u8], Cut> {
        if bytes == 0 {
            return Ok(&[]);
        }
        let start = self.at.next_multiple_of(align);
        let end = start.checked_add(bytes).ok_or(Cut)?;
        let taken = self.payload.get(start..end).ok_or(Cut)?;
        self.at = end;
        Ok(taken)
    }

    /// A number of `N` bytes, little endian.
    pub(super) fn number<const N: usize>(&mut self) -> Result<[u8; N], Cut> {
        let mut number: [u8; N] = self.bytes(N, N)?.try_into().map_err(|_| Cut)?;
        if self.big {
            number.reverse();
        }
        Ok(number)
    }

    pub(super) fn length(&mut self) -> Result<usize, Cut> {
        Ok(u32::from_le_bytes(self.number()?) as usize)
    }

    /// A text without its NUL.
    pub(super) fn text(&mut self) -> Result<&'a [u8], Cut> {
        let length = self.length()?;
        let text = self.bytes(1, length)?;
        Ok(text.strip_suffix(&[0]).unwrap_or(text))
    }
}

/// Writes a message in CDR, little endian.
pub(super) struct CdrWriter<'a>(&'a mut Vec<u8>);

/// Bytes before the payload: representation and options.
const HEAD: [u8; 4] = [0, 1, 0, 0];

impl<'a> CdrWriter<'a> {
    /// Begins a message in an empty buffer.
    pub(super) fn new(out: &'a mut Vec<u8>) -> Self {
        out.clear();
        out.extend_from_slice(&HEAD);
        Self(out)
    }

    /// Bytes that begin where a number of `align` bytes may.
    pub(super) fn bytes(&mut self, align: usize, bytes: &[u8]) {
        if bytes.is_empty() {
            return;
        }
        let place = (self.0.len() - HEAD.len()).next_multiple_of(align) + HEAD.len();
        self.0.resize(place, 0);
        self.0.extend_from_slice(bytes);
    }

    pub(super) fn number<const N: usize>(&mut self, little: [u8; N]) {
        self.bytes(N, &little);
    }

    /// Leaves room for a length, which is known later.
    pub(super) fn length_later(&mut self) -> usize {
        self.number(0u32.to_le_bytes());
        self.0.len() - 4
    }

    pub(super) fn set_length(&mut self, place: usize, length: u32) {
        if let Some(room) = self.0.get_mut(place..place + 4) {
            room.copy_from_slice(&length.to_le_bytes());
        }
    }

    pub(super) fn text(&mut self, text: &[u8]) {
        let length = u32::try_from(text.len() + 1).unwrap_or(u32::MAX);
        self.number(length.to_le_bytes());
        self.0.extend_from_slice(text);
        self.0.push(0);
    }
}
