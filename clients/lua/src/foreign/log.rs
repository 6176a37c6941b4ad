//! Where errors of codels are written.

/// A function that takes a text and its size.
pub(super) type Write = unsafe extern "C" fn(*const u8, usize);

/// Writes errors of codels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Log(Write);

impl Log {
    /// The log of genomd.
    pub(super) fn new(write: Write) -> Self {
        Self(write)
    }

    pub(crate) fn error(self, text: &str) {
        // SAFETY: the text is that many bytes, and is not kept.
        unsafe { (self.0)(text.as_ptr(), text.len()) };
    }

    /// One that writes to standard error, where there is no genomd.
    pub(crate) fn standard() -> Self {
        unsafe extern "C" fn write(text: *const u8, size: usize) {
            // SAFETY: as `error` calls it.
            let text = unsafe { std::slice::from_raw_parts(text, size) };
            eprintln!("{}", String::from_utf8_lossy(text));
        }
        Self(write)
    }
}
