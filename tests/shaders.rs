//! Every shader, assembled as the crate assembles it, held against naga: it parses, validates with no
//! more capabilities than a device is asked for, keeps floats off coordinates, has the bindings that
//! the registry states, and its uniform has the layout of the Rust structure. Needs no device.

#![allow(clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

#[path = "kernels/mod.rs"]
mod kernels;

use microtome::shaders::{
    AddSizes, BeyondSizes, Binding, EdgeSizes, Kernel, ScanSizes, SliceSizes, SortSizes, SpanSizes,
    WeldSizes, sources,
};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{AddressSpace, Module, StorageAccess, TypeInner};
use std::mem::{offset_of, size_of};
use std::path::Path;

/// A Rust structure as a uniform: size and the offsets of its fields.
struct Layout {
    size: usize,
    fields: Vec<(&'static str, usize)>,
}

macro_rules! layout {
    ($type:ty, $($field:ident),+) => {
        Layout { size: size_of::<$type>(), fields: vec![$((stringify!($field), offset_of!($type, $field))),+] }
    };
}

fn layout_of(kernel: &Kernel) -> Layout {
    match kernel.name {
        "scan_block" => layout!(ScanSizes, input, output),
        "scan_add" => layout!(AddSizes, sums),
        "slice_count" | "slice_emit" | "slice_emit_even" => {
            layout!(SliceSizes, triangles, planes, piece, begin, slot, segments)
        }
        name if name.starts_with("weld_") => {
            layout!(WeldSizes, items, corner, capacity, origin_x, origin_y, origin_z)
        }
        name if name.starts_with("sort_") => layout!(SortSizes, length, shift, blocks),
        name if name.starts_with("edge_") => layout!(EdgeSizes, half_edges),
        name if name.starts_with("span_") => layout!(
            SpanSizes, a, b, base, pitch, lines, sub_rows, rows, planes, triangles, segments, crossings,
            offsets
        ),
        name if name.starts_with("beyond_") => layout!(BeyondSizes, rows),
        other => panic!("state the uniform of {other} here"),
    }
}

fn parse(kernel: &Kernel) -> Module {
    let module = naga::front::wgsl::parse_str(kernel.wgsl)
        .unwrap_or_else(|e| panic!("{}: {}", kernel.name, e.emit_to_string(kernel.wgsl)));
    Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .unwrap_or_else(|e| panic!("{}: {}", kernel.name, e.emit_to_string(kernel.wgsl)));
    module
}

/// Where the shader's uniform parts from the Rust structure.
fn check_layout(module: &Module, layout: &Layout) -> Result<(), String> {
    let uniform = module
        .global_variables
        .iter()
        .find(|(_, variable)| variable.space == AddressSpace::Uniform)
        .ok_or("no uniform")?
        .1;
    let TypeInner::Struct { members, span } = &module.types[uniform.ty].inner else {
        return Err("the uniform is not a structure".to_owned());
    };
    if *span as usize != layout.size {
        return Err(format!("{span} bytes in the shader, {} in Rust", layout.size));
    }
    let named = |member: &&naga::StructMember| {
        !member.name.as_deref().is_some_and(|name| name.starts_with("padding"))
    };
    let shader: Vec<_> = members
        .iter()
        .filter(named)
        .map(|member| (member.name.as_deref().unwrap_or(""), member.offset as usize))
        .collect();
    if shader != layout.fields {
        return Err(format!("{shader:?} in the shader, {:?} in Rust", layout.fields));
    }
    Ok(())
}

/// The bindings of group 0 as the shader declares them, by number.
fn bindings(module: &Module) -> Vec<(u32, Binding)> {
    let mut found: Vec<_> = module
        .global_variables
        .iter()
        .filter_map(|(_, variable)| {
            let number = variable.binding.as_ref()?;
            assert_eq!(number.group, 0);
            let binding = match variable.space {
                AddressSpace::Uniform => Binding::Uniform,
                AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => Binding::Write,
                AddressSpace::Storage { .. } => Binding::Read,
                other => panic!("a binding in {other:?}"),
            };
            Some((number.binding, binding))
        })
        .collect();
    found.sort_by_key(|&(number, _)| number);
    found
}

/// Every type whose values are floats or 64 bits wide.
fn foreign_types(module: &Module) -> Vec<String> {
    let scalar = |inner: &TypeInner| inner.scalar();
    module
        .types
        .iter()
        .filter_map(|(_, ty)| scalar(&ty.inner))
        .filter(|s| s.kind == naga::ScalarKind::Float || s.width > 4)
        .map(|s| format!("{s:?}"))
        .collect()
}

#[test]
fn every_shader_validates_without_any_capability() {
    for kernel in sources().iter().chain(&[kernels::DIVIDE, kernels::FOLD]) {
        let module = parse(kernel);
        let entry = &module.entry_points[0];
        assert_eq!((module.entry_points.len(), entry.name.as_str()), (1, "main"), "{}", kernel.name);
        assert_eq!(entry.workgroup_size, [microtome::shaders::GROUP_SIZE, 1, 1], "{}", kernel.name);
    }
}

#[test]
fn every_file_is_part_of_a_kernel() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    let mut files = 0;
    for folder in [root.clone(), root.join("shared")] {
        for entry in std::fs::read_dir(&folder).expect("the shaders' folder") {
            let path = entry.expect("an entry").path();
            if path.extension().is_none_or(|e| e != "wgsl") {
                continue;
            }
            files += 1;
            let text = std::fs::read_to_string(&path).expect("a shader");
            let stem = path.file_stem().and_then(|s| s.to_str()).expect("a name");
            let used = sources().iter().filter(|kernel| kernel.wgsl.contains(&text));
            if folder == root {
                assert_eq!(used.map(|k| k.name).collect::<Vec<_>>(), [stem], "{}", path.display());
            } else {
                assert!(used.count() > 0, "no kernel uses {}", path.display());
            }
        }
    }
    assert_eq!(files, sources().len() + 12);
}

