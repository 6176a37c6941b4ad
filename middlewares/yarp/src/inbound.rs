//! What a peer sends that dialled us: bytes to events. They are not trusted, and nothing is kept
//! that has not arrived.

use std::ops::Range;

use crate::wire::{self, Carrier, Purpose};

/// Greatest length of a peer's name and of a line of text.
const MOST_NAME: usize = 512;
const MOST_LINE: usize = 1 << 18;

/// Something that a peer said. Ranges are of [`Inbound::bytes`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Event {
    /// Its name; the first event.
    Hello { name: String, carrier: Carrier },
    /// A bottle, in text on a text carrier.
    Bottle { purpose: Purpose, body: Range<usize> },
    /// Administration as a word, such as `/dest`.
    Command(String),
}

/// The peer does not speak YARP, or asks for too much.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Abuse {
    #[error("begins with {0:?}, which is no carrier this side accepts (tcp, fast_tcp, text)")]
    Carrier(String),
    #[error("has a name of {0} bytes; at most {MOST_NAME} are accepted")]
    Name(i64),
    #[error("has a name that is no text")]
    NameText,
    #[error("sends {0:?} where a message begins")]
    Message(String),
    #[error("announces a message of {size} bytes; at most {most} are accepted here")]
    Size { size: u64, most: usize },
    #[error("sends a message without its header")]
    Header,
    #[error("sends a line of more than {MOST_LINE} bytes")]
    Line,
}

#[derive(Clone, Copy, Debug)]
enum Stage {
    Magic,
    Name(Carrier),
    Message,
    /// The lengths of this many blocks.
    Lengths(usize),
    Body(usize),
    Line(Carrier),
    /// The line that follows a `d` or an `a`.
    TextBottle(Purpose),
}

/// Bytes that arrived, and how far they are understood.
#[derive(Debug)]
pub(crate) struct Inbound {
    buffer: Vec<u8>,
    /// Where that begins which was not understood yet.
    at: usize,
    stage: Stage,
    carrier: Carrier,
    /// Greatest size of a message.
    most: usize,
}

fn shown(bytes: &[u8]) -> String {
    bytes.escape_ascii().to_string()
}

impl Inbound {
    pub(crate) fn new(most: usize) -> Self {
        Self { buffer: Vec::new(), at: 0, stage: Stage::Magic, carrier: Carrier::Tcp, most }
    }

    /// Takes what arrived.
    pub(crate) fn push(&mut self, bytes: &[u8]) {
        if self.at > 0 {
            self.buffer.drain(..self.at);
            self.at = 0;
        }
        self.buffer.extend_from_slice(bytes);
    }

    /// Bytes that are held.
    pub(crate) fn held(&self) -> usize {
        self.buffer.capacity()
    }

    /// Whether the peer owes the rest of something that it has begun.
    pub(crate) fn is_amid(&self) -> bool {
        let between = matches!(self.stage, Stage::Message | Stage::Line(_));
        !between || self.at < self.buffer.len()
    }

    pub(crate) fn bytes(&self, range: Range<usize>) -> &[u8] {
        self.buffer.get(range).unwrap_or_default()
    }

    fn peek(&self, bytes: usize) -> Option<&[u8]> {
        self.buffer.get(self.at..self.at.checked_add(bytes)?)
    }

    fn eight(&self) -> Option<[u8; 8]> {
        self.peek(8)?.try_into().ok()
    }

