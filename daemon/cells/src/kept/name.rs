//! Names of recordings: each is a file of the directory, and nothing else.

use super::base::ENDING;
use super::error::KeptError;

/// Characters of a name without its ending, at most.
const LONGEST: usize = 64;

/// The file of this name, with its ending or without.
pub(super) fn file(name: &str) -> Result<String, KeptError> {
    let stem = name.strip_suffix(ENDING).unwrap_or(name);
    let other = |sign: char| !(sign.is_ascii_alphanumeric() || "._-".contains(sign));
    let begins_well = stem.starts_with(|sign: char| sign.is_ascii_alphanumeric());
    if !begins_well || stem.len() > LONGEST || stem.contains(other) {
        return Err(KeptError::Name(shown(name)));
    }
    Ok(format!("{stem}{ENDING}"))
}

/// Fails if no such file can have this name.
pub(super) fn check(name: &str) -> Result<(), KeptError> {
    if file(name).is_ok_and(|file| file == name) {
        return Ok(());
    }
    Err(KeptError::Unknown(shown(name), Vec::new()))
}

/// A name for messages: its beginning, without what would not be seen.
fn shown(name: &str) -> String {
    let begin: String = name.chars().take(LONGEST + 1).collect();
    begin.escape_debug().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_that_of_a_file_in_the_directory_or_none() {
        assert_eq!(file("drive-3_a.b").unwrap(), "drive-3_a.b.mcap");
        assert_eq!(file("drive.mcap").unwrap(), "drive.mcap");
        let long = "a".repeat(65);
        for wrong in [
            "",
            ".",
            "..",
            "../x",
            "a/b",
            "/etc/passwd",
            ".hidden",
            "-rf",
            ".mcap",
            "a\0b",
            "a b",
            "a\nb",
            "ä",
            "a\u{202e}b",
            "..%2fx",
            "a\\b",
            &long,
        ] {
            assert!(matches!(file(wrong), Err(KeptError::Name(_))), "{wrong:?}");
        }
        assert!(check("drive.mcap").is_ok());
        for none in ["drive", "../drive.mcap", "a b.mcap"] {
            assert!(matches!(check(none), Err(KeptError::Unknown(..))), "{none}");
        }
    }

    #[test]
    fn a_name_is_told_short_and_without_what_is_not_seen() {
        let told = file(&format!("\n{}", "x".repeat(100_000))).unwrap_err().to_string();
        assert!(told.len() < 300 && !told.contains('\n'), "{told}");
    }
}
