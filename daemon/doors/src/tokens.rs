//! The token file: clients that do not use the Unix socket, and their rights.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, PoisonError, RwLock};

use genom_proof::{Bytes, HINT, NONCE};
use genom_protocol::{Right, TokenEntry, TokenFile};
use serde::{Deserialize, Serialize};
use subtle::{Choice, ConstantTimeEq as _};

use crate::holder::Holder;
use crate::private;

/// Minimum length of a token, in characters; a shorter one could be guessed.
const SHORTEST: usize = 32;

/// In place of the nonce of a client: marks are compared over restarts.
const MARKING: &[u8; NONCE] = b"what a session was opened with  ";

/// What distinguishes a token from others, also after a restart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct Mark(Bytes<HINT>);

/// The known tokens; their file can be read again while they are in use.
#[derive(Debug, Default)]
pub struct Tokens {
    path: Option<PathBuf>,
    known: RwLock<Vec<Entry>>,
    /// Number of times the file was read again.
    generation: AtomicU64,
}

/// A token, and the keys derived from it.
#[derive(Debug)]
struct Entry {
    token: TokenEntry,
    key: genom_proof::Token,
}

/// A token whose possession was proved.
#[derive(Debug)]
pub(crate) struct Known {
    pub(crate) key: genom_proof::Token,
    pub(crate) holder: Holder,
}

/// Why a token file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TokenError {
    /// The file is missing or cannot be read.
    #[error(
        "the token file {} cannot be read: {source}; `genomctl token NAME --into {}` begins one",
        path.display(), path.display()
    )]
    Read {
        /// Path of the file.
        path: PathBuf,
        /// The error of the system.
        source: std::io::Error,
    },
    /// Others can read the file.
    #[error(transparent)]
    Open(#[from] private::NotPrivate),
    /// The daemon was started without a token file.
    #[error("this daemon has no token file: start it with `--token-file FILE`")]
    None,
    /// A mistake in the file, whose text is never shown.
    #[error("{}:{line}: {message}", path.display())]
    Mistake {
        /// Path of the file.
        path: PathBuf,
        /// Line of the mistake, from 1.
        line: usize,
        /// What is wrong.
        message: String,
    },
}

impl Tokens {
    /// Whether there is a file to read again.
    pub fn has_file(&self) -> bool {
        self.path.is_some()
    }

    /// Reads a token file, which nobody else may read; without a path there are no tokens.
    ///
    /// # Errors
    /// The file is missing, can be read by others, or has a mistake.
    pub fn read(path: Option<&Path>) -> Result<Arc<Self>, TokenError> {
        let known = path.map(entries).transpose()?.unwrap_or_default();
        let path = path.map(Path::to_owned);
        Ok(Arc::new(Self { path, known: RwLock::new(known), generation: AtomicU64::new(0) }))
    }

    /// Reads the file again; returns the number of tokens. If it has a mistake, nothing changes.
    ///
    /// # Errors
    /// As for [`Tokens::read`], or there is no file.
    pub fn read_again(&self) -> Result<usize, TokenError> {
        let read = entries(self.path.as_deref().ok_or(TokenError::None)?)?;
        let count = read.len();
        tracing::info!("read the token file again: {count} tokens");
        *self.known.write().unwrap_or_else(PoisonError::into_inner) = read;
        self.generation.fetch_add(1, Ordering::Release);
        Ok(count)
    }

    /// Number of times the file was read again.
    pub(crate) fn generation(&self) -> u64 {
        self.generation.load(Ordering::Acquire)
    }

    /// The holder of a token. Takes the same time for every token, known or not.
    #[must_use]
    pub fn holder(&self, given: &[u8]) -> Option<Holder> {
        let known = self.known.read().unwrap_or_else(PoisonError::into_inner);
        let mut found = None;
        for entry in &*known {
            let same: Choice = entry.token.token.as_bytes().ct_eq(given);
            if bool::from(same) {
                found = Some(entry);
            }
        }
        found.map(|entry| holder(&entry.token))
    }