    /// The next event, if it has arrived.
    pub(crate) fn next(&mut self) -> Result<Option<Event>, Abuse> {
        loop {
            match self.stage {
                Stage::Magic => {
                    let Some(head) = self.eight() else { return Ok(None) };
                    let carrier =
                        Carrier::begun(head).ok_or_else(|| Abuse::Carrier(shown(&head)))?;
                    self.at += 8;
                    self.carrier = carrier;
                    self.stage = Stage::Name(carrier);
                }
                Stage::Name(carrier) => {
                    let Some(name) = self.name(carrier)? else { return Ok(None) };
                    let next =
                        if carrier.is_text() { Stage::Line(carrier) } else { Stage::Message };
                    self.stage = next;
                    return Ok(Some(Event::Hello { name, carrier }));
                }
                Stage::Message => {
                    let Some(head) = self.eight() else { return Ok(None) };
                    // The acknowledgement of a reply that we sent.
                    if head == wire::ACK {
                        self.at += 8;
                        continue;
                    }
                    if !wire::is_message(head) {
                        return Err(Abuse::Message(shown(&head)));
                    }
                    let Some(index) = self.peek(18) else { return Ok(None) };
                    let counts = index.get(8..10).unwrap_or_default();
                    let blocks = counts.iter().map(|count| usize::from(*count)).sum();
                    self.at += 18;
                    self.stage = Stage::Lengths(blocks);
                }
                Stage::Lengths(blocks) => {
                    let Some(lengths) = self.peek(4 * blocks) else { return Ok(None) };
                    let words = lengths.chunks_exact(4).filter_map(|word| word.try_into().ok());
                    let size = words.map(|word| u64::from(u32::from_le_bytes(word))).sum();
                    if size > self.most as u64 {
                        return Err(Abuse::Size { size, most: self.most });
                    }
                    self.at += 4 * blocks;
                    self.stage = Stage::Body(size as usize);
                }
                Stage::Body(size) => {
                    let Some(body) = self.peek(size) else { return Ok(None) };
                    let (event, skip) = message(body)?;
                    let (start, end) = (self.at + skip, self.at + size);
                    self.at = end;
                    self.stage = Stage::Message;
                    return Ok(Some(match event {
                        Ok(purpose) => Event::Bottle { purpose, body: start..end },
                        Err(command) => Event::Command(command),
                    }));
                }
                Stage::Line(carrier) => {
                    let Some(line) = self.line()? else { return Ok(None) };
                    let word = String::from_utf8_lossy(self.bytes(line)).trim().to_owned();
                    match purpose(&word) {
                        Some(purpose) => self.stage = Stage::TextBottle(purpose),
                        None if word.is_empty() => self.stage = Stage::Line(carrier),
                        None => return Ok(Some(Event::Command(word))),
                    }
                }
                Stage::TextBottle(purpose) => {
                    let Some(body) = self.line()? else { return Ok(None) };
                    self.stage = Stage::Line(self.carrier);
                    return Ok(Some(Event::Bottle { purpose, body }));
                }
            }
        }
    }

    fn name(&mut self, carrier: Carrier) -> Result<Option<String>, Abuse> {
        if carrier.is_text() {
            let Some(line) = self.line()? else { return Ok(None) };
            if line.len() > MOST_NAME {
                return Err(Abuse::Name(line.len() as i64));
            }
            return Ok(Some(String::from_utf8_lossy(self.bytes(line)).trim().to_owned()));
        }
        let Some(length) = self.peek(4).and_then(|word| word.try_into().ok()) else {
            return Ok(None);
        };
        let length = i32::from_le_bytes(length);
        let size = usize::try_from(length).ok().filter(|size| (1..=MOST_NAME).contains(size));
        let size = size.ok_or(Abuse::Name(length.into()))?;
        let Some(name) = self.peek(4 + size).and_then(|bytes| bytes.get(4..)) else {
            return Ok(None);
        };
        let name = name.split(|byte| *byte == 0).next().unwrap_or_default();
        let name = std::str::from_utf8(name).map_err(|_| Abuse::NameText)?.to_owned();
        if name.contains(char::is_control) {
            return Err(Abuse::NameText);
        }
        self.at += 4 + size;
        Ok(Some(name))
    }

    /// A line, without its end.
    fn line(&mut self) -> Result<Option<Range<usize>>, Abuse> {
        let rest = self.buffer.get(self.at..).unwrap_or_default();
        let Some(length) = rest.iter().position(|byte| *byte == b'\n') else {
            return if rest.len() > MOST_LINE { Err(Abuse::Line) } else { Ok(None) };
        };
        if length > MOST_LINE {
            return Err(Abuse::Line);
        }
        let start = self.at;
        self.at += length + 1;
        Ok(Some(start..start + length))
    }
}

/// What the first bytes of a message say: its purpose, or a command, and how long they are.
fn message(body: &[u8]) -> Result<(Result<Purpose, String>, usize), Abuse> {
    let head: [u8; 8] = body.get(..8).and_then(|head| head.try_into().ok()).ok_or(Abuse::Header)?;
    let [a, b, c, d, b'~', letter, 0, 1] = head else { return Err(Abuse::Header) };
    let length = u32::from_le_bytes([a, b, c, d]) as usize;
    if length == 0 {
        let word = char::from(letter).to_string();
        return Ok((purpose(&word).ok_or(word), 8));
    }
    let end = length.checked_add(8).ok_or(Abuse::Header)?;
    let text = body.get(8..end).ok_or(Abuse::Header)?;
    let text = text.split(|byte| *byte == 0).next().unwrap_or_default();
    let text = String::from_utf8_lossy(text).into_owned();
    // `D` and an envelope, which is not needed here.
    let word = text.split(' ').next().unwrap_or_default();
    Ok((purpose(word).ok_or(text), end))
}

