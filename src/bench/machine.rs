//! Clocks, and what the machine can do at best.

use super::BenchError;
use serde::Serialize;
use std::fmt;
use std::hint::black_box;
use std::time::Instant;

/// What a stage took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Time {
    /// By the clock on the wall \[s\].
    pub wall: f64,
    /// Of all threads of this process, user and system \[s\]; none where the system does not tell.
    pub cpu: Option<f64>,
}

/// CPU time of this process \[s\].
fn cpu_seconds() -> Option<f64> {
    #[cfg(target_os = "linux")]
    {
        let now = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Some(now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9)
    }
    #[cfg(not(target_os = "linux"))]
    None
}

/// Times one run.
pub(super) fn once<T>(work: impl FnOnce() -> T) -> (Time, T) {
    let (wall, cpu) = (Instant::now(), cpu_seconds());
    let result = work();
    let cpu = cpu_seconds().zip(cpu).map(|(end, begin)| end - begin);
    (Time { wall: wall.elapsed().as_secs_f64(), cpu }, result)
}

/// The median of `runs` runs, at least one, and the last one's result. Each result is dropped before
/// the next run, outside the clock.
pub(super) fn median<T>(runs: usize, mut work: impl FnMut() -> T) -> (Time, T) {
    let (first, mut result) = once(&mut work);
    let mut times = vec![first];
    for _ in 1..runs {
        drop(result);
        let again = once(&mut work);
        times.push(again.0);
        result = again.1;
    }
    (middle(&times), result)
}

/// The median of each clock.
pub(super) fn middle(times: &[Time]) -> Time {
    let of = |mut values: Vec<f64>| {
        values.sort_unstable_by(f64::total_cmp);
        let n = values.len();
        values.get(n / 2).zip(values.get(n.saturating_sub(1) / 2)).map(|(a, b)| (a + b) / 2.0)
    };
    Time {
        wall: of(times.iter().map(|t| t.wall).collect()).unwrap_or_default(),
        cpu: of(times.iter().filter_map(|t| t.cpu).collect()),
    }
}

/// Threads of their own for a measurement.
pub(super) fn pool(threads: usize) -> Result<rayon::ThreadPool, BenchError> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|source| BenchError::Threads { threads, source })
}

/// Where the figures come from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Machine {
    /// The processor, in its own words.
    pub processor: String,
    /// Threads that run at the same time.
    pub cores: usize,
    /// Load averages over 1, 5 and 15 minutes when the benchmark began; above 0 something else was
    /// running.
    pub load: Option<[f64; 3]>,
    /// What copying memory reaches.
    pub copy: Vec<Copy>,
    /// This program's version.
    pub version: &'static str,
}

/// Memory bandwidth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Copy {
    /// Threads that copy.
    pub threads: usize,
    /// Bytes read plus bytes written \[1/s\].
    pub bytes_per_s: f64,
}

impl Machine {
    /// Measures the memory bandwidth with each number of threads, and one.
    pub(super) fn measure(threads: &[usize], quick: bool) -> Result<Self, BenchError> {
        let mut numbers: Vec<usize> = threads.iter().copied().chain([1]).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let mebibytes = if quick { 32 } else { 256 };
        let load = load();
        let copy = numbers
            .into_iter()
            .map(|threads| Ok(Copy { threads, bytes_per_s: copy_bandwidth(threads, mebibytes)? }))
            .collect::<Result<_, BenchError>>()?;
        Ok(Self {
            processor: processor(),
            cores: std::thread::available_parallelism().map_or(1, Into::into),
            load,
            copy,
            version: env!("CARGO_PKG_VERSION"),
        })
    }

    /// The bandwidth with so many threads \[bytes/s\].
    pub(super) fn bandwidth(&self, threads: usize) -> Option<f64> {
        self.copy.iter().find(|c| c.threads == threads).map(|c| c.bytes_per_s)
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "microtome {} on {}, {} cores", self.version, self.processor, self.cores)?;
        if let Some([one, five, fifteen]) = self.load {
            write!(f, ", load average {one:.2} {five:.2} {fifteen:.2}")?;
        }
        for copy in &self.copy {
            write!(f, "\ncopy with {} threads: {:.1} GB/s", copy.threads, copy.bytes_per_s / 1e9)?;
        }
        Ok(())
    }
}

/// Bytes read plus bytes written each second by a plain copy, the best of five.
fn copy_bandwidth(threads: usize, mebibytes: usize) -> Result<f64, BenchError> {
    use rayon::prelude::*;
    let pool = pool(threads)?;
    let words = mebibytes << 17;
    let from = vec![1u64; words];
    let mut to = vec![2u64; words];
    let block = words.div_ceil(threads);
    let mut best = 0f64;
    for _ in 0..5 {
        let (time, ()) = once(|| {
            pool.install(|| {
                to.par_chunks_mut(block).zip(from.par_chunks(block)).for_each(|(to, from)| {
                    to.copy_from_slice(from);
                });
            });
        });
        black_box(&mut to);
        best = best.max((2 * 8 * words) as f64 / time.wall.max(1e-9));
    }
    Ok(best)
}

fn load() -> Option<[f64; 3]> {
    let text = std::fs::read_to_string("/proc/loadavg").ok()?;
    let mut figures = text.split_whitespace().map(str::parse);
    let mut next = || figures.next()?.ok();
    Some([next()?, next()?, next()?])
}

fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("model name"));
    let name = line.and_then(|line| line.split_once(':')).map(|(_, name)| name.trim().to_owned());
    name.unwrap_or_else(|| std::env::consts::ARCH.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_lies_in_the_middle() {
        let time = |wall| Time { wall, cpu: None };
        assert_eq!(middle(&[time(3.0), time(1.0), time(2.0)]), time(2.0));
        assert_eq!(middle(&[time(4.0), time(1.0)]), time(2.5));
        let mut runs = 0;
        let (_, last) = median(3, || {
            runs += 1;
            runs
        });
        assert_eq!(last, 3);
    }
}
