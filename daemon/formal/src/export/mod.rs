//! The model in the languages of other tools, to be checked by them (`docs/verify.md`).

mod claim;
mod error;
mod flat;
mod promela;
mod tchecker;
mod unit;
mod uppaal;

pub use claim::fairness;
pub use error::ExportError;

use crate::ltl::Formula;
use crate::system::System;
use crate::timed::Times;
use genom_timing::Limits;

/// A language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Of Spin: the rules, written out again.
    Promela,
    /// Of TChecker: states and steps, with clocks.
    Tchecker,
    /// Of UPPAAL: states and steps, with clocks.
    Uppaal,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Promela, Self::Tchecker, Self::Uppaal];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Promela => "promela",
            Self::Tchecker => "tchecker",
            Self::Uppaal => "uppaal",
        }
    }
}

impl System {
    /// The model in Promela with a formula as its claim `user`.
    ///
    /// # Errors
    /// If Promela cannot express the component or the formula, or the formula takes times and there
    /// are none.
    pub fn export_claim(
        &self,
        formula: &Formula,
        times: Option<&Times>,
    ) -> Result<String, ExportError> {
        if formula.has_late() && times.is_none() {
            return Err(ExportError::NoTimes);
        }
        let model = promela::promela(self, times)?;
        let claim = claim::claim(self, formula, &model).ok_or(ExportError::Past)?;
        // Other errors than that of the claim are other properties.
        Ok(format!("#define CLAIM_ONLY\n{model}{claim}"))
    }

    /// The model as a text, with the commands that check it as comments.
    ///
    /// # Errors
    /// If the language cannot express it, or takes times and has none.
    pub fn export(
        &self,
        format: Format,
        times: Option<&Times>,
        limits: &Limits,
    ) -> Result<String, ExportError> {
        match format {
            Format::Promela => promela::promela(self, times),
            Format::Tchecker | Format::Uppaal => {
                let times = times.ok_or(ExportError::NoTimes)?;
                let flat = flat::flat(self, times, limits).map_err(ExportError::Limit)?;
                Ok(match format {
                    Format::Tchecker => tchecker::tchecker(self, &flat),
                    _ => uppaal::uppaal(self, &flat),
                })
            }
        }
    }
}
