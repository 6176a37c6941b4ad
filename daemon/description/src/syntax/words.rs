//! Words that begin statements, by what they are, for suggestions and completion.

/// Properties of components and interfaces.
pub const PROPERTIES: &[&str] = &[
    "doc",
    "version",
    "lang",
    "email",
    "requires",
    "codels-require",
    "clock-rate",
    "provides",
    "uses",
    "extends",
    "throws",
];

/// Parts of components and interfaces.
pub const PARTS: &[&str] = &["ids", "task", "port", "attribute", "function", "activity", "event"];

/// Declarations of IDL.
pub const IDL: &[&str] =
    &["const", "typedef", "struct", "union", "enum", "native", "exception", "module"];
