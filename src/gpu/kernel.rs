//! Kernels compiled for a device.

use super::{Device, GpuError};
use crate::shaders::{Binding, Kernel};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// A kernel compiled for one device.
pub(super) struct Pipeline {
    pub raw: wgpu::ComputePipeline,
    pub layout: wgpu::BindGroupLayout,
}

/// The kernels compiled so far, by name.
#[derive(Default)]
pub(super) struct Pipelines(Mutex<BTreeMap<&'static str, Arc<Pipeline>>>);

impl Device {
    /// Compiles kernels ahead of their first use. Some drivers compile only at the first dispatch.
    ///
    /// # Errors
    /// [`GpuError::Validation`] or [`GpuError::Internal`] when the driver refuses one.
    pub fn prepare(&self, kernels: &[Kernel]) -> Result<(), GpuError> {
        kernels.iter().try_for_each(|kernel| self.pipeline(kernel).map(drop))
    }

    pub(super) fn pipeline(&self, kernel: &Kernel) -> Result<Arc<Pipeline>, GpuError> {
        let mut known = self.pipelines.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(pipeline) = known.get(kernel.name) {
            return Ok(Arc::clone(pipeline));
        }
        let pipeline = Arc::new(self.guarded(|| compile(&self.raw, kernel))?);
        known.insert(kernel.name, Arc::clone(&pipeline));
        Ok(pipeline)
    }
}

fn compile(device: &wgpu::Device, kernel: &Kernel) -> Pipeline {
    let entries: Vec<_> = (0..).zip(kernel.bindings).map(|(i, &binding)| entry(i, binding)).collect();
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(kernel.name),
        entries: &entries,
    });
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(kernel.name),
        bind_group_layouts: &[Some(&layout)],
        immediate_size: 0,
    });
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(kernel.name),
        source: wgpu::ShaderSource::Wgsl(Cow::Borrowed(kernel.wgsl)),
    });
    let raw = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(kernel.name),
        layout: Some(&pipeline_layout),
        module: &module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: &[],
            // Every kernel writes its workgroup memory before it reads it.
            zero_initialize_workgroup_memory: false,
        },
        cache: None,
    });
    Pipeline { raw, layout }
}

fn entry(number: u32, binding: Binding) -> wgpu::BindGroupLayoutEntry {
    let ty = match binding {
        Binding::Uniform => wgpu::BufferBindingType::Uniform,
        Binding::Read => wgpu::BufferBindingType::Storage { read_only: true },
        Binding::Write => wgpu::BufferBindingType::Storage { read_only: false },
    };
    wgpu::BindGroupLayoutEntry {
        binding: number,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    }
}
