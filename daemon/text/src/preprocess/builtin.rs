//! Predefined macros, and those of the command line.

use std::cell::Cell;
use std::time::{SystemTime, UNIX_EPOCH};

use super::Preprocessor;
use super::macros::{Macro, Shape};
use super::scanner::Scanner;
use super::state::Open;
use crate::source::Loaded;
use crate::source::Span;

/// The version of GenoM3 that `__GENOM__` claims: newer than every feature that descriptions test
/// for.
pub const GENOM: &str = "2.99.41";

impl Preprocessor<'_> {
    /// Defines the macros of genom3.md 1.2, then those of the command line.
    pub(super) fn predefine(&mut self) {
        let (date, time) = now();
        let built_in = format!(
            "#define __GENOM__ {GENOM}\n#define __STDC__ 1\n#define __STDC_VERSION__ 199901L\n\
             #define __DATE__ \"{date}\"\n#define __TIME__ \"{time}\"\n"
        );
        self.read_synthetic("<built-in>", &built_in);
        for (name, shape) in [("__FILE__", Shape::File), ("__LINE__", Shape::Line)] {
            let (body, span, busy) = (Vec::new(), Span::default(), Cell::new(false));
            self.install(Macro { name: name.into(), shape, body, span, busy });
        }
        // `_Pragma` is no macro, but its uses are found in the same way.
        self.initials[usize::from(b'_')] = true;
        let mut given = String::new();
        for define in &self.options.defines {
            let line = match define.split_once('=') {
                Some((name, value)) => format!("#define {name} {value}\n"),
                None => format!("#define {define} 1\n"),
            };
            given.push_str(&line);
        }
        self.read_synthetic("<command line>", &given);
    }

    /// Reads definitions that do not come from a file.
    pub(super) fn read_synthetic(&mut self, name: &str, text: &str) {
        if text.is_empty() {
            return;
        }
        let rank = self.sources.add_synthetic(name, text);
        let loaded = Loaded::new(text.as_bytes().to_vec());
        let buffer = u32::try_from(self.buffers.len()).unwrap_or(u32::MAX);
        self.buffers.push(loaded.logical.text.clone());
        let scanner = Scanner::new(loaded.logical, rank, buffer);
        let conditionals = Vec::new();
        let open = Open { scanner, identity: name.into(), path: name.into(), conditionals };
        // Within a file (definitions by pkg-config), that file continues afterwards.
        let outer = std::mem::replace(&mut self.open, vec![open]);
        let contexts = std::mem::take(&mut self.contexts);
        let keep_open = std::mem::take(&mut self.keep_open);
        self.drain();
        self.open = outer;
        self.contexts = contexts;
        self.keep_open = keep_open;
    }
}

/// `Mmm dd yyyy` and `hh:mm:ss` in universal time.
fn now() -> (String, String) {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let (day, second) = (seconds / 86_400, seconds % 86_400);
    let (year, month, day) = civil(day);
    const MONTHS: [&str; 12] =
        ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];
    let name = MONTHS.get(month).copied().unwrap_or("Jan");
    let date = format!("{name} {day:2} {year}");
    (date, format!("{:02}:{:02}:{:02}", second / 3600, second / 60 % 60, second % 60))
}

/// Year, month from 0 and day from 1 of a day counted from 1 January 1970.
fn civil(days: u64) -> (u64, usize, u64) {
    let (mut year, mut left) = (1970, days);
    loop {
        let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
        let length = if leap { 366 } else { 365 };
        if left >= length {
            left -= length;
            year += 1;
            continue;
        }
        let february = if leap { 29 } else { 28 };
        let months = [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
        for (month, length) in months.into_iter().enumerate() {
            if left < length {
                return (year, month, left + 1);
            }
            left -= length;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::civil;

    #[test]
    fn days_become_dates() {
        assert_eq!(civil(0), (1970, 0, 1));
        assert_eq!(civil(11_016), (2000, 1, 29));
        assert_eq!(civil(11_017), (2000, 2, 1));
        assert_eq!(civil(19_722), (2023, 11, 31));
    }
}
