//! ROS 2 nodes on this machine that cannot see a daemon's, and why: another domain, another
//! middleware, or a range of discovery that leaves this one out.
//!
//! A process is a node if it has ROS's client library mapped. Which middleware it uses is told by
//! what else it has mapped, the rest by its environment (ROS 2 documentation, "About Domain ID",
//! "Improved Dynamic Discovery"; Fast DDS documentation, `FASTDDS_BUILTIN_TRANSPORTS`).

use std::collections::BTreeMap;

use genom_protocol::Diagnosis;

use crate::machine::Machine;

const ABOUT: &str = "ROS 2 nodes";

/// Nodes that are told one by one; the others are counted.
const TOLD: usize = 10;

/// Bytes of a process's list of mapped files that are looked at.
const MAPS: u64 = 4 << 20;

/// How a node communicates.
#[derive(Debug)]
struct Node {
    /// Number and name of its process.
    process: String,
    /// `rmw_fastrtps_cpp`
    rmw: Option<String>,
    environment: BTreeMap<String, String>,
}

impl Node {
    /// The node that a process is, if it is one.
    fn of(machine: &Machine, pid: &str) -> Option<Self> {
        let maps = machine.start_of(&format!("/proc/{pid}/maps"), MAPS)?;
        let files = maps.lines().filter_map(|line| line.rsplit('/').next());
        let mut is_node = false;
        let mut rmw = None;
        for file in files {
            is_node |= file.starts_with("librcl.so");
            // `librmw.so` and `librmw_implementation.so` are of all of them.
            if let Some(name) =
                file.strip_prefix("librmw_").and_then(|rest| rest.split(".so").next())
                && ["fastrtps", "cyclonedds", "zenoh", "connextdds"]
                    .iter()
                    .any(|one| name.starts_with(one))
                && name.ends_with("_cpp")
            {
                rmw = Some(format!("rmw_{name}"));
            }
        }
        let environment = machine.start_of(&format!("/proc/{pid}/environ"), MAPS)?;
        let pair = |text: &str| {
            let (name, value) = text.split_once('=')?;
            (!value.is_empty()).then(|| (name.to_owned(), value.to_owned()))
        };
        let name = machine.text(&format!("/proc/{pid}/comm")).unwrap_or_default();
        is_node.then(|| Self {
            process: format!("process {pid} ({name})"),
            rmw,
            environment: environment.split('\0').filter_map(pair).collect(),
        })
    }

    fn set(&self, name: &str) -> Option<&str> {
        self.environment.get(name).map(String::as_str)
    }

    fn domain(&self) -> &str {
        self.set("ROS_DOMAIN_ID").unwrap_or("0")
    }

    /// Why it does not see the nodes of a daemon, if it does not.
    fn apart(&self, ours: &Ours<'_>) -> Option<Diagnosis> {
        let Self { process, rmw, .. } = self;
        let zenoh = rmw.as_deref().map(|rmw| rmw.starts_with("rmw_zenoh"));
        let domain = self.domain();
        let note = |what: String, fix: &str| Some(Diagnosis::note(ABOUT, what, fix));
        if let (Some(rmw), Some(zenoh)) = (rmw, zenoh)
            && zenoh != (ours.rmw == "zenoh")
        {
            let what = format!(
                "{process} uses {rmw}, this daemon {}: they do not see each other",
                ours.rmw
            );
            let other = if zenoh { "zenoh" } else { "dds" };
            let fix = format!(
                "`rmw = \"{other}\"` in [backends.ros2], or another RMW_IMPLEMENTATION for the node"
            );
            return note(what, &fix);
        }
        if domain != ours.domain {
            let what =
                format!("{process} is in ROS domain {domain}, this daemon in {}", ours.domain);
            return note(what, "the same ROS_DOMAIN_ID for both, or `domain` in [backends.ros2]");
        }
        if zenoh == Some(true) {
            return None;
        }
        if self.set("ROS_AUTOMATIC_DISCOVERY_RANGE") == Some("OFF")
            && self.set("ROS_LOCALHOST_ONLY") != Some("1")
        {
            let what = format!("{process} has ROS_AUTOMATIC_DISCOVERY_RANGE=OFF: nobody finds it");
            return note(what, "LOCALHOST or SUBNET, for the node");
        }
        let transports = self.set("FASTDDS_BUILTIN_TRANSPORTS").unwrap_or("DEFAULT");
        if rmw.as_deref() == Some("rmw_fastrtps_cpp") && transports.starts_with("SHM") {
            let what = format!(
                "{process} has FASTDDS_BUILTIN_TRANSPORTS={transports}: it speaks only over the \
                 shared memory of Fast DDS, which others do not read"
            );
            return note(what, "DEFAULT or UDPv4, for the node");
        }
        None
    }
}

/// How the daemon communicates.
struct Ours<'a> {
    domain: &'a str,
    /// `dds` or `zenoh`
    rmw: &'a str,
}

