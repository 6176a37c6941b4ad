//! Languages whose codels are scripts, by the extension of their files. What comes with genomd is
//! [`KNOWN`]; a process adds those of its configuration before it looks at any file.

use std::path::Path;
use std::sync::OnceLock;

/// `lang` in a description, and the extension of the files.
pub const KNOWN: [(&str, &str); 2] = [("python", "py"), ("lua", "lua")];

static ADDED: OnceLock<Vec<(String, String)>> = OnceLock::new();

/// Adds languages, as in [`KNOWN`]; only the first call counts.
pub fn add(languages: Vec<(String, String)>) {
    let _ = ADDED.set(languages);
}

/// All that are known, as in [`KNOWN`].
pub fn all() -> impl Iterator<Item = (&'static str, &'static str)> {
    let added = ADDED.get().map(Vec::as_slice).unwrap_or_default();
    let added = added.iter().map(|(name, extension)| (name.as_str(), extension.as_str()));
    KNOWN.into_iter().chain(added)
}

/// The language of the script in this file, by its name; `None` for other files.
#[must_use]
pub fn of(path: &Path) -> Option<&'static str> {
    let extension = path.extension()?;
    all().find(|(_, known)| extension == *known).map(|(name, _)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_tells_the_language() {
        let of = |name| of(Path::new(name));
        assert_eq!(of("a/demo.py"), Some("python"));
        assert_eq!(of("demo.lua"), Some("lua"));
        assert_eq!([of("demo.so"), of("demo"), of("lua"), of("demo.lua.so")], [None; 4]);
    }
}