fn purpose(word: &str) -> Option<Purpose> {
    match word {
        "d" => Some(Purpose::Data { reply: true }),
        "D" => Some(Purpose::Data { reply: false }),
        "a" => Some(Purpose::Administration),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOST: usize = 1000;

    /// What a connection says that sends these bytes, `step` at a time.
    fn said(bytes: &[u8], step: usize) -> Result<Vec<String>, Abuse> {
        let mut inbound = Inbound::new(MOST);
        let mut said = Vec::new();
        for piece in bytes.chunks(step) {
            inbound.push(piece);
            while let Some(event) = inbound.next()? {
                said.push(match event {
                    Event::Hello { name, carrier } => format!("{name} {}", carrier.name()),
                    Event::Bottle { purpose, body } => {
                        format!("{purpose:?} {}", inbound.bytes(body).escape_ascii())
                    }
                    Event::Command(command) => command,
                });
            }
            assert!(inbound.held() <= 2 * bytes.len().max(8));
        }
        Ok(said)
    }

    #[test]
    fn a_conversation_is_understood_however_it_arrives() {
        let mut bytes = wire::greeting(Carrier::Tcp, "/w");
        let mut message = Vec::new();
        wire::begin(Purpose::Data { reply: true }, &mut message);
        message.extend_from_slice(b"body");
        wire::close(&mut message);
        bytes.extend_from_slice(&message);
        bytes.extend_from_slice(&wire::ACK);
        // One block with a command of two bytes, as genuine ports take their leave.
        bytes.extend_from_slice(b"YA\n\0\0\0RP\x01\x01\xff\xff\xff\xff\xff\xff\xff\xff");
        bytes.extend_from_slice(b"\n\0\0\0\0\0\0\0\x02\0\0\0~\0\0\x01q\0");
        // With an envelope.
        bytes.extend_from_slice(b"YA\n\0\0\0RP\x02\x00\xff\xff\xff\xff\xff\xff\xff\xff");
        bytes.extend_from_slice(b"\x0e\0\0\0\x02\0\0\0\x06\0\0\0~\0\0\x01D 5 6\0hi");
        for step in [1, 2, 3, 7, 1000] {
            let said = said(&bytes, step).unwrap();
            let data = "Data { reply: true } body";
            assert_eq!(said, ["/w tcp", data, "q", "Data { reply: false } hi"]);
        }
        let text = b"CONNACK admin\r\na\r\n[list] [out]\r\n*\r\n\r\nd\n1 2\n";
        for step in [1, 5, 100] {
            let said = said(text, step).unwrap();
            let asked = "Administration [list] [out]\\r";
            assert_eq!(said, ["admin text_ack", asked, "*", "Data { reply: true } 1 2"]);
        }
    }

    #[test]
    fn what_is_no_yarp_is_refused_with_what_it_is() {
        let hello = wire::greeting(Carrier::FastTcp, "/w");
        let after = |bytes: &[u8]| said(&[&hello[..], bytes].concat(), 3).unwrap_err();
        let get = said(b"GET / HTTP/1.1\r\n", 4).unwrap_err();
        assert_eq!(get, Abuse::Carrier("GET / HT".to_owned()));
        for length in [0, -1, i32::MIN, i32::MAX, 513] {
            let bytes = [&hello[..8], &length.to_le_bytes()].concat();
            assert_eq!(said(&bytes, 5).unwrap_err(), Abuse::Name(length.into()));
        }
        assert_eq!(after(b"12345678"), Abuse::Message("12345678".to_owned()));
        let index = |blocks: u8, lengths: &[u32]| {
            let mut bytes = wire::frame(10).to_vec();
            bytes.extend_from_slice(&[blocks, 0]);
            bytes.extend_from_slice(&[0xff; 8]);
            bytes.extend(lengths.iter().flat_map(|length| length.to_le_bytes()));
            bytes
        };
        let size = |size| Abuse::Size { size, most: MOST };
        assert_eq!(after(&index(1, &[1 << 31])), size(1 << 31));
        assert_eq!(after(&index(255, &[u32::MAX; 255])), size(255 * u64::from(u32::MAX)));
        assert_eq!(after(&index(0, &[])), Abuse::Header);
        assert_eq!(after(&[&index(1, &[4])[..], b"body"].concat()), Abuse::Header);
        let long = [&b"\xff\xff\xff\x7f~\0\0\x01"[..], b"D"].concat();
        assert_eq!(after(&[&index(1, &[9])[..], &long].concat()), Abuse::Header);
        let line = [&b"CONNECT x\n"[..], &vec![b'x'; MOST_LINE + 2]].concat();
        assert_eq!(said(&line, 1 << 20).unwrap_err(), Abuse::Line);
        let name = [&b"CONNECT "[..], &[b'x'; 600], b"\n"].concat();
        assert_eq!(said(&name, 100).unwrap_err(), Abuse::Name(600));
    }
}