#[test]
fn no_shader_knows_floats_or_64_bit_integers() {
    for kernel in sources() {
        assert_eq!(foreign_types(&parse(kernel)), Vec::<String>::new(), "{}", kernel.name);
        for word in ["f32", "f16", "f64", "i64", "u64", "atomic", "subgroup", "enable"] {
            // The first fills a set and keeps minima, the second sums up: neither depends on an order. The
            // third fills buckets that the next kernel sorts.
            let may = ["weld_insert", "span_count", "span_fill"];
            if word == "atomic" && may.contains(&kernel.name) {
                continue;
            }
            let code = kernel.wgsl.lines().map(|line| line.split("//").next().unwrap_or(""));
            assert!(code.into_iter().all(|line| !line.contains(word)), "{} says {word}", kernel.name);
        }
    }
    let planted = Kernel {
        name: "planted",
        wgsl: "@compute @workgroup_size(1) fn main() { var x = 1.5f; x += 1.0; }",
        bindings: &[],
    };
    assert!(!foreign_types(&parse(&planted)).is_empty(), "a planted float went unseen");
}

#[test]
fn bindings_are_as_registered() {
    for kernel in sources().iter().chain(&[kernels::DIVIDE, kernels::FOLD]) {
        let registered: Vec<_> = (0..).zip(kernel.bindings.iter().copied()).collect();
        assert_eq!(bindings(&parse(kernel)), registered, "{}", kernel.name);
        let arrays = kernel.bindings.iter().filter(|&&b| b != Binding::Uniform).count();
        assert!(arrays <= 8, "{} sees {arrays} arrays; WebGPU promises eight", kernel.name);
    }
}

#[test]
fn uniforms_have_the_layout_of_their_structures() {
    for kernel in sources() {
        assert_eq!(check_layout(&parse(kernel), &layout_of(kernel)), Ok(()), "{}", kernel.name);
    }
}

#[test]
fn a_planted_layout_fault_is_seen() {
    #[repr(C)]
    struct Swapped {
        planes: u32,
        triangles: u32,
        padding: [u32; 2],
    }
    #[repr(C)]
    struct Short {
        triangles: u32,
        planes: u32,
    }
    let kernel = sources().iter().find(|k| k.name == "slice_emit").expect("the kernel");
    let module = parse(kernel);
    assert!(check_layout(&module, &layout!(Swapped, triangles, planes)).is_err());
    assert!(check_layout(&module, &layout!(Short, triangles, planes)).is_err());
}
