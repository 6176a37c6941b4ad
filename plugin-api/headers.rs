//! The headers under `include/`, within the program: a genomd that was installed as a binary alone
//! can write them where a compiler finds them.

#![forbid(unsafe_code)]

/// A header: its path below the include directory, and its text.
pub type Header = (&'static str, &'static str);

macro_rules! headers {
    ($($path:literal)*) => {
        /// All headers.
        pub const HEADERS: &[Header] = &[$(($path, include_str!(concat!("include/", $path)))),*];
    };
}

headers! {
    "genom/describe.h"
    "genom/reload.h"
    "genom3/c/context.h"
    "genom3/c/event.h"
    "genom3/c/exception.h"
    "genom3/c/idlsequence.h"
    "genom3/c++/event.h"
    "genom3/c++/exception.h"
    "genom3/c++/idloptional.h"
    "genom3/c++/idlsequence.h"
    "genom3/middleware.h"
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn files(directory: &Path, found: &mut Vec<String>, root: &Path) {
        for entry in std::fs::read_dir(directory).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                files(&path, found, root);
            } else {
                found.push(path.strip_prefix(root).unwrap().display().to_string());
            }
        }
    }

    #[test]
    fn every_header_is_in_the_program() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("include");
        let mut found = Vec::new();
        files(&root, &mut found, &root);
        let mut held: Vec<String> = HEADERS.iter().map(|(path, _)| (*path).to_owned()).collect();
        found.sort();
        held.sort();
        assert_eq!(held, found);
    }
}
