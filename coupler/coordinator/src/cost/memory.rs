//! Memory of the processes of a run, and processor time of the coordinator.

use std::collections::BTreeSet;
use std::fs;

use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeVal;

/// Largest resident sets so far (bytes) of this process and these processes, together. A process that has ended does
/// not count.
pub fn peak_bytes(pids: &[u32]) -> u64 {
    let mut all = BTreeSet::from([std::process::id()]);
    all.extend(pids);
    all.into_iter().filter_map(peak_of).sum()
}

/// Resets the largest resident set of this process, which may have done other runs before. On systems without this
/// feature the old value stays.
pub fn forget_peak() {
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// Processor time of this process so far (s), including its threads.
pub fn own_cpu_s() -> f64 {
    let usage = getrusage(UsageWho::RUSAGE_SELF).ok();
    let seconds = |time: TimeVal| time.tv_sec() as f64 + 1e-6 * time.tv_usec() as f64;
    usage.map_or(0.0, |usage| {
        seconds(usage.user_time()) + seconds(usage.system_time())
    })
}

/// Largest resident set of a process (bytes).
fn peak_of(pid: u32) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kilobytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One test for both, as they concern the same process.
    #[test]
    fn a_peak_is_reset_and_a_process_counts_once() {
        let large = vec![1u8; 200 << 20];
        assert!(large.iter().all(|byte| *byte == 1) && peak_bytes(&[]) > 200 << 20);
        drop(large);
        forget_peak();
        assert!(peak_bytes(&[]) < 200 << 20);
        let own = peak_bytes(&[]);
        assert!(own > 1 << 20, "{own}");
        let twice = peak_bytes(&[std::process::id(), std::process::id(), u32::MAX]);
        assert!(twice < own + own / 2, "{twice} after {own}");
    }
}
