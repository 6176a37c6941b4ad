//! Options with one dash and several letters, which compilers and GenoM3's templates have.

use std::ffi::OsString;

/// Those options.
const LONG: &[&str] = &["-MD", "-MF", "-MT"];

/// Writes `-MF x`, `-MF=x` and `-MFx` as `--MF x` and `--MF=x`.
pub(crate) fn two_dashes(words: Vec<OsString>) -> Vec<OsString> {
    words.into_iter().map(|word| rewritten(&word).unwrap_or(word)).collect()
}

fn rewritten(word: &OsString) -> Option<OsString> {
    let text = word.to_str()?;
    let option = LONG.iter().find(|option| text.starts_with(**option))?;
    let value = text.strip_prefix(option)?;
    let value = value.strip_prefix('=').unwrap_or(value);
    let equals = if value.is_empty() { "" } else { "=" };
    Some(format!("-{option}{equals}{value}").into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_of_compilers_get_two_dashes() {
        let words = ["-MD", "-MF", ".deps/x.d", "-MT=x.h", "-MFa=b", "-l", "c"];
        let told = two_dashes(words.map(OsString::from).to_vec());
        assert_eq!(told, ["--MD", "--MF", ".deps/x.d", "--MT=x.h", "--MF=a=b", "-l", "c"]);
    }
}
