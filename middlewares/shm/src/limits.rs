//! Finds out which limit of the system caused an error of iceoryx2, which does not say so. The
//! limit of open files is reported by the users of this crate, since any middleware may reach it.

/// Greatest number of memory maps that opening a port or service needs.
const MAPS: u64 = 8;

/// The error text, followed by the limit that this process has reached and how to raise it.
pub(crate) fn explained(why: &str) -> String {
    let maps = std::fs::read("/proc/self/maps").unwrap_or_default();
    let maps = maps.iter().filter(|byte| **byte == b'\n').count() as u64;
    let most = std::fs::read_to_string("/proc/sys/vm/max_map_count").unwrap_or_default();
    let most = most.trim().parse().unwrap_or(u64::MAX);
    match near(most, maps) {
        Some(limit) => format!("{why}: {limit}"),
        None => why.to_owned(),
    }
}

fn near(most: u64, maps: u64) -> Option<String> {
    (maps + MAPS >= most).then(|| {
        format!(
            "this process holds {maps} of the {most} memory maps it may have: raise \
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
        assert_eq!(near(65_530, 60_000), None);
        assert_eq!(near(u64::MAX, 1), None);
        let maps = near(65_530, 65_529).unwrap();
        assert!(maps.contains("65529 of the 65530") && maps.contains("vm.max_map_count"));
    }
}
