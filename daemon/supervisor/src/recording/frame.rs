//! What a recording sends: frames in a row, each `length: u32, kind: u8, content`, little endian.
//!
//! `genomctl record` has the same rule.

use serde_json::Value;

/// `{"recording", "genomd", "clock", "deployment"}`
pub(super) const START: u8 = 0;
/// `{"channel", "topic", "encoding", "schema", "definition", "metadata"}`
pub(super) const CHANNEL: u8 = 1;
/// `channel: u16, number: u32, date: u64, message`
pub(super) const SAMPLE: u8 = 2;
/// `{"channel", "lost"}`: how many so far
pub(super) const LOST: u8 = 3;
/// `{"why"}`; the last frame
pub(super) const END: u8 = 4;

/// Appends a frame that tells something.
pub(super) fn told(out: &mut Vec<u8>, kind: u8, content: &Value) {
    let text = content.to_string();
    frame(out, kind, &[text.as_bytes()]);
}

/// Appends a sample or a note.
pub(super) fn sample(out: &mut Vec<u8>, channel: u16, number: u32, date: u64, message: &[u8]) {
    let parts = [&channel.to_le_bytes()[..], &number.to_le_bytes(), &date.to_le_bytes(), message];
    frame(out, SAMPLE, &parts);
}

fn frame(out: &mut Vec<u8>, kind: u8, parts: &[&[u8]]) {
    let length: usize = 1 + parts.iter().map(|part| part.len()).sum::<usize>();
    out.extend_from_slice(&u32::try_from(length).unwrap_or(u32::MAX).to_le_bytes());
    out.push(kind);
    for part in parts {
        out.extend_from_slice(part);
    }
}
