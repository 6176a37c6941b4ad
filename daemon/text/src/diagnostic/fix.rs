//! Corrections that are certain, as edits of the text.

use super::Diagnostic;
use crate::source::SourceMap;
use crate::source::Span;

/// An edit that corrects a mistake.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fix {
    /// What it does, in a few words.
    pub title: String,
    /// What to replace.
    pub span: Span,
    /// What to write there.
    pub text: String,
}

/// The edit that a diagnostic's help proposes, if it proposes one.
#[must_use]
pub fn fix(said: &Diagnostic, sources: &SourceMap) -> Option<Fix> {
    let help = said.help.as_deref()?;
    let written = sources.text(said.span);
    // Text made by a macro cannot be corrected where the macro is used.
    let own = sources.file(said.span.file).is_some_and(|file| !file.is_synthetic());
    if !own || sources.expansion(said.span).is_some() {
        return None;
    }
    if let Some(rest) = help.strip_prefix("did you mean `") {
        let name = rest.split('`').next()?.trim_start_matches('#');
        // Of a path, the last name is replaced.
        let last = written.rfind(|c: char| !c.is_ascii_alphanumeric() && c != '_' && c != '-');
        let begin = last.map_or(0, |at| at + 1);
        let wrong = written.get(begin..).filter(|word| !word.is_empty())?;
        let start = said.span.start + u32::try_from(begin).ok()?;
        let title = format!("change `{wrong}` to `{name}`");
        return Some(Fix { title, span: Span { start, ..said.span }, text: name.to_owned() });
    }
    if said.code == "W0101" {
        let text = help.strip_prefix("write `")?.split('`').next()?.to_owned();
        return Some(Fix { title: format!("write `{text}`"), span: said.span, text });
    }
    (help == "remove the `:`" && written == ":").then(|| Fix {
        title: help.to_owned(),
        span: said.span,
        text: String::new(),
    })
}
