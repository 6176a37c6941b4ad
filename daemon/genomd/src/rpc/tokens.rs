//! The token file: who may come in by other doors than the Unix socket, and what for.

use std::fmt;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use subtle::{Choice, ConstantTimeEq as _};

use crate::config::Right;
use crate::rpc::holder::Holder;

/// A shorter token could be guessed.
const SHORTEST: usize = 32;

/// The tokens a daemon knows.
#[derive(Debug, Default)]
pub(crate) struct Tokens(Vec<Token>);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TokenFile {
    #[serde(default)]
    token: Vec<Token>,
}

/// One token; shown and logged by its name only.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Token {
    /// Whose it is.
    name: String,
    token: String,
    rights: Vec<Right>,
}

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {:?}", self.name, self.rights)
    }
}

/// A token file cannot be used.
#[derive(Debug, thiserror::Error)]
pub(crate) enum TokenError {
    /// Missing or unreadable.
    #[error(
        "the token file {} cannot be read: {source}; `genomctl token NAME --into {}` begins one",
        path.display(), path.display()
    )]
    Read { path: PathBuf, source: std::io::Error },
    /// Others could read the tokens.
    #[error("others may read the token file {0}: `chmod 600 {0}`")]
    Open(String),
    /// A mistake in it. The text itself is never shown.
    #[error("{}:{line}: {message}", path.display())]
    Mistake { path: PathBuf, line: usize, message: String },
}

impl Tokens {
    /// Reads a file of tokens, which nobody else may read.
    pub(crate) fn read(path: &Path) -> Result<Self, TokenError> {
        let unreadable = |source| TokenError::Read { path: path.to_owned(), source };
        let mode = std::fs::metadata(path).map_err(unreadable)?.mode();
        if mode & 0o077 != 0 {
            return Err(TokenError::Open(path.display().to_string()));
        }
        Self::parse(path, &std::fs::read_to_string(path).map_err(unreadable)?)
    }

    fn parse(path: &Path, text: &str) -> Result<Self, TokenError> {
        let mistake = |line, message| TokenError::Mistake { path: path.to_owned(), line, message };
        let file: TokenFile = toml::from_str(text).map_err(|error| {
            let start = error.span().map_or(0, |span| span.start).min(text.len());
            let line = text.as_bytes()[..start].iter().filter(|byte| **byte == b'\n').count() + 1;
            mistake(line, error.message().trim().replace('\n', ", "))
        })?;
        for token in &file.token {
            if token.token.len() < SHORTEST {
                let line = text.lines().position(|line| line.contains(&token.token)).unwrap_or(0);
                let name = &token.name;
                let message = format!(
                    "the token of {name} is shorter than {SHORTEST} characters; `genomctl token \
                     {name}` makes one"
                );
                return Err(mistake(line + 1, message));
            }
        }
        Ok(Self(file.token))
    }

    /// Whose token it is. Takes the same time whichever it is, and if it is none.
    pub(crate) fn holder(&self, given: &[u8]) -> Option<Holder> {
        let mut found = None;
        for known in &self.0 {
            let same: Choice = known.token.as_bytes().ct_eq(given);
            if bool::from(same) {
                found = Some(known);
            }
        }
        let token = found?;
        Some(Holder { who: format!("token {}", token.name), rights: token.rights.clone() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "[[token]]\nname = \"dashboard\"\n\
        token = \"0123456789abcdef0123456789abcdef\"\nrights = [\"read\"]\n";

    #[test]
    fn a_token_tells_its_holder_and_is_never_shown() {
        let tokens = Tokens::parse(Path::new("tokens"), FILE).unwrap();
        let holder = tokens.holder(b"0123456789abcdef0123456789abcdef").unwrap();
        assert_eq!(
            (holder.who.as_str(), &holder.rights[..]),
            ("token dashboard", &[Right::Read][..])
        );
        for wrong in [&b""[..], b"0123456789abcdef", b"0123456789abcdef0123456789abcdeX"] {
            assert!(tokens.holder(wrong).is_none());
        }
        assert!(!format!("{tokens:?}").contains("0123456789"));
    }

    #[test]
    fn a_mistake_names_the_line_and_no_secret() {
        let told = |text: &str| Tokens::parse(Path::new("t"), text).unwrap_err().to_string();
        let short = told(&FILE.replace("0123456789abcdef0123456789abcdef", "short-secret"));
        assert!(short.starts_with("t:3: the token of dashboard is shorter"), "{short}");
        assert!(!short.contains("short-secret"));
        let right = told(&FILE.replace("read", "raed"));
        assert!(right.starts_with("t:4: unknown variant `raed`, expected one of"), "{right}");
    }
}
