//! Which limit of the system an error of iceoryx2 comes from: it names none itself.

use rustix::process::{Resource, getrlimit};

/// A port or service that fails needs so many files at most.
const FILES: u64 = 8;

/// Its own words, and the limit that this process is at, with the way out.
pub(crate) fn explained(why: &str) -> String {
    let files = std::fs::read_dir("/proc/self/fd").map_or(0, Iterator::count) as u64;
    let maps = std::fs::read("/proc/self/maps").unwrap_or_default();
    let maps = maps.iter().filter(|byte| **byte == b'\n').count() as u64;
    let most = std::fs::read_to_string("/proc/sys/vm/max_map_count").unwrap_or_default();
    let most = most.trim().parse().unwrap_or(u64::MAX);
    match near(getrlimit(Resource::Nofile).current, files, most, maps) {
        Some(limit) => format!("{why}: {limit}"),
        None => why.to_owned(),
    }
}

fn near(most_files: Option<u64>, files: u64, most_maps: u64, maps: u64) -> Option<String> {
    if let Some(most) = most_files.filter(|most| files + FILES >= *most) {
        return Some(format!(
            "this process holds {files} of the {most} files it may have open: raise RLIMIT_NOFILE \
             (`ulimit -n 65536`, or LimitNOFILE=65536 in a systemd unit), or run fewer components \
             in one daemon"
        ));
    }
    (maps + FILES >= most_maps).then(|| {
        format!(
            "this process holds {maps} of the {most_maps} memory maps it may have: raise \
             vm.max_map_count (`sysctl vm.max_map_count=1048576`), or run fewer components in one \
             daemon"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_that_is_reached_is_named() {
        assert_eq!(near(Some(1024), 900, 65_530, 60_000), None);
        assert_eq!(near(None, 1 << 40, u64::MAX, 1), None);
        let files = near(Some(1024), 1020, 65_530, 100).unwrap();
        assert!(files.contains("1020 of the 1024 files") && files.contains("RLIMIT_NOFILE"));
        let maps = near(Some(1 << 20), 9, 65_530, 65_529).unwrap();
        assert!(maps.contains("65529 of the 65530") && maps.contains("vm.max_map_count"));
    }
}
