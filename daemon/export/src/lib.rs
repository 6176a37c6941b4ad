//! What a component can do, in the languages of other tools, to be checked by them
//! (`docs/verify.md`).
//!
//! Two formats have the rules written out again (`rules.pml`, `rules.xta`) with tables of the component
//! (`tables`): they know nothing of the search of `genom-formal`, so that tools check that, too. The
//! others have the states and steps that it found.

#![forbid(unsafe_code)]

mod claim;
mod error;
mod format;
mod promela;
mod tables;
mod tchecker;
mod uppaal;
mod uppaal_flat;
mod xml;

pub use claim::fairness;
pub use error::ExportError;
pub use format::Format;

use genom_formal::{Formula, Limits, System, Times};

/// The model as a text, with the commands that check it as comments.
///
/// # Errors
/// If the language cannot express it, or takes times and has none.
pub fn export(
    system: &System,
    format: Format,
    times: Option<&Times>,
    limits: &Limits,
) -> Result<String, ExportError> {
    let flat = || {
        let times = times.ok_or(ExportError::NoTimes)?;
        system.flat(times, limits).map_err(ExportError::Limit)
    };
    match format {
        Format::Promela => promela::promela(system, times),
        Format::Uppaal => uppaal::uppaal(system, times),
        Format::Tchecker => Ok(tchecker::tchecker(system, &flat()?)),
        Format::UppaalFlat => Ok(uppaal_flat::uppaal_flat(system, &flat()?)),
    }
}

/// The model in Promela with a formula as its claim `user`.
///
/// # Errors
/// If Promela cannot express the component or the formula, or the formula takes times and there
/// are none.
pub fn export_claim(
    system: &System,
    formula: &Formula,
    times: Option<&Times>,
) -> Result<String, ExportError> {
    if formula.has_late() && times.is_none() {
        return Err(ExportError::NoTimes);
    }
    let model = promela::promela(system, times)?;
    let claim = claim::claim(system, formula, &model).ok_or(ExportError::Past)?;
    // Other errors than that of the claim are other properties.
    Ok(format!("#define CLAIM_ONLY\n{model}{claim}"))
}
