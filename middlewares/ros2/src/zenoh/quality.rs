//! Quality of service, as liveliness tokens tell of it. It keeps no two ends apart: zenoh connects
//! all of one key.

/// Depth that an end has unless its token says otherwise: the default of `rmw_zenoh_cpp`.
const DEPTH: usize = 42;

/// What is told of an end. Deadlines, lifespans and leases are not used here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Quality {
    pub(crate) reliable: bool,
    pub(crate) transient_local: bool,
    pub(crate) depth: usize,
}

impl Quality {
    /// What services have.
    pub(crate) const SERVICE: Self = Self { reliable: true, transient_local: false, depth: 10 };

    /// `<reliability>:<durability>:<history>,<depth>:<deadline>:<lifespan>:<liveliness>`; what is
    /// the default is left out.
    pub(crate) fn encoded(&self) -> String {
        let reliability = if self.reliable { "" } else { "2" };
        let durability = if self.transient_local { "1" } else { "" };
        let depth = if self.depth == DEPTH { String::new() } else { self.depth.to_string() };
        format!("{reliability}:{durability}:,{depth}:,:,:,,")
    }

    /// `None` for what has another form.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let mut parts = text.split(':');
        let (reliability, durability) = (parts.next()?, parts.next()?);
        let (_, depth) = parts.next()?.split_once(',')?;
        let depth = if depth.is_empty() { DEPTH } else { depth.parse().ok()? };
        Some(Self {
            reliable: reliability != "2",
            transient_local: durability == "1",
            // As in ROS, 0 stands for the default.
            depth: if depth == 0 { DEPTH } else { depth },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quality_comes_back_as_it_was_and_defaults_are_those_of_rmw_zenoh() {
        for (reliable, transient_local) in [(true, false), (false, false), (true, true)] {
            let quality = Quality { reliable, transient_local, depth: 7 };
            assert_eq!(Quality::parse(&quality.encoded()), Some(quality));
        }
        let default = Quality { reliable: true, transient_local: false, depth: 42 };
        assert_eq!(Quality::parse("::,:,:,:,,"), Some(default));
        assert_eq!(Quality::parse("1:2:1,0:,:,:,,"), Some(default));
        assert_eq!(Quality { depth: 7, ..default }.encoded(), "::,7:,:,:,,");
        for wrong in ["", "::", "::7", "::,x:,:,:,,"] {
            assert_eq!(Quality::parse(wrong), None, "{wrong}");
        }
    }
}