/// Nodes of this machine beside a daemon whose ROS 2 is as `meet` says. `None` if that is not told.
pub(crate) fn nodes(machine: &Machine, meet: &BTreeMap<String, String>) -> Option<Vec<Diagnosis>> {
    let of = |name: &str| meet.get(name).map(String::as_str);
    let ours = Ours { domain: of("domain")?, rmw: of("rmw")? };
    let mut all = Vec::new();
    for pid in machine.names("/proc") {
        if pid.bytes().all(|byte| byte.is_ascii_digit()) {
            all.extend(Node::of(machine, &pid));
        }
    }
    // Those that share the domain are more likely to be meant.
    all.sort_by_key(|node| node.domain() != ours.domain);
    let apart: Vec<Diagnosis> = all.iter().filter_map(|node| node.apart(&ours)).collect();
    let reach = of("networks").unwrap_or("loopback");
    let seen = format!(
        "domain {} over {}, {}; of {} nodes in other processes here, {} cannot see it",
        ours.domain,
        ours.rmw,
        if reach == "loopback" { "this machine only ([backends.ros2] networks)" } else { reach },
        all.len(),
        apart.len()
    );
    let more = apart.len().saturating_sub(TOLD);
    let mut found = vec![Diagnosis::ok(ABOUT, seen)];
    found.extend(apart.into_iter().take(TOLD));
    if more > 0 {
        found.push(Diagnosis::note(ABOUT, format!("{more} more"), "as above"));
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use genom_protocol::Severity;

    use super::*;

    /// A process with these mapped libraries and variables.
    fn process(root: &Path, pid: u32, libraries: &[&str], environment: &[&str]) {
        let place = root.join(format!("proc/{pid}"));
        fs::create_dir_all(&place).unwrap();
        let line =
            |library: &&str| format!("7f00-7f01 r-xp 00000000 fe:00 12 /opt/lib/{library}\n");
        fs::write(place.join("maps"), libraries.iter().map(line).collect::<String>()).unwrap();
        fs::write(place.join("environ"), environment.join("\0")).unwrap();
        fs::write(place.join("comm"), "talker\n").unwrap();
    }

    fn found(root: &Path, meet: &[(&str, &str)]) -> Vec<String> {
        let meet = meet.iter().map(|(name, value)| ((*name).into(), (*value).into())).collect();
        let found = nodes(&Machine::at(root), &meet).unwrap();
        found.into_iter().map(|one| format!("{:?} {}", one.level, one.what)).collect()
    }

    const DDS: [(&str, &str); 3] = [("domain", "0"), ("rmw", "dds"), ("networks", "loopback")];
    const FAST: [&str; 3] = ["librcl.so", "librmw_implementation.so", "librmw_fastrtps_cpp.so"];

    #[test]
    fn each_node_that_cannot_see_the_daemon_is_told_with_the_reason() {
        let scratch = tempfile::tempdir().unwrap();
        let root = scratch.path();
        process(root, 1, &["libc.so.6"], &["ROS_DOMAIN_ID=9"]);
        process(root, 2, &FAST, &[]);
        process(root, 3, &FAST, &["ROS_DOMAIN_ID=9"]);
        process(root, 4, &["librcl.so", "librmw_zenoh_cpp.so"], &[]);
        process(root, 5, &FAST, &["FASTDDS_BUILTIN_TRANSPORTS=SHM"]);
        process(root, 6, &FAST, &["ROS_AUTOMATIC_DISCOVERY_RANGE=OFF"]);
        process(root, 7, &["librcl.so", "librmw_cyclonedds_cpp.so"], &["ROS_DOMAIN_ID="]);
        fs::create_dir_all(root.join("proc/self")).unwrap();
        let mut told = found(root, &DDS);
        assert!(told.last().unwrap().contains("in ROS domain 9"), "{told:?}");
        assert!(
            told[0].contains("of 6 nodes in other processes here, 4 cannot see it"),
            "{told:?}"
        );
        told[1..].sort();
        let expected = [
            "process 3 (talker) is in ROS domain 9, this daemon in 0",
            "process 4 (talker) uses rmw_zenoh_cpp, this daemon dds: they do not see each other",
            "process 5 (talker) has FASTDDS_BUILTIN_TRANSPORTS=SHM: it speaks only over",
            "process 6 (talker) has ROS_AUTOMATIC_DISCOVERY_RANGE=OFF: nobody finds it",
        ];
        assert_eq!(told.len(), 1 + expected.len(), "{told:?}");
        for (told, expected) in told[1..].iter().zip(expected) {
            assert!(told.contains(expected), "{told}");
        }
    }

    #[test]
    fn over_zenoh_only_those_of_zenoh_and_of_the_domain_are_seen() {
        let scratch = tempfile::tempdir().unwrap();
        let root = scratch.path();
        process(root, 2, &FAST, &[]);
        process(root, 3, &["librcl.so", "librmw_zenoh_cpp.so"], &["ROS_DOMAIN_ID=5"]);
        process(root, 4, &["librcl.so", "librmw_zenoh_cpp.so"], &["ROS_DOMAIN_ID=4"]);
        let told = found(root, &[("domain", "5"), ("rmw", "zenoh")]);
        assert_eq!(told.len(), 3, "{told:?}");
        assert!(told.iter().any(|one| one.contains("uses rmw_fastrtps_cpp, this daemon zenoh")));
        assert!(told.iter().any(|one| one.contains("process 4 (talker) is in ROS domain 4")));
    }

    #[test]
    fn many_nodes_are_counted_and_what_cannot_be_read_is_none() {
        let scratch = tempfile::tempdir().unwrap();
        let root = scratch.path();
        for pid in 1..=500 {
            process(root, pid, &FAST, &["ROS_DOMAIN_ID=9"]);
        }
        fs::create_dir_all(root.join("proc/999/maps")).unwrap();
        let told = found(root, &DDS);
        assert_eq!(told.len(), 1 + TOLD + 1);
        assert!(told[0].starts_with(&format!("{:?}", Severity::Ok)), "{}", told[0]);
        assert!(told.last().unwrap().contains("490 more"), "{told:?}");
        assert!(nodes(&Machine::at(root), &BTreeMap::new()).is_none());
    }
}
