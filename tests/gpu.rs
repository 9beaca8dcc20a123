//! Every kernel against its twin, buffer for buffer, on a real device.
//!
//! Each test's name ends with the adapter it ran on. Without any adapter every test is shown as ignored;
//! `MICROTOME_REQUIRE_GPU=1` makes that a failure. `MICROTOME_ADAPTER` picks by a part of the name.

#[path = "gpu/beyond.rs"]
mod beyond;
#[path = "gpu/build.rs"]
mod build;
#[path = "gpu/compare.rs"]
mod compare;
#[path = "gpu/faults.rs"]
mod faults;
#[path = "gpu/files.rs"]
mod files;
#[path = "gpu/infill_rows.rs"]
mod infill_rows;
#[path = "kernels/mod.rs"]
mod kernels;
#[path = "gpu/limits.rs"]
mod limits;
#[path = "gpu/meshes.rs"]
mod meshes;
#[path = "gpu/scan.rs"]
mod scan;
#[path = "gpu/slice.rs"]
mod slice;
#[path = "gpu/span.rs"]
mod span;
#[path = "gpu/span_limits.rs"]
mod span_limits;
#[path = "gpu/warm.rs"]
mod warm;
#[path = "gpu/wide.rs"]
mod wide;

use libtest_mimic::{Arguments, Failed, Trial};
use microtome::gpu::adapter::{Adapter, choose};
use microtome::gpu::{Device, GpuError, Options, Selection};
use std::process::ExitCode;
use std::sync::{Arc, OnceLock};

/// Sizes around every power of two that a workgroup could care for.
const SIZES: [usize; 8] = [0, 1, 63, 64, 65, 255, 256, 257];

/// The devices under test, opened at their first use and shared by all tests.
struct Bench {
    adapter: Adapter,
    plain: OnceLock<Result<Arc<Device>, GpuError>>,
    narrow: OnceLock<Result<Arc<Device>, GpuError>>,
}

impl Bench {
    /// The device as it is.
    fn plain(&self) -> Result<Arc<Device>, GpuError> {
        self.plain.get_or_init(|| self.open(Options::default())).clone()
    }

    /// The same with three workgroups per dimension.
    fn narrow(&self) -> Result<Arc<Device>, GpuError> {
        let options = Options { groups_per_dimension: 3, ..Options::default() };
        self.narrow.get_or_init(|| self.open(options)).clone()
    }

    fn open(&self, options: Options) -> Result<Arc<Device>, GpuError> {
        Device::with_options(&self.adapter, options).map(Arc::new)
    }
}

type Test = (&'static str, fn(&Bench) -> Result<(), Failed>);

fn main() -> ExitCode {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: no other thread exists yet. Without it Mesa complains for every device opened.
        unsafe { std::env::set_var("XDG_RUNTIME_DIR", "/nonexistent") };
    }
    let arguments = Arguments::from_args();
    let asked = std::env::var("MICROTOME_ADAPTER").ok();
    // An empty part matches every name: software devices are welcome here.
    let found = choose(&Selection::Named(asked.clone().unwrap_or_default()));
    let required = asked.is_some() || std::env::var("MICROTOME_REQUIRE_GPU").is_ok_and(|v| v == "1");
    let tests: Vec<Test> = [
        scan::TESTS,
        wide::TESTS,
        slice::TESTS,
        build::TESTS,
        span::TESTS,
        span_limits::TESTS,
        beyond::TESTS,
        infill_rows::TESTS,
        limits::TESTS,
        faults::TESTS,
        files::TESTS,
        warm::TESTS,
    ]
    .concat();
    let trials = match found {
        Ok(adapter) => {
            let on = adapter.info.name.clone();
            let bench = Arc::new(Bench { adapter, plain: OnceLock::new(), narrow: OnceLock::new() });
            let trial = |(name, test): Test| {
                let bench = Arc::clone(&bench);
                Trial::test(format!("{name} [{on}]"), move || test(&bench))
            };
            tests.into_iter().map(trial).collect()
        }
        Err(error) => {
            let ignored = |(name, _): Test| {
                Trial::test(format!("{name} [no device]"), || Err("no device".into())).with_ignored_flag(true)
            };
            let mut trials: Vec<_> = tests.into_iter().map(ignored).collect();
            if required {
                let message = match &asked {
                    Some(_) => error.to_string(),
                    None => "MICROTOME_REQUIRE_GPU=1, but there is no device".to_owned(),
                };
                trials.push(Trial::test("a device is there", move || Err(message.into())));
            }
            trials
        }
    };
    libtest_mimic::run(&arguments, trials).exit_code()
}
