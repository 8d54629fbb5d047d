//! What the benchmarks measure of a process.

/// What a process took.
#[derive(Clone, Copy, Default)]
pub struct Took {
    pub wall: f64,
    /// Processor seconds, user's and system's.
    pub processor: f64,
}

pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Processor seconds of all processes that have ended.
#[cfg(unix)]
pub fn of_children() -> f64 {
    // SAFETY: a struct of numbers, which the call fills.
    let usage = unsafe {
        let mut usage = std::mem::zeroed::<libc::rusage>();
        libc::getrusage(libc::RUSAGE_CHILDREN, &raw mut usage);
        usage
    };
    let seconds = |time: libc::timeval| time.tv_sec as f64 + 1e-6 * time.tv_usec as f64;
    seconds(usage.ru_utime) + seconds(usage.ru_stime)
}

#[cfg(not(unix))]
pub fn of_children() -> f64 {
    f64::NAN
}
