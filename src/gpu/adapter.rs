//! Which devices there are, and which one is taken.

use super::GpuError;
use std::fmt;

/// What is known of a device before it is opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterInfo {
    /// The device's name.
    pub name: String,
    /// What kind of device it is.
    pub device_type: DeviceType,
    /// The interface through which it is reached: `vulkan`, `metal` or `dx12`.
    pub backend: &'static str,
    /// The driver's name.
    pub driver: String,
    /// The driver's version, in its own words.
    pub driver_info: String,
    /// Limits that decide what fits.
    pub limits: AdapterLimits,
    /// Whether it can time kernels.
    pub timestamps: bool,
    /// Whether it computes on the CPU: it proves bits, it is not fast.
    pub software: bool,
}

/// The kinds of device, best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DeviceType {
    /// A card with memory of its own.
    Discrete,
    /// A GPU that shares the CPU's memory.
    Integrated,
    /// A GPU shared with other guests of a host.
    Virtual,
    /// Unknown to the driver.
    Other,
    /// A program that runs on the CPU.
    Software,
}

/// Limits of an adapter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AdapterLimits {
    /// Largest buffer \[bytes\].
    pub buffer: u64,
    /// Largest part of a buffer that a kernel can see \[bytes\].
    pub storage_binding: u64,
    /// Storage buffers per kernel.
    pub storage_buffers: u32,
    /// Invocations per workgroup.
    pub invocations_per_group: u32,
    /// Workgroups per dimension of a dispatch.
    pub groups_per_dimension: u32,
}

/// Which device to take.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Selection {
    /// The best hardware GPU, never a software device.
    #[default]
    Auto,
    /// The best device of any kind with this in its name, whatever the case of the letters.
    Named(String),
}

/// A device that can be opened.
pub struct Adapter {
    /// What is known of it.
    pub info: AdapterInfo,
    pub(super) raw: wgpu::Adapter,
}

/// All devices of this machine. Empty where there is no driver at all.
pub fn adapters() -> Vec<AdapterInfo> {
    enumerate().into_iter().map(|adapter| adapter.info).collect()
}

/// Finds the device to open.
///
/// # Errors
/// [`GpuError::NoHardware`] or [`GpuError::NoSuchAdapter`], with the names of those present.
pub fn choose(selection: &Selection) -> Result<Adapter, GpuError> {
    let mut all = enumerate();
    let infos: Vec<_> = all.iter().map(|adapter| adapter.info.clone()).collect();
    pick(&infos, selection).map(|i| all.swap_remove(i))
}

/// Finds all devices that serve as well as the one that [`choose`] finds: those of its kind that the same
/// interface reaches, in the driver's order.
///
/// # Errors
/// As [`choose`].
pub fn choose_all(selection: &Selection) -> Result<Vec<Adapter>, GpuError> {
    let all = enumerate();
    let infos: Vec<_> = all.iter().map(|adapter| adapter.info.clone()).collect();
    let alike = pick_all(&infos, selection)?;
    Ok((0..).zip(all).filter(|(i, _)| alike.contains(i)).map(|(_, adapter)| adapter).collect())
}

/// The indices of the adapters that [`choose_all`] finds.
fn pick_all(adapters: &[AdapterInfo], selection: &Selection) -> Result<Vec<usize>, GpuError> {
    let best = &adapters[pick(adapters, selection)?];
    let alike = |info: &AdapterInfo| {
        info.device_type == best.device_type && info.backend == best.backend && selection.fits(info)
    };
    Ok((0..adapters.len()).filter(|&i| alike(&adapters[i])).collect())
}

impl Selection {
    fn fits(&self, info: &AdapterInfo) -> bool {
        match self {
            Self::Auto => !info.software,
            Self::Named(part) => info.name.to_lowercase().contains(&part.to_lowercase()),
        }
    }
}

/// The index of the adapter that a selection means: discrete before integrated before the others;
/// among equals the first.
///
/// # Errors
/// As [`choose`].
pub fn pick(adapters: &[AdapterInfo], selection: &Selection) -> Result<usize, GpuError> {
    let best = (0..adapters.len())
        .filter(|&i| selection.fits(&adapters[i]))
        .min_by_key(|&i| adapters[i].device_type);
    best.ok_or_else(|| {
        let names: Vec<_> = adapters.iter().map(|a| a.name.as_str()).collect();
        let present = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        match selection {
            Selection::Auto => GpuError::NoHardware { present },
            Selection::Named(part) => GpuError::NoSuchAdapter { wanted: part.clone(), present },
        }
    })
}

