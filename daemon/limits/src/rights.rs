//! Capabilities of root that a limited process gives up: with them it could lift its limits again.

use genom_configuration::CellLimits;
use rustix::io;
use rustix::thread::{
    CapabilitySet, CapabilitySets, capabilities, remove_capability_from_bounding_set,
    set_capabilities,
};

/// What a sandboxed process could leave its sandbox by.
const OF_SANDBOX: CapabilitySet = CapabilitySet::SYS_ADMIN
    .union(CapabilitySet::SYS_PTRACE)
    .union(CapabilitySet::SYS_MODULE)
    .union(CapabilitySet::SYS_RAWIO)
    .union(CapabilitySet::SYS_BOOT)
    .union(CapabilitySet::SYS_TIME)
    .union(CapabilitySet::NET_ADMIN)
    .union(CapabilitySet::MKNOD)
    .union(CapabilitySet::DAC_READ_SEARCH);

/// Which ones go with these limits.
fn given_up(limits: &CellLimits) -> CapabilitySet {
    let mut all = CapabilitySet::empty();
    let resources = [limits.memory, limits.files, limits.processes, limits.rttime];
    if resources.iter().any(Option::is_some) || limits.real_time == Some(false) {
        all |= CapabilitySet::SYS_RESOURCE;
    }
    if limits.real_time == Some(false) {
        all |= CapabilitySet::SYS_NICE;
    }
    if limits.is_sandbox() {
        all |= OF_SANDBOX;
    }
    if limits.network == Some(false) || (limits.is_sandbox() && limits.network.is_none()) {
        all |= CapabilitySet::NET_RAW;
    }
    all
}

/// Gives up what goes with these limits, for programs that it executes, too. Users have none.
pub(crate) fn drop_for(limits: &CellLimits) -> Option<String> {
    let without = given_up(limits);
    let dropped = give_up(without);
    dropped.err().map(|error| format!("rights of root ({without:?}) stay: {error}"))
}

fn give_up(without: CapabilitySet) -> io::Result<()> {
    let CapabilitySets { effective, permitted, inheritable } = capabilities(None)?;
    if (effective | permitted).intersection(without).is_empty() {
        return Ok(());
    }
    if effective.contains(CapabilitySet::SETPCAP) {
        // Else a program executed as root would have them again.
        without.iter().try_for_each(remove_capability_from_bounding_set)?;
    }
    set_capabilities(
        None,
        CapabilitySets {
            effective: effective - without,
            permitted: permitted - without,
            inheritable: inheritable - without,
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_without_limits_keeps_its_rights() {
        assert!(given_up(&CellLimits::default()).is_empty());
        let nice = CellLimits { nice: Some(3), ..CellLimits::default() };
        assert!(given_up(&nice).is_empty());
        let memory = CellLimits { memory: Some(64), ..CellLimits::default() };
        assert_eq!(given_up(&memory), CapabilitySet::SYS_RESOURCE);
    }
}
