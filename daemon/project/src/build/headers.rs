//! Headers that a component's own build would generate: that of its types, under the name by which
//! the codels include it, and the one that autoconf writes.

use std::collections::BTreeSet;
use std::path::Path;

/// The files that sources include with `#include "..."` and that are in none of `directories`.
pub(super) fn missing(texts: &[String], directories: &[&Path]) -> BTreeSet<String> {
    let names = texts.iter().flat_map(|text| text.lines().filter_map(included));
    names
        .filter(|name| !directories.iter().any(|directory| directory.join(name).is_file()))
        .map(str::to_owned)
        .collect()
}

/// The file that a line includes.
fn included(line: &str) -> Option<&str> {
    let line = line.trim_start().strip_prefix('#')?.trim_start().strip_prefix("include")?;
    line.trim_start().strip_prefix('"')?.split('"').next()
}

/// What a missing header is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Missing {
    /// The types and prototypes, in C.
    Types,
    /// The same, in C++.
    CxxTypes,
    /// The results of autoconf: nothing is defined.
    Configuration,
    /// Something else, about which the compiler will complain.
    Other,
}

/// What a missing header of component `name` is. GenoM3's builds call it `demo_c_types.h`, or
/// `acdemo.h`.
pub(super) fn meaning(header: &str, name: &str) -> Missing {
    let file = header.rsplit('/').next().unwrap_or(header);
    match file {
        _ if file == format!("{name}_cxx_types.h") => Missing::CxxTypes,
        _ if file == format!("ac{name}.h") || file == "config.h" => Missing::Configuration,
        _ if file.starts_with(name) && file.ends_with("_types.h") => Missing::Types,
        _ => Missing::Other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_of_the_usual_build_are_recognized_by_their_names() {
        let text = "#include <math.h>\n  # include \"acarm.h\"\n#include \"arm_c_types.h\"\n";
        let texts = [text.to_owned(), "#include \"own.h\" // mine\n".to_owned()];
        let scratch = tempfile::tempdir().unwrap();
        std::fs::write(scratch.path().join("own.h"), "").unwrap();
        let missing: Vec<_> = missing(&texts, &[scratch.path()]).into_iter().collect();
        assert_eq!(missing, ["acarm.h", "arm_c_types.h"]);
        assert_eq!(meaning("acarm.h", "arm"), Missing::Configuration);
        assert_eq!(meaning("arm_c_types.h", "arm"), Missing::Types);
        assert_eq!(meaning("arm_cxx_types.h", "arm"), Missing::CxxTypes);
        assert_eq!(meaning("opencv.h", "arm"), Missing::Other);
    }
}