fn enumerate() -> Vec<Adapter> {
    // wgpu panics when it was built for a system that none of its backends knows.
    if wgpu::Instance::enabled_backend_features().is_empty() {
        return Vec::new();
    }
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
    // Neither debug names nor validation layers: what runs does not depend on how this was built.
    descriptor.flags = wgpu::InstanceFlags::empty();
    let instance = wgpu::Instance::new(descriptor);
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    adapters.into_iter().map(|raw| Adapter { info: describe(&raw), raw }).collect()
}

fn describe(adapter: &wgpu::Adapter) -> AdapterInfo {
    let (info, limits) = (adapter.get_info(), adapter.limits());
    let device_type = match info.device_type {
        wgpu::DeviceType::DiscreteGpu => DeviceType::Discrete,
        wgpu::DeviceType::IntegratedGpu => DeviceType::Integrated,
        wgpu::DeviceType::VirtualGpu => DeviceType::Virtual,
        wgpu::DeviceType::Other => DeviceType::Other,
        wgpu::DeviceType::Cpu => DeviceType::Software,
    };
    AdapterInfo {
        name: info.name,
        device_type,
        backend: info.backend.to_str(),
        driver: info.driver,
        driver_info: info.driver_info,
        limits: AdapterLimits {
            buffer: limits.max_buffer_size,
            storage_binding: limits.max_storage_buffer_binding_size,
            storage_buffers: limits.max_storage_buffers_per_shader_stage,
            invocations_per_group: limits.max_compute_invocations_per_workgroup,
            groups_per_dimension: limits.max_compute_workgroups_per_dimension,
        },
        timestamps: adapter.features().contains(wgpu::Features::TIMESTAMP_QUERY),
        software: device_type == DeviceType::Software,
    }
}

impl fmt::Display for DeviceType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Discrete => "discrete GPU",
            Self::Integrated => "integrated GPU",
            Self::Virtual => "virtual GPU",
            Self::Other => "other",
            Self::Software => "software",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info(name: &str, device_type: DeviceType) -> AdapterInfo {
        AdapterInfo {
            name: name.to_owned(),
            device_type,
            backend: "vulkan",
            driver: String::new(),
            driver_info: String::new(),
            limits: AdapterLimits {
                buffer: 0,
                storage_binding: 0,
                storage_buffers: 0,
                invocations_per_group: 0,
                groups_per_dimension: 0,
            },
            timestamps: false,
            software: device_type == DeviceType::Software,
        }
    }

    #[test]
    fn auto_prefers_a_card_and_never_takes_software() {
        let all = [
            info("llvmpipe (LLVM)", DeviceType::Software),
            info("Small", DeviceType::Integrated),
            info("Big A", DeviceType::Discrete),
            info("Big B", DeviceType::Discrete),
        ];
        assert_eq!(pick(&all, &Selection::Auto), Ok(2));
        assert_eq!(pick(&all[..2], &Selection::Auto), Ok(1));
        let none = pick(&all[..1], &Selection::Auto);
        assert_eq!(none, Err(GpuError::NoHardware { present: "llvmpipe (LLVM)".to_owned() }));
        let none = pick(&[], &Selection::Auto);
        assert_eq!(none, Err(GpuError::NoHardware { present: "none".to_owned() }));
    }

    #[test]
    fn devices_alike_serve_side_by_side() {
        let mut all = [
            info("llvmpipe", DeviceType::Software),
            info("Small", DeviceType::Integrated),
            info("Big A", DeviceType::Discrete),
            info("Big B", DeviceType::Discrete),
            info("Big A", DeviceType::Discrete),
        ];
        // The same card once more, by another way.
        all[4].backend = "dx12";
        assert_eq!(pick_all(&all, &Selection::Auto), Ok(vec![2, 3]));
        assert_eq!(pick_all(&all, &Selection::Named("b".to_owned())), Ok(vec![2, 3]));
        assert_eq!(pick_all(&all, &Selection::Named("big b".to_owned())), Ok(vec![3]));
        assert_eq!(pick_all(&all, &Selection::Named("l".to_owned())), Ok(vec![1]));
        assert!(pick_all(&all[..1], &Selection::Auto).is_err());
    }

    #[test]
    fn a_name_takes_any_device() {
        let all = [info("llvmpipe (LLVM)", DeviceType::Software), info("Big", DeviceType::Discrete)];
        let named = |part: &str| pick(&all, &Selection::Named(part.to_owned()));
        assert_eq!(named("LLVMpipe"), Ok(0));
        assert_eq!(named("big"), Ok(1));
        let message = named("other").map_err(|e| e.to_string());
        assert_eq!(message, Err("no GPU has 'other' in its name (present: llvmpipe (LLVM), Big)".to_owned()));
    }
}
