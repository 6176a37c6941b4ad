//! Parts that several headers may contain, each in its namespace.

use std::fmt::Write;

use genom_types::ScopedName;

/// Writes `text` in the namespace of `name`, under a guard, since several headers may contain it.
pub(super) fn scoped(out: &mut String, name: &ScopedName, text: &str) {
    guarded(out, &name.to_c(), namespace(name), text);
}

/// The scopes around a name.
pub(super) fn namespace(name: &ScopedName) -> &[String] {
    let segments = name.segments();
    segments.get(..segments.len().saturating_sub(1)).unwrap_or_default()
}

/// As [`scoped`], with a guard of another name.
pub(super) fn guarded(out: &mut String, guard: &str, namespace: &[String], text: &str) {
    let open: String = namespace.iter().map(|name| format!("namespace {name} {{ ")).collect();
    let close = "}".repeat(namespace.len());
    let (open, close) = (open.trim_end(), close.as_str());
    let newline = if namespace.is_empty() { "" } else { "\n" };
    let _ = write!(
        out,
        "#ifndef _{guard}_cxx_type\n# define _{guard}_cxx_type\n\
         {open}{newline}{text}\n{close}{newline}#endif /* _{guard}_cxx_type */\n\n"
    );
}
