//! Skeletons: sources in which each codel of a description has an empty function, and a project of
//! the kind that GenoM3's components have (genom3.md 5.9).

mod autotools;
mod merge;
mod sheet;

pub use autotools::autotools;
pub use merge::{Conflict, Merge, Source, merge};
pub use sheet::{Sheet, Wanted, sheets};
pub(crate) use sheet::{about, first_yield, is_standard};

use genom_description::model::Component;

/// The language of sources.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// C.
    C,
    /// C++, whatever the language of the component's interface.
    Cxx,
}

impl Language {
    /// The language of the component's interface.
    #[must_use]
    pub fn of(component: &Component) -> Self {
        if component.lang == "c++" { Self::Cxx } else { Self::C }
    }

    /// What the names of sources end with.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            Self::C => "c",
            Self::Cxx => "cc",
        }
    }
}

/// The header that codels of a component include: `demo_c_types.h`, or `demo_cxx_types.h` for an
/// interface in C++.
#[must_use]
pub fn header_name(component: &Component) -> String {
    let interface = if component.lang == "c++" { "cxx" } else { "c" };
    format!("{}_{interface}_types.h", component.name)
}
