//! How much memory slicing may take when nobody says.

use std::fs;

/// Taken to be there when the system does not say \[bytes\].
const UNKNOWN: u64 = 4 << 30;

/// The share of the machine's memory that slicing may take: one in so many parts.
const SHARE: u64 = 4;

/// A quarter of the memory that this process can have \[bytes\]: the machine's, or what a control group
/// allows of it; 1 GiB where the system does not say.
pub fn default_budget() -> u64 {
    of_machine() / SHARE
}

/// Memory of the machine or of the control group \[bytes\]; 4 GiB where the system does not say.
pub fn of_machine() -> u64 {
    machine().unwrap_or(UNKNOWN)
}

/// Memory of the machine or of the control group \[bytes\]; known on Linux only.
fn machine() -> Option<u64> {
    let meminfo = fs::read_to_string("/proc/meminfo").ok()?;
    let group = ["/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"];
    let group = group.iter().filter_map(|path| fs::read_to_string(path).ok()?.trim().parse::<u64>().ok());
    Some(group.fold(total(&meminfo)?, u64::min))
}

/// `MemTotal` of `/proc/meminfo` \[bytes\].
fn total(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_machine_s_memory_is_read() {
        assert_eq!(total("MemTotal:       16384 kB\nMemFree: 1 kB\n"), Some(16 << 20));
        assert_eq!(total("MemFree: 1 kB\n"), None);
        assert_eq!(total("MemTotal: many kB\n"), None);
        assert!(default_budget() >= 1 << 20);
    }
}
