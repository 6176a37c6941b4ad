//! That the process of a cell ended, for those who watch the components in it.

/// What is to be told of a process that ended though nobody had asked for that.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Fall {
    /// Nothing: there was none, or all has been told.
    #[default]
    None,
    /// No other one runs yet.
    Down {
        /// Whether those who watch its components have heard of it.
        told: bool,
    },
    /// The next one runs, and nobody has heard of it.
    Untold,
}

impl Fall {
    /// The next process runs.
    pub(super) fn and_up(self) -> Self {
        if self == (Self::Down { told: false }) { Self::Untold } else { Self::None }
    }

    /// It is told.
    pub(super) fn and_told(self) -> Self {
        match self {
            Self::Down { .. } => Self::Down { told: true },
            Self::None | Self::Untold => Self::None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fall_is_told_until_the_next_process_runs_and_once_at_least() {
        let down = Fall::Down { told: false };
        assert_eq!(down.and_told().and_told(), Fall::Down { told: true });
        assert_eq!(down.and_told().and_up(), Fall::None);
        assert_eq!(down.and_up(), Fall::Untold);
        assert_eq!(down.and_up().and_told(), Fall::None);
    }
}
