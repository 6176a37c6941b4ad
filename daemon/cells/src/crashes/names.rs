//! Names of functions as their authors wrote them: C++ and Rust compilers put types and modules
//! into the names of symbols.

use std::fmt::{self, Write};

use cpp_demangle::{DemangleOptions, Symbol};

/// Longest name that is told, in bytes: templates may have names without end.
const LONGEST: usize = 400;

/// A symbol in words; as it is, if it is of no language that changes names.
pub(super) fn plain(symbol: &str) -> String {
    let mut told = Bounded(String::new());
    // A name that is too long is cut, which is no failure.
    if let Ok(rust) = rustc_demangle::try_demangle(symbol) {
        // Without the digest at its end.
        let _ = write!(told, "{rust:#}");
        return told.0;
    }
    let options = DemangleOptions::default().recursion_limit(64);
    if let Ok(cpp) = Symbol::new(symbol.as_bytes()) {
        let _ = cpp.structured_demangle(&mut told, &options);
    }
    if told.0.is_empty() { symbol.to_owned() } else { told.0 }
}

/// Takes as much as fits.
struct Bounded(String);

impl Write for Bounded {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let room = LONGEST.saturating_sub(self.0.len());
        if text.len() <= room {
            self.0.push_str(text);
            return Ok(());
        }
        let fits = (0..=room).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
        self.0.push_str(&text[..fits]);
        self.0.push_str("...");
        Err(fmt::Error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_cpp_and_rust_are_told_as_they_were_written() {
        for (symbol, wanted) in [
            ("crashes_segfault", "crashes_segfault"),
            ("_ZN4demo4Axis4moveEdRKNS_5LimitE", "demo::Axis::move(double, demo::Limit const&)"),
            ("_ZN4demo4move17h0123456789abcdefE", "demo::move"),
            ("_RNvC4demo4move", "demo::move"),
            ("_Z", "_Z"),
            ("_ZN", "_ZN"),
            ("", ""),
        ] {
            assert_eq!(plain(symbol), wanted, "{symbol}");
        }
    }

    #[test]
    fn a_name_without_end_is_cut() {
        let long = format!("_Z1fI{}Ev", "1a".repeat(100_000));
        assert!(plain(&long).len() <= LONGEST + 3 || plain(&long) == long);
        // Each substitution doubles what it stands for.
        let bomb = format!("_Z1fI1aS_{}Ev", "IS_S0_EIS1_S2_E".repeat(2_000));
        assert!(plain(&bomb).len() <= bomb.len().max(LONGEST + 3));
        let nested = format!("_Z1f{}i", "P".repeat(200_000));
        assert!(plain(&nested).len() <= nested.len());
    }
}
