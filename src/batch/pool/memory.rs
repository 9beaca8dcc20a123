//! Memory of processes.

use std::fs;

/// Memory that a process has in the machine's at the moment \[bytes\], files that it has mapped among it;
/// `None` where the system does not say, which is everywhere but on Linux.
pub fn resident(pid: u32) -> Option<u64> {
    field(&fs::read_to_string(format!("/proc/{pid}/status")).ok()?)
}

/// The same of this process; 0 where the system does not say.
pub fn own() -> u64 {
    resident(std::process::id()).unwrap_or(0)
}

/// `VmRSS` of `/proc/PID/status`, see proc(5).
fn field(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_field_is_found() {
        assert_eq!(field("Name:\tx\nVmHWM:\t 20 kB\nVmRSS:\t    12 kB\n"), Some(12 << 10));
        assert_eq!(field("Name:\tx\n"), None, "a process that has ended has none");
        assert_eq!(field("VmRSS:\tmany kB\n"), None);
    }
}
