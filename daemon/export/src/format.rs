//! The languages that models are written in.

/// A language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Of Spin: the rules, written out again.
    Promela,
    /// Of UPPAAL: the rules, written out again, with clocks.
    Uppaal,
    /// Of TChecker: states and steps, with clocks.
    Tchecker,
    /// Of UPPAAL: states and steps, with clocks.
    UppaalFlat,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Promela, Self::Uppaal, Self::Tchecker, Self::UppaalFlat];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Promela => "promela",
            Self::Uppaal => "uppaal",
            Self::Tchecker => "tchecker",
            Self::UppaalFlat => "uppaal-flat",
        }
    }
}
