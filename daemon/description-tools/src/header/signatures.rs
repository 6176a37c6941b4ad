//! Whether codels are declared.

/// Whether a header declares the codels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signatures {
    /// With their prototypes (`--signature` of GenoM3's template `mappings`).
    Written,
    /// Types, events, ports and remotes only.
    Omitted,
}