    /// What distinguishes the token of this holder from any other of the same name. The token cannot
    /// be computed from it. `None` if the holder has no token of the file.
    #[must_use]
    pub fn mark(&self, of: &Holder) -> Option<Mark> {
        let known = self.known.read().unwrap_or_else(PoisonError::into_inner);
        let entry = known.iter().find(|entry| holder(&entry.token).who == of.who)?;
        Some(Mark(entry.key.hint(MARKING)))
    }

    /// The rights that the token with this mark has now; `None` if it is not in the file any more.
    #[must_use]
    pub fn rights(&self, mark: &Mark) -> Option<Vec<Right>> {
        let known = self.known.read().unwrap_or_else(PoisonError::into_inner);
        let entry = known.iter().find(|entry| entry.key.hint(MARKING) == mark.0)?;
        Some(entry.token.rights.clone())
    }

    /// The token with this hint.
    pub(crate) fn hinted(&self, nonce: &[u8; NONCE], hint: &Bytes<HINT>) -> Option<Known> {
        self.find(|key| key.hint(nonce) == *hint)
    }

    /// The token with this key, if it is still known.
    pub(crate) fn same(&self, key: &genom_proof::Token) -> Option<Known> {
        let nonce = [0; NONCE];
        let hint = key.hint(&nonce);
        self.find(|known| known.hint(&nonce) == hint)
    }

    fn find(&self, wanted: impl Fn(&genom_proof::Token) -> bool) -> Option<Known> {
        let known = self.known.read().unwrap_or_else(PoisonError::into_inner);
        let entry = known.iter().find(|entry| wanted(&entry.key))?;
        Some(Known { key: entry.key.clone(), holder: holder(&entry.token) })
    }

    /// A single token, for tests.
    #[cfg(test)]
    pub(crate) fn of(name: &str, text: &str) -> Arc<Self> {
        let text =
            format!("[[token]]\nname = \"{name}\"\ntoken = \"{text}\"\nrights = [\"read\"]\n");
        let known = RwLock::new(parse(Path::new("tokens"), &text).unwrap());
        Arc::new(Self { known, ..Self::default() })
    }
}

fn holder(of: &TokenEntry) -> Holder {
    Holder::of(format!("token {}", of.name), of.rights.clone())
}

fn entries(path: &Path) -> Result<Vec<Entry>, TokenError> {
    let text = private::read(path).map_err(|error| match error {
        private::PrivateError::Read(source) => TokenError::Read { path: path.to_owned(), source },
        private::PrivateError::Open(open) => TokenError::Open(open),
    })?;
    parse(path, &text)
}

fn parse(path: &Path, text: &str) -> Result<Vec<Entry>, TokenError> {
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
    let entry = |token: TokenEntry| Entry { key: genom_proof::Token::new(&token.token), token };
    Ok(file.token.into_iter().map(entry).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "[[token]]\nname = \"dashboard\"\n\
        token = \"0123456789abcdef0123456789abcdef\"\nrights = [\"read\"]\n";

    #[test]
    fn a_token_tells_its_holder_and_is_never_shown() {
        let tokens = Tokens::of("dashboard", "0123456789abcdef0123456789abcdef");
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
    fn a_mark_is_that_of_one_token_and_is_forgotten_with_it() {
        let tokens = Tokens::of("dashboard", "0123456789abcdef0123456789abcdef");
        let holder = tokens.holder(b"0123456789abcdef0123456789abcdef").unwrap();
        let mark = tokens.mark(&holder).unwrap();
        assert_eq!(tokens.rights(&mark), Some(vec![Right::Read]));
        let other = Tokens::of("dashboard", "another one, 0123456789abcdef012");
        assert_eq!(other.rights(&mark), None, "a token of the same name is another one");
        assert_eq!(tokens.mark(&Holder::own()), None);
    }

    #[test]
    fn a_mistake_names_the_line_and_no_secret() {
        let told = |text: &str| parse(Path::new("t"), text).unwrap_err().to_string();
        let short = told(&FILE.replace("0123456789abcdef0123456789abcdef", "short-secret"));
        assert!(short.starts_with("t:3: the token of dashboard is shorter"), "{short}");
        assert!(!short.contains("short-secret"));
        let right = told(&FILE.replace("read", "raed"));
        assert!(right.starts_with("t:4: unknown variant `raed`, expected one of"), "{right}");
    }
}
