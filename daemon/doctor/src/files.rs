//! Findings from files of the machine (`/proc`, `/sys`, `/dev`).

use genom_protocol::Diagnosis;
use genom_protocol::units::bytes;

use crate::machine::Machine;
use crate::memory;

/// Shared memory smaller than this holds only few images.
const LITTLE_MEMORY: u64 = 64 << 20;
/// With socket buffers smaller than this, bursts of fragments of a large sample are lost.
const SMALL_BUFFER: u64 = 2 << 20;
/// Bit numbers of `CAP_SYS_NICE` and of `CAP_IPC_LOCK`.
const SYS_NICE: u32 = 23;
const IPC_LOCK: u32 = 14;

/// All findings that files give.
#[must_use]
pub fn of_files(machine: &Machine) -> Vec<Diagnosis> {
    let mut found = vec![
        shared_memory(machine),
        memory::nodes(machine, &memory::roots(machine)),
        memory::segments(machine, &memory::PREFIXES),
        loopback(machine),
        buffers(machine),
        domain(std::env::var("ROS_DOMAIN_ID").ok().as_deref()),
    ];
    found.extend(rights(machine));
    found.extend(timing(machine));
    found
}

fn shared_memory(machine: &Machine) -> Diagnosis {
    const ABOUT: &str = "shared memory";
    let path = machine.path("/dev/shm");
    if !path.is_dir() {
        let fix = "`mount -t tmpfs tmpfs /dev/shm`; in a container, give it one";
        return Diagnosis::problem(ABOUT, "there is no /dev/shm: backend shm cannot start", fix);
    }
    let Ok(space) = rustix::fs::statvfs(&path) else {
        return Diagnosis::problem(ABOUT, "/dev/shm cannot be looked at", "see its permissions");
    };
    let free = space.f_bavail.saturating_mul(space.f_frsize);
    if free < LITTLE_MEMORY {
        #[allow(clippy::cast_precision_loss, reason = "a few digits are shown")]
        let what = format!("{} are free in /dev/shm", bytes(free as f64));
        let fix = "`mount -o remount,size=1G /dev/shm`; in a container, --shm-size=1g; or remove \
                   what killed programs left there";
        return Diagnosis::problem(ABOUT, what, fix);
    }
    Diagnosis::ok(ABOUT, "/dev/shm is there and has room")
}

/// Flags of a network interface (linux/if.h).
const UP: u32 = 0x1;
const MULTICAST: u32 = 0x1000;

fn loopback(machine: &Machine) -> Diagnosis {
    const ABOUT: &str = "loopback";
    let flags = machine.text("/sys/class/net/lo/flags");
    let flags = flags.and_then(|text| u32::from_str_radix(text.trim_start_matches("0x"), 16).ok());
    match flags {
        None => Diagnosis::problem(ABOUT, "there is no interface lo", "`ip link set lo up`"),
        Some(flags) if flags & UP == 0 => {
            Diagnosis::problem(ABOUT, "interface lo is down", "`ip link set lo up`")
        }
        Some(flags) if flags & MULTICAST == 0 => Diagnosis::note(
            ABOUT,
            "interface lo has no multicast: ROS 2 peers on this machine find each other only when \
             another interface is up",
            "`ip link set lo multicast on` and `ip route add 239.0.0.0/8 dev lo`",
        ),
        Some(_) => Diagnosis::ok(ABOUT, "interface lo is up, with multicast"),
    }
}

fn buffers(machine: &Machine) -> Diagnosis {
    const ABOUT: &str = "socket buffers";
    let most: Option<u64> =
        machine.text("/proc/sys/net/core/rmem_max").and_then(|text| text.parse().ok());
    match most {
        Some(most) => {
            #[allow(clippy::cast_precision_loss, reason = "a few digits are shown")]
            let size = bytes(most as f64);
            if most < SMALL_BUFFER {
                let what = format!("{size} at most: ROS 2 loses large samples");
                return Diagnosis::note(ABOUT, what, "`sysctl -w net.core.rmem_max=33554432`");
            }
            // The system gives twice as much, and a datagram takes up to twice its size of it.
            Diagnosis::ok(ABOUT, format!("large enough for samples of {size} on ROS 2"))
        }
        None => Diagnosis::ok(ABOUT, "not told"),
    }
}

