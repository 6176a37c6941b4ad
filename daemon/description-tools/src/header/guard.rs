//! Pieces that several headers may bring.

use std::fmt::Write;

/// Writes a piece that several headers may bring, once (genom3.md 5.9).
pub(super) fn guarded(out: &mut String, name: &str, text: &str) {
    let _ = write!(
        out,
        "#ifndef _{name}_c_type\n# define _{name}_c_type\n{text}\n#endif /* _{name}_c_type */\n\n"
    );
}
