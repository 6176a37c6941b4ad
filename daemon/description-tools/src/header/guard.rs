//! Parts that several headers may contain.

use std::fmt::Write;

/// Writes a part that several headers may contain, under a guard (genom3.md 5.9).
pub(super) fn guarded(out: &mut String, name: &str, text: &str) {
    let _ = write!(
        out,
        "#ifndef _{name}_c_type\n# define _{name}_c_type\n{text}\n#endif /* _{name}_c_type */\n\n"
    );
}
