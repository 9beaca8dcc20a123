//! The contract for all other formats.

use crate::contract;
use microtome::resin::{Container, ctb, goo, layer_files, nanodlp, sl1, stack, svg};
use std::io::Cursor;

fn same(grey: u8) -> u8 {
    grey
}

fn zipped(container: &dyn Container, most: usize) {
    let open = |bytes: &[u8]| layer_files::open_zip(Box::new(Cursor::new(bytes.to_vec())));
    contract::round_trip(container, &open, same);
    contract::damage(container, &open, most);
}

#[test]
fn goo() {
    let open = |bytes: &[u8]| goo::open(Box::new(Cursor::new(bytes.to_vec())));
    contract::round_trip(&goo::Goo, &open, same);
    contract::damage(&goo::Goo, &open, 1000);
    contract::counts(&goo::Goo);
}

#[test]
fn ctb() {
    let open = |bytes: &[u8]| ctb::open(Box::new(Cursor::new(bytes.to_vec())));
    for version in [ctb::Version::Three, ctb::Version::Four] {
        let container = ctb::Ctb { version };
        contract::round_trip(&container, &open, ctb::canonical_grey);
        contract::damage(&container, &open, 1000);
        contract::counts(&container);
    }
}

#[test]
fn sl1() {
    zipped(&sl1::Sl1, 500);
}

#[test]
fn nanodlp() {
    zipped(&nanodlp::NanoDlp, 500);
}

#[test]
fn png_stack() {
    zipped(&stack::PngStack, 500);
}

#[test]
fn svg_layers() {
    zipped(&svg::SvgLayers, 500);
}