fn domain(set: Option<&str>) -> Diagnosis {
    const ABOUT: &str = "ROS domain";
    match set {
        None => Diagnosis::ok(ABOUT, "0, as nothing else is said"),
        Some(text) => match text.parse::<u32>() {
            Ok(domain) if domain <= 232 => Diagnosis::ok(ABOUT, format!("{domain}")),
            _ => Diagnosis::problem(
                ABOUT,
                format!("ROS_DOMAIN_ID is `{text}`"),
                "a number from 0 to 232",
            ),
        },
    }
}

fn rights(machine: &Machine) -> Vec<Diagnosis> {
    let capabilities = machine.text("/proc/self/status").and_then(|text| {
        let line = text.lines().find_map(|line| line.strip_prefix("CapEff:"))?.trim().to_owned();
        u64::from_str_radix(&line, 16).ok()
    });
    let has = |bit: u32| capabilities.is_some_and(|set| set >> bit & 1 == 1);
    let limits = machine.text("/proc/self/limits").unwrap_or_default();
    let limit = |name: &str| {
        let line = limits.lines().find_map(|line| line.strip_prefix(name))?;
        line.split_whitespace().next().map(str::to_owned)
    };
    let priority = limit("Max realtime priority").unwrap_or_default();
    let real_time = if has(SYS_NICE) || priority.parse().is_ok_and(|most: u32| most >= 90) {
        Diagnosis::ok("real-time rights", "tasks may have real-time priorities")
    } else {
        Diagnosis::note(
            "real-time rights",
            format!("RLIMIT_RTPRIO is {priority}: real-time tasks run as any thread"),
            "`@realtime - rtprio 95` in /etc/security/limits.d/genom.conf, then log in again; in a \
             container, --cap-add=SYS_NICE",
        )
    };
    let memory = limit("Max locked memory").unwrap_or_default();
    let locked = if has(IPC_LOCK) || memory == "unlimited" {
        Diagnosis::ok("locked memory", "as much as is wanted")
    } else {
        Diagnosis::note(
            "locked memory",
            format!("{memory} bytes at most: pages of real-time tasks may be swapped out"),
            "`@realtime - memlock unlimited` in /etc/security/limits.d/genom.conf; in a container, \
             --ulimit memlock=-1",
        )
    };
    vec![real_time, locked]
}

fn timing(machine: &Machine) -> Vec<Diagnosis> {
    // Tasks set their own timer slack; this reports what they cannot change.
    let source = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
    let clock = match machine.text(source) {
        Some(name) if ["hpet", "acpi_pm", "jiffies"].contains(&name.as_str()) => Diagnosis::note(
            "clock",
            format!("clock source {name} is slow to read"),
            "boot with clocksource=tsc, when the processor has a steady one",
        ),
        Some(name) => Diagnosis::ok("clock", format!("clock source {name}")),
        None => Diagnosis::ok("clock", "not told"),
    };
    let slack = match machine.text("/proc/self/timerslack_ns") {
        Some(slack) => Diagnosis::ok("timer slack", format!("{slack} ns; tasks ask for 1 ns")),
        None => Diagnosis::note(
            "timer slack",
            "/proc/self/timerslack_ns is missing: wake-ups may be gathered",
            "a kernel with timer slack (Linux 4.6 or later)",
        ),
    };
    let governor = match machine.text("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor") {
        Some(name) if name == "powersave" => Diagnosis::note(
            "processor speed",
            "governor powersave: the first cycles after a pause are slow",
            "`cpupower frequency-set -g performance`",
        ),
        Some(name) => Diagnosis::ok("processor speed", format!("governor {name}")),
        None => Diagnosis::ok("processor speed", "not governed"),
    };
    vec![clock, slack, governor]
}

#[cfg(test)]
mod tests {
    use genom_protocol::Severity;

    use super::*;

    #[test]
    fn a_domain_is_a_small_number() {
        assert_eq!(domain(None).level, Severity::Ok);
        assert_eq!(domain(Some("232")).level, Severity::Ok);
        for wrong in ["233", "-1", "robot", ""] {
            assert_eq!(domain(Some(wrong)).level, Severity::Problem, "{wrong}");
        }
    }
}
