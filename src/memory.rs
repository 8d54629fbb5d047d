//! The memory of the machine.

/// The bytes that can still be had without ending other programs, if the system reports it.
pub fn available() -> Option<u64> {
    let text = |path: &str| std::fs::read_to_string(path).ok();
    let machine = text("/proc/meminfo").and_then(|text| of_machine(&text));
    // The most that a container may take in all.
    let container = text("/sys/fs/cgroup/memory.max").and_then(|text| text.trim().parse().ok());
    machine.into_iter().chain(container).min()
}

/// `MemAvailable: 1024 kB` and `SwapFree: 0 kB` among other lines.
fn of_machine(text: &str) -> Option<u64> {
    let kilobytes = |name: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(name))?;
        line.trim_start_matches(':').split_whitespace().next()?.parse::<u64>().ok()
    };
    Some((kilobytes("MemAvailable")?.saturating_add(kilobytes("SwapFree").unwrap_or(0))).saturating_mul(1024))
}

/// Checks that so many bytes can be had. A system that promises more memory than it has ends the program when it is used.
pub fn check(bytes: u64) -> Result<(), String> {
    let gib = |bytes: u64| bytes as f64 / (1u64 << 30) as f64;
    if let Some(available) = available()
        && bytes > available
    {
        return Err(format!("{:.1} GiB of memory, and {:.1} GiB can be had", gib(bytes), gib(available)));
    }
    let had = usize::try_from(bytes).ok().map(|bytes| Vec::<u8>::new().try_reserve_exact(bytes));
    match had {
        Some(Ok(())) => Ok(()),
        _ => Err(format!("{:.1} GiB of memory, which cannot be had", gib(bytes))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_system_tells_what_can_be_had() {
        let text = "MemTotal:  4000 kB\nMemFree:  10 kB\nMemAvailable:    2048 kB\nSwapFree:  1024 kB\n";
        assert_eq!(of_machine(text), Some(3 << 20));
        assert_eq!(of_machine("MemTotal: 4000 kB\n"), None);
        assert!(check(1 << 20).is_ok());
        let message = check(u64::MAX).unwrap_err();
        assert!(message.contains("GiB of memory"), "{message}");
    }
}
