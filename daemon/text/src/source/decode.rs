//! From bytes to the text that is lexed.
//!
//! First the encoding, then translation phases 1 and 2 of C: trigraphs and joined lines. Both can
//! map offsets back to the original bytes.

use std::sync::Arc;

/// Encoding of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// The file is UTF-8.
    Utf8,
    /// The file is not UTF-8: each byte is one character, so that nothing is lost.
    Latin1,
}

impl Encoding {
    /// The bytes of a text in a file of this encoding.
    #[must_use]
    pub fn encode(self, text: &str) -> Vec<u8> {
        match self {
            Encoding::Utf8 => text.as_bytes().to_vec(),
            // Characters above U+00FF cannot come from decoding; they keep their UTF-8 bytes.
            Encoding::Latin1 => text.chars().fold(Vec::new(), |mut bytes, c| {
                match u8::try_from(u32::from(c)) {
                    Ok(byte) => bytes.push(byte),
                    Err(_) => bytes.extend(c.to_string().bytes()),
                }
                bytes
            }),
        }
    }
}

/// The text of a file: UTF-8, or Latin-1 when it is not.
#[must_use]
pub fn decode(bytes: Vec<u8>) -> (Arc<str>, Encoding) {
    match String::from_utf8(bytes) {
        Ok(text) => (text.into(), Encoding::Utf8),
        Err(error) => {
            let text: String = error.as_bytes().iter().map(|byte| char::from(*byte)).collect();
            (text.into(), Encoding::Latin1)
        }
    }
}

/// A text with trigraphs replaced and continued lines joined, which maps back to the original.
#[derive(Clone, Debug)]
pub(crate) struct Logical {
    pub(crate) text: Arc<str>,
    /// (offset here, offset in the file) after each change.
    shifts: Arc<[(u32, u32)]>,
}

impl Logical {
    pub(crate) fn new(original: &Arc<str>) -> Self {
        let bytes = original.as_bytes();
        let mut text = String::new();
        let mut shifts = Vec::new();
        let mut copied = 0;
        let mut at = 0;
        while at < bytes.len() {
            let (length, replacement) = match change_at(&bytes[at..]) {
                Some(change) => change,
                None => {
                    at += 1;
                    continue;
                }
            };
            // Changes begin and end at ASCII bytes, hence at character boundaries.
            text.push_str(original.get(copied..at).unwrap_or_default());
            text.push_str(replacement);
            at += length;
            copied = at;
            shifts.push((offset(text.len()), offset(at)));
        }
        if shifts.is_empty() {
            return Self { text: Arc::clone(original), shifts: Arc::new([]) };
        }
        text.push_str(original.get(copied..).unwrap_or_default());
        Self { text: text.into(), shifts: shifts.into() }
    }

    /// Maps an offset in the logical text to one in the file.
    pub(crate) fn original(&self, at: u32) -> u32 {
        let before = self.shifts.partition_point(|(here, _)| *here <= at);
        match before.checked_sub(1).and_then(|last| self.shifts.get(last)) {
            Some((here, there)) => there + (at - here),
            None => at,
        }
    }
}

/// The replacement due at the beginning of `rest`: length of the original, and new text.
fn change_at(rest: &[u8]) -> Option<(usize, &'static str)> {
    match rest {
        [b'\\', b'\n', ..] => Some((2, "")),
        [b'\\', b'\r', b'\n', ..] => Some((3, "")),
        // A backslash written as a trigraph may itself join lines.
        [b'?', b'?', b'/', b'\n', ..] => Some((4, "")),
        [b'?', b'?', b'/', b'\r', b'\n', ..] => Some((5, "")),
        [b'?', b'?', third, ..] => trigraph(*third).map(|replacement| (3, replacement)),
        _ => None,
    }
}

fn trigraph(third: u8) -> Option<&'static str> {
    Some(match third {
        b'=' => "#",
        b'(' => "[",
        b'/' => "\\",
        b')' => "]",
        b'\'' => "^",
        b'<' => "{",
        b'!' => "|",
        b'>' => "}",
        b'-' => "~",
        _ => return None,
    })
}

fn offset(at: usize) -> u32 {
    u32::try_from(at).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_that_are_not_utf8_come_back_unchanged() {
        let bytes = b"\xe9t\xe9 \x80\xff".to_vec();
        let (text, encoding) = decode(bytes.clone());
        assert_eq!(encoding, Encoding::Latin1);
        assert_eq!(&*text, "\u{e9}t\u{e9} \u{80}\u{ff}");
        assert_eq!(encoding.encode(&text), bytes);
    }

    #[test]
    fn joined_lines_and_trigraphs_keep_the_way_back() {
        let original: Arc<str> = "a\\\nb??=c??/\nd???(".into();
        let logical = Logical::new(&original);
        assert_eq!(&*logical.text, "ab#cd?[");
        let back = |text: &str| {
            let at = offset(logical.text.find(text).unwrap());
            logical.original(at) as usize
        };
        assert_eq!(back("a"), 0);
        assert_eq!(back("b"), 3);
        assert_eq!(back("c"), 7);
        assert_eq!(back("d"), 12);
    }

    #[test]
    fn plain_text_is_shared_not_copied() {
        let original: Arc<str> = "component c;".into();
        assert!(Arc::ptr_eq(&Logical::new(&original).text, &original));
    }
}
