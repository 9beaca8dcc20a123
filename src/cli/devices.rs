//! `microtome devices`.

use super::exit::CliError;
use super::report;
use clap::Args;
use serde::Serialize;
use std::fmt::Write as _;
use std::io::Write as _;

/// Arguments of `devices`.
#[derive(Debug, Args)]
pub struct DevicesArgs {
    /// Print machine-readable JSON
    #[arg(long)]
    json: bool,
}

/// The answer, as `--json` prints it.
#[derive(Debug, Serialize)]
struct Devices {
    adapters: Vec<Device>,
    /// The name of what `--backend auto` takes for work that repays a GPU's start-up; `cpu` if none.
    auto: String,
    /// Why.
    reason: String,
}

/// One adapter.
#[derive(Debug, Serialize)]
struct Device {
    name: String,
    kind: String,
    software: bool,
    interface: &'static str,
    driver: String,
    max_buffer_bytes: u64,
    max_storage_binding_bytes: u64,
    max_workgroups_per_dimension: u32,
    max_invocations_per_workgroup: u32,
    timestamps: bool,
}

/// Lists the adapters.
///
/// # Errors
/// When stdout cannot be written.
pub fn run(args: &DevicesArgs) -> Result<(), CliError> {
    let devices = find();
    if args.json {
        return Ok(report::json(&devices)?);
    }
    let mut text = String::new();
    for d in &devices.adapters {
        let mib = |bytes: u64| bytes >> 20;
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "{}\n  {}, {} ({})\n  buffer {} MiB, binding {} MiB, {} groups per dimension, {} invocations per group, timestamps: {}",
            d.name,
            d.kind,
            d.interface,
            d.driver,
            mib(d.max_buffer_bytes),
            mib(d.max_storage_binding_bytes),
            d.max_workgroups_per_dimension,
            d.max_invocations_per_workgroup,
            if d.timestamps { "yes" } else { "no" },
        );
    }
    let _ = writeln!(text, "auto takes: {} ({})", devices.auto, devices.reason);
    std::io::stdout().lock().write_all(text.as_bytes())?;
    Ok(())
}

#[cfg(not(feature = "gpu"))]
fn find() -> Devices {
    let reason = "this program was built without the feature `gpu`".to_owned();
    Devices { adapters: Vec::new(), auto: "cpu".to_owned(), reason }
}

#[cfg(feature = "gpu")]
fn find() -> Devices {
    use crate::gpu::{self, Selection};
    let adapters: Vec<Device> = gpu::adapters()
        .into_iter()
        .map(|a| Device {
            kind: a.device_type.to_string(),
            software: a.software,
            interface: a.backend,
            driver: format!("{} {}", a.driver, a.driver_info).trim().to_owned(),
            max_buffer_bytes: a.limits.buffer,
            max_storage_binding_bytes: a.limits.storage_binding,
            max_workgroups_per_dimension: a.limits.groups_per_dimension,
            max_invocations_per_workgroup: a.limits.invocations_per_group,
            timestamps: a.timestamps,
            name: a.name,
        })
        .collect();
    let (auto, reason) = match gpu::choose(&Selection::Auto) {
        Ok(adapter) => (
            adapter.info.name,
            "a hardware GPU; used for jobs large enough to repay its start-up, the CPU does the others"
                .to_owned(),
        ),
        Err(_) if adapters.is_empty() => {
            ("cpu".to_owned(), "no Vulkan, Metal or DirectX 12 device was found".to_owned())
        }
        Err(_) => (
            "cpu".to_owned(),
            "there are only software devices, which are used when named with --adapter".to_owned(),
        ),
    };
    Devices { adapters, auto, reason }
}
