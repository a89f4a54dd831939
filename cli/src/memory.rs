//! How much memory there is and was, where the system says so.

/// The most memory that this process has held.
pub fn peak_bytes() -> Option<u64> {
    field("/proc/self/status", "VmHWM:")
}

/// Memory that this process could still take without others giving theirs up.
pub fn free_bytes() -> Option<u64> {
    let free = field("/proc/meminfo", "MemAvailable:")?;
    // A container has a limit of its own; what it only keeps of files makes room.
    let read = |name: &str| std::fs::read_to_string(format!("/sys/fs/cgroup/{name}")).ok();
    let most = read("memory.max").and_then(|text| text.trim().parse::<u64>().ok());
    let taken =
        read("memory.stat").and_then(|text| text.lines().find_map(|line| line.strip_prefix("anon ")?.parse().ok()));
    match (most, taken) {
        (Some(most), Some(taken)) => Some(free.min(most.saturating_sub(taken))),
        _ => Some(free),
    }
}

// A line such as `VmHWM: 1234 kB`.
fn field(path: &str, name: &str) -> Option<u64> {
    let text = std::fs::read_to_string(path).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}
