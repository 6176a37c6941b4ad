//! Names of a description in Lua.

/// Words that cannot be the name of a parameter.
const KEYWORDS: [&str; 22] = [
    "and", "break", "do", "else", "elseif", "end", "false", "for", "function", "goto", "if", "in",
    "local", "nil", "not", "or", "repeat", "return", "then", "true", "until", "while",
];

/// The name of a parameter: keywords of Lua get an underscore.
pub(crate) fn lua_name(name: &str) -> String {
    if KEYWORDS.contains(&name) { format!("{name}_") } else { name.to_owned() }
}

/// A suggestion to append to a message.
pub(crate) fn meant<'a>(typed: &str, names: impl Iterator<Item = &'a str> + Clone) -> String {
    match genom_nearest::nearest(typed, names.clone()) {
        Some(near) => format!("; did you mean `{near}`?"),
        None => {
            let all: Vec<&str> = names.collect();
            if all.is_empty() {
                "; there is none".to_owned()
            } else {
                format!("; there are: {}", all.join(", "))
            }
        }
    }
}
