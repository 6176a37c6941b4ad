//! Reads what a dying process wrote (`genom_host::note_crashes_in`). It may be cut anywhere, and
//! may hold anything: the process was in an unknown state.

use genom_protocol::CrashFault;

/// Most bytes of a note that are read.
pub(super) const MOST: u64 = 1 << 20;
/// Most frames of it.
const FRAMES: usize = 64;
/// Most mappings of it.
const MAPPINGS: usize = 4096;

/// A note.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Note {
    /// All but the frames, and whether it is complete.
    pub(super) fault: CrashFault,
    /// Where the signal hit; `None` for an end by a function.
    pub(super) pc: Option<u64>,
    /// Return addresses, innermost first.
    pub(super) callers: Vec<u64>,
    /// Words of the stack.
    pub(super) guesses: Vec<u64>,
    pub(super) mappings: Vec<Mapping>,
}

/// Code of a file in the memory of the process.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Mapping {
    pub(super) start: u64,
    pub(super) end: u64,
    /// Of its first byte in the file.
    pub(super) offset: u64,
    pub(super) path: String,
}

/// Reads a note; `None` where the process wrote none.
pub(super) fn read(bytes: &[u8]) -> Option<Note> {
    let text = String::from_utf8_lossy(bytes);
    let mut note = Note::default();
    let mut ended = false;
    for line in text.lines() {
        let (key, value) = line.split_once(' ').unwrap_or((line, ""));
        let owned = || Some(value.to_owned());
        let fault = &mut note.fault;
        match key {
            "what" => value.clone_into(&mut fault.what),
            "signal" => {
                let mut numbers = value.split(' ').map(|number| number.parse().ok());
                fault.signal = numbers.next().flatten();
                fault.signal_code = numbers.next().flatten();
            }
            "address" => fault.address = number(value).map(|address| format!("{address:#x}")),
            "pc" => note.pc = number(value),
            "thread" => value.clone_into(&mut fault.thread),
            "words" => fault.words = owned(),
            "component" => fault.component = owned(),
            "owner" => fault.owner = owned(),
            "activity" => fault.activity = value.parse().ok(),
            "inputs" => {
                let text = || value.to_owned().into();
                fault.inputs = Some(serde_json::from_str(value).unwrap_or_else(|_| text()));
            }
            "map" if note.mappings.len() < MAPPINGS => note.mappings.extend(mapping(value)),
            "caller" if note.callers.len() < FRAMES => note.callers.extend(number(value)),
            "guess" => note.guesses.extend(number(value)),
            "end" => ended = true,
            _ => {}
        }
    }
    // An address is known of errors of memory and arithmetic only.
    if note.fault.signal_code.is_none_or(|code| code <= 0) {
        note.fault.address = None;
    }
    note.fault.cut = !ended;
    let mappings = &note.mappings;
    note.guesses.retain(|word| mappings.iter().any(|one| one.holds(*word)));
    note.guesses.truncate(FRAMES);
    (!note.fault.what.is_empty()).then_some(note)
}

/// A line of `/proc/PID/maps`, of a file.
fn mapping(line: &str) -> Option<Mapping> {
    let mut words = line.splitn(6, ' ');
    let (start, end) = words.next()?.split_once('-')?;
    let offset = words.nth(1)?;
    let path = words.nth(2)?.trim_start();
    let hex = |text| u64::from_str_radix(text, 16).ok();
    let (start, end, offset) = (hex(start)?, hex(end)?, hex(offset)?);
    path.starts_with('/').then(|| Mapping { start, end, offset, path: path.to_owned() })
}

fn number(text: &str) -> Option<u64> {
    u64::from_str_radix(text.trim().strip_prefix("0x")?, 16).ok()
}

impl Mapping {
    pub(super) fn holds(&self, address: u64) -> bool {
        (self.start..self.end).contains(&address)
    }

    /// Where an address of the process is in the file.
    pub(super) fn in_file(&self, address: u64) -> u64 {
        address.wrapping_sub(self.start).wrapping_add(self.offset)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    const NOTE: &str = "what SIGSEGV\nsignal 11 1\naddress 0x0\npc 0x7f001010\nthread 42 main\n\
        words codel `go` of /opt/a b.so\ncomponent arm\nowner service go\ninputs {\"by\":3}\n\
        activity 7\nmap 7f001000-7f002000 r-xp 00001000 08:01 77    /tmp/x/0-a b.so\n\
        map 7f003000-7f004000 r-xp 00000000 00:00 0\ncaller 0x7f001020\nguess 0x7f001030\n\
        guess 0x10\nend\n";

    #[test]
    fn a_note_says_what_ran_and_where() {
        let note = read(NOTE.as_bytes()).unwrap();
        assert_eq!((note.pc, &*note.callers), (Some(0x7f00_1010), &[0x7f00_1020][..]));
        assert_eq!(note.guesses, [0x7f00_1030], "of code only");
        assert_eq!(note.mappings.len(), 1);
        assert_eq!(note.mappings[0].path, "/tmp/x/0-a b.so");
        assert_eq!(note.mappings[0].in_file(0x7f00_1010), 0x1010);
        let fault = note.fault;
        assert_eq!((fault.signal, fault.activity, fault.cut), (Some(11), Some(7), false));
        assert_eq!(fault.inputs, Some(json!({"by": 3})));
        assert_eq!(fault.address.as_deref(), Some("0x0"));
    }

    #[test]
    fn a_note_that_is_cut_or_garbage_is_read_as_far_as_it_goes() {
        assert_eq!(read(b""), None);
        assert_eq!(read(&[0xff, 0, b'\n', 7]), None);
        for length in 0..NOTE.len() {
            if let Some(note) = read(&NOTE.as_bytes()[..length]) {
                assert!(note.fault.cut || length == NOTE.len() - 1, "{length}");
            }
        }
        let many = format!("what x\n{}", "caller 0x1\n".repeat(10_000));
        assert_eq!(read(many.as_bytes()).unwrap().callers.len(), FRAMES);
        assert_eq!(mapping("7f-zz r-xp 0 0 0 /x"), None);
    }
}
