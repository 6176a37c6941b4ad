//! Files: denied unless granted, by Landlock.

use std::fs::DirBuilder;
use std::os::unix::fs::DirBuilderExt as _;
use std::path::{Path, PathBuf};

use genom_configuration::CellLimits;
use landlock::{
    ABI, Access as _, AccessFs, AccessNet, BitFlags, LandlockStatus, PathBeneath, PathFd, Ruleset,
    RulesetAttr as _, RulesetCreated, RulesetCreatedAttr as _, RulesetError, Scope,
};

use crate::grants::Grants;

/// The newest version of Landlock whose rights are asked for; an older kernel denies less.
const NEWEST: ABI = ABI::V9;

/// What any program reads: libraries and where they are, times, languages, and what the system
/// tells of itself and of this process. The rest of `/proc` would show it the environment of other
/// processes, with what secrets are there.
const SYSTEM: [&str; 22] = [
    "/lib",
    "/lib64",
    "/usr/lib",
    "/usr/lib64",
    "/usr/local/lib",
    "/etc/ld.so.cache",
    "/etc/ld.so.preload",
    "/etc/localtime",
    "/etc/timezone",
    "/usr/share/zoneinfo",
    "/usr/share/locale",
    "/proc/cpuinfo",
    "/proc/meminfo",
    "/proc/stat",
    "/proc/sys",
    "/sys/devices/system/cpu",
    "/sys/fs/cgroup",
    "/dev/zero",
    "/dev/full",
    "/dev/random",
    "/dev/urandom",
    OWN,
];

/// What `/proc` tells of this process.
const OWN: &str = "/proc/self";

/// Devices that take whatever is written.
const SINKS: [&str; 1] = ["/dev/null"];

/// Denies this process all files but those of the system, its own and those granted. Returns what
/// does not hold.
pub(crate) fn deny_others(limits: &CellLimits, grants: &Grants) -> Vec<String> {
    let mut missing = Vec::new();
    for directory in &grants.write {
        // A rule is for what is there.
        let _ = DirBuilder::new().recursive(true).mode(0o700).create(directory);
    }
    let network = limits.network == Some(true);
    match restrict(limits, grants, network, &mut missing) {
        Ok(status) => missing.extend(lacks(status, network)),
        Err(error) => missing.push(format!("files are not denied: {error}")),
    }
    missing
}

fn restrict(
    limits: &CellLimits,
    grants: &Grants,
    network: bool,
    missing: &mut Vec<String>,
) -> Result<LandlockStatus, RulesetError> {
    let mut rules = Ruleset::default().handle_access(AccessFs::from_all(NEWEST))?;
    if !network {
        rules = rules.handle_access(AccessNet::from_all(NEWEST))?;
    }
    let mut rules = rules.scope(Scope::from_all(NEWEST))?.create()?;
    let (reads, all) = (AccessFs::from_read(NEWEST), AccessFs::from_all(NEWEST));
    let system = SYSTEM.iter().map(PathBuf::from);
    let own = system.chain(linked()).chain(grants.read.iter().cloned()).map(|path| (path, reads));
    let sinks = SINKS.iter().map(PathBuf::from);
    let written = sinks.chain(grants.write.iter().cloned()).map(|path| (path, all));
    let sockets = BitFlags::from(AccessFs::ResolveUnix);
    let reached = grants.reach.iter().cloned().map(|path| (path, sockets));
    for (path, access) in own.chain(written).chain(reached) {
        // Machines differ in what they have of these.
        if let Ok(there) = PathFd::new(&path) {
            rules = grant(rules, &path, there, access)?;
        }
    }
    let read = limits.read.iter().flatten().map(|path| ("read", path, reads));
    let write = limits.write.iter().flatten().map(|path| ("write", path, all));
    for (key, path, access) in read.chain(write) {
        match PathFd::new(path) {
            Ok(there) => rules = grant(rules, path, there, access)?,
            Err(error) => {
                let why = std::error::Error::source(&error).map(ToString::to_string);
                let why = why.unwrap_or_else(|| error.to_string());
                missing.push(format!("{key} = {}: not granted: {why}", path.display()));
            }
        }
    }
    // A rule is for an inode, and the kernel forgets those of `/proc` that nobody has open.
    std::mem::forget(PathFd::new(OWN));
    Ok(rules.restrict_self()?.landlock)
}

/// Directories that the user adds to those of libraries.
fn linked() -> Vec<PathBuf> {
    let given = std::env::var_os("LD_LIBRARY_PATH").unwrap_or_default();
    std::env::split_paths(&given).filter(|path| path.is_absolute()).collect()
}

fn grant(
    rules: RulesetCreated,
    path: &Path,
    there: PathFd,
    access: BitFlags<AccessFs>,
) -> Result<RulesetCreated, RulesetError> {
    // Some rights are those of directories only.
    let access = if path.is_dir() { access } else { access & AccessFs::from_file(NEWEST) };
    rules.add_rule(PathBeneath::new(there, access))
}

/// What this kernel's Landlock does not deny.
fn lacks(status: LandlockStatus, network: bool) -> Option<String> {
    let LandlockStatus::Available { effective_abi: abi, .. } = status else {
        return Some(
            "this kernel has no Landlock: files are not denied, nor signals to other processes; \
             Linux 5.13 or newer has it, where it is switched on (`lsm=` of the kernel)"
                .to_owned(),
        );
    };
    let since = [
        (ABI::V3, "truncating files that may not be written (denied by Linux 6.2)"),
        (ABI::V5, "ioctl of devices that are open (6.10)"),
        (ABI::V6, "signals to other processes, and abstract Unix sockets (6.12)"),
    ];
    let mut lacking: Vec<&str> =
        since.iter().filter(|(version, _)| abi < *version).map(|(_, what)| *what).collect();
    if network && abi < ABI::V9 {
        lacking.push("Unix sockets of other programs, this daemon's among them (7.1)");
    }
    let told = || format!("this kernel's Landlock does not deny: {}", lacking.join("; "));
    (!lacking.is_empty()).then(told)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on(abi: ABI) -> LandlockStatus {
        LandlockStatus::Available { effective_abi: abi, kernel_abi: None }
    }

    #[test]
    fn an_older_kernel_is_told_with_what_it_does_not_deny() {
        assert_eq!(lacks(on(ABI::V6), false), None);
        let told = lacks(on(ABI::V4), false).unwrap();
        assert!(told.contains("signals") && !told.contains("truncating"), "{told}");
        assert!(lacks(on(ABI::V7), true).unwrap().contains("Unix sockets of other programs"));
        for none in [LandlockStatus::NotEnabled, LandlockStatus::NotImplemented] {
            assert!(lacks(none, false).unwrap().contains("no Landlock"));
        }
    }
}
