#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use super::*;
use crate::mask::{MaskLayer, Panel};
use crate::resin::{Container, LayerInfo, Motion, Preview, Print, ReadError, Totals};
use std::io::Cursor;
use std::sync::Arc;

const PANEL: Panel = Panel {
    width: 70,
    height: 90,
    pitch_x: 19_000,
    pitch_y: 24_000,
    mirror_x: true,
    mirror_y: false,
    portrait: false,
};

fn print(layers: u32) -> Print {
    let motion = Motion {
        lift: 3.0,
        lift_speed: 60.0,
        lift2: 4.5,
        lift2_speed: 180.0,
        retract_speed: 240.0,
        retract2: 3.0,
        retract2_speed: 90.0,
        rest_after_retract: 0.5,
        ..Motion::default()
    };
    Print {
        name: "part".into(),
        date: 0,
        machine: "Anycubic Photon Mono X".into(),
        printer_model: String::new(),
        material: String::new(),
        panel: PANEL,
        build_height: 245.0,
        layers,
        layer_height: 0.05,
        first_layer_height: 0.05,
        exposure: 2.5,
        bottom_exposure: 30.0,
        bottom_layers: 5,
        transition_layers: 3,
        motion,
        bottom_motion: Motion { lift: 6.0, lift_speed: 30.0, ..motion },
        light: 255,
        bottom_light: 255,
        anti_aliasing: 4,
        density: 1.1,
        cost: 0.0,
        config: String::new(),
        preview: Arc::new(Preview { width: 2, height: 2, rgb: [200, 100, 50].repeat(4) }),
    }
}

fn info(index: u32, mask: &MaskLayer) -> LayerInfo {
    let motion = print(0).motion;
    LayerInfo {
        index,
        z: 0.05 * f64::from(index + 1),
        height: 0.05,
        exposure: 2.5,
        motion,
        light: 255,
        lit: mask.lit(),
        area_mm2: 1.0,
    }
}

/// Masks with the borders of all run lengths, black, white, and every grey.
fn masks() -> Vec<MaskLayer> {
    let pixels = PANEL.pixels();
    let mut greys = MaskLayer::default();
    for grey in 1..=255 {
        greys.push(u32::from(grey) * 20, u32::from(grey) * 20 + u32::from(grey % 21), grey);
    }
    let mut all = vec![MaskLayer::default(), greys];
    for (start, end, value) in [
        (0, pixels, 255),
        (0, 1, 255),
        (pixels - 1, pixels, 255),
        (4094, 4095, 255),
        (4095, 4096, 17),
        (0, 4095, 255),
        (1, 4097, 255),
        (5, 5 + 15, 34),
        (5, 5 + 16, 34),
        (5, 5 + 31, 34),
        (3, pixels - 3, 136),
    ] {
        let mut mask = MaskLayer::default();
        mask.push(start, end, value);
        all.push(mask);
    }
    all
}

fn written(extension: &str, masks: &[MaskLayer]) -> Vec<u8> {
    let container = Anycubic::new(extension).unwrap();
    let print = print(masks.len() as u32);
    let mut out = Cursor::new(Vec::new());
    let mut sink = container.begin(&mut out, &print).unwrap();
    for (i, mask) in masks.iter().enumerate() {
        sink.layer(&info(i as u32, mask), &container.encode(mask, &PANEL)).unwrap();
    }
    sink.finish(&Totals { time: 1234.4, volume_ml: 5.5, weight_g: 6.05, cost: 0.25 }).unwrap();
    out.into_inner()
}

#[test]
fn all_versions_read_back() {
    let masks = masks();
    for m in MACHINES.iter().filter(|m| m.writes.is_some()) {
        let bytes = written(m.extension, &masks);
        assert_eq!(bytes, written(m.extension, &masks), "two runs give the same bytes");
        let mut reader = open(Cursor::new(bytes), m.extension).unwrap();
        let head = reader.head().clone();
        assert_eq!((head.width, head.height, head.layers), (70, 90, masks.len() as u32));
        assert_eq!((head.layer_height, head.exposure, head.bottom_exposure), (0.05, 2.5, 30.0));
        assert_eq!((head.bottom_layers, head.time, head.volume_ml), (5, Some(1234.0), Some(5.5)));
        let new = m.writes != Some(1);
        assert_eq!(head.machine, if new { "Photon Mono X" } else { m.name });
        assert_eq!(head.display, new.then_some([1.33, 2.16]));
        for (i, mask) in masks.iter().enumerate() {
            let (read, said) = reader.layer(i as u32).unwrap();
            let kept = canonical(mask);
            assert_eq!(read, kept, "{} layer {i}", m.extension);
            assert_eq!((said.lit, said.height, said.exposure), (kept.lit(), 0.05, 2.5));
            assert_eq!((said.z * 1e6).round(), 5e4 * (i as f64 + 1.0));
            assert_eq!((said.motion.lift, said.motion.lift_speed), (7.5, 60.0));
        }
        let none = reader.layer(masks.len() as u32);
        assert!(matches!(none, Err(ReadError::NoLayer { .. })));
    }
    assert!(
        Anycubic::new("PWMX").is_some() && Anycubic::new("pws").is_none() && Anycubic::new("stl").is_none()
    );
}

#[test]
fn greys_are_rounded_to_the_nearest_level() {
    for grey in 0..=255u8 {
        let kept = canonical_grey(grey);
        assert!(kept.abs_diff(grey) <= 8 && kept.is_multiple_of(17));
        assert_eq!(canonical_grey(kept), kept);
    }
    assert_eq!([0, 8, 9, 255].map(canonical_grey), [0, 0, 17, 255]);
    let mean: f64 = (0..=255u8).map(|g| f64::from(canonical_grey(g)) - f64::from(g)).sum();
    assert!(mean.abs() < 1e-9, "areas keep their size on the average");
}

#[test]
fn runs_are_the_bytes_of_the_format() {
    let mut mask = MaskLayer::default();
    mask.push(3, 5000, 255);
    mask.push(5000, 5018, 0x88);
    let bytes = runs::encode(&mask, 70, 5020);
    let (data, trailer) = bytes.split_at(bytes.len() - runs::TRAILER);
    assert_eq!(data, [0x00, 3, 0xFF, 0xFF, 0xF3, 0x86, 0x8F, 0x83, 0x00, 2]);
    let words: Vec<u32> = trailer.chunks(4).map(|w| u32::from_le_bytes(w.try_into().unwrap())).collect();
    assert_eq!(words, [5015, 0, 0, 69, 71], "lit pixels and their bounds");

    assert_eq!(runs::decode(data, 5020), Ok(canonical(&mask)));
    assert_eq!(runs::decode(data, 5021), Err(runs::Fault::Short(5020)));
    assert_eq!(runs::decode(data, 5019), Err(runs::Fault::Long(5020)));
    let checksum = [data, &[1, 2]].concat();
    assert_eq!(runs::decode(&checksum, 5020), Ok(canonical(&mask)));
    assert_eq!(runs::decode(&[data, &[0; 3]].concat(), 5020), Err(runs::Fault::Rest(3)));
    assert_eq!(runs::decode(&data[..9], 5020), Err(runs::Fault::Short(5018)));
    assert_eq!(runs::decode(&[], 5020), Ok(MaskLayer::default()));
}

#[test]
fn one_bit_planes_add_up() {
    // Four planes of ten pixels: lit 2..8, 3..8, 3..5 and 9..10, none.
    let data = [2, 0x86, 2, 3, 0x85, 2, 3, 0x82, 4, 0x81, 10];
    let mask = bits::decode(&data, 10, 4).unwrap();
    let runs: Vec<_> = mask.runs.iter().map(|r| (r.start, r.end, r.value)).collect();
    assert_eq!(runs, [(2, 3, 63), (3, 5, 191), (5, 8, 127), (9, 10, 63)]);
    let one = bits::decode(&[2, 0x83, 5], 10, 1).unwrap();
    assert_eq!((one.runs.len(), one.runs[0].value, one.lit()), (1, 255, 3));
    assert_eq!(bits::decode(&data[..10], 10, 4), Err(runs::Fault::Short(0)));
    assert_eq!(bits::decode(&data, 9, 4), Err(runs::Fault::Long(10)));
}

#[test]
fn a_photon_s_file_is_read() {
    let mut bytes = written("pw0", &[MaskLayer::default()]);
    // Point the layer at new data: one image of 70 x 90, 100 lit; anti-aliasing 1.
    let mut data = vec![0x80 | 100];
    data.extend([120; 51]);
    data.push(80);
    let table = u32::from_le_bytes(bytes[36..40].try_into().unwrap()) as usize;
    let end = bytes.len() as u32;
    bytes[table + 20..table + 24].copy_from_slice(&end.to_le_bytes());
    bytes[table + 24..table + 28].copy_from_slice(&(data.len() as u32).to_le_bytes());
    bytes[48 + 16 + 40] = 1;
    bytes.extend(data);
    let mut reader = open(Cursor::new(bytes.clone()), "pws").unwrap();
    assert_eq!(reader.head().machine, "Photon S");
    let (mask, _) = reader.layer(0).unwrap();
    assert_eq!((mask.lit(), mask.area()), (100, 100.0));
    bytes[48 + 16 + 40] = 17;
    assert!(matches!(open(Cursor::new(bytes), "pws"), Err(ReadError::Damaged { .. })));
}

#[test]
fn the_writer_wants_as_many_layers_as_announced() {
    let container = Anycubic::new("pwmx").unwrap();
    let print = print(1);
    let mask = MaskLayer::default();
    let encoded = container.encode(&mask, &PANEL);
    let mut out = Cursor::new(Vec::new());
    let sink = container.begin(&mut out, &print).unwrap();
    assert!(sink.finish(&Totals::default()).is_err());
    let mut sink = container.begin(&mut out, &print).unwrap();
    assert!(sink.layer(&info(0, &mask), &[0; 3]).is_err());
    sink.layer(&info(0, &mask), &encoded).unwrap();
    assert!(sink.layer(&info(1, &mask), &encoded).is_err());
}

/// Opens and reads everything: errors are fine, panics are not.
fn read_all(bytes: &[u8], extension: &str) -> Result<u64, ReadError> {
    let mut reader = open(Cursor::new(bytes.to_vec()), extension)?;
    let mut lit = 0;
    for index in 0..reader.head().layers.min(100) {
        lit += reader.layer(index)?.0.lit();
    }
    Ok(lit)
}

#[test]
fn damage_is_an_error_not_a_panic() {
    for extension in ["pw0", "pwmx", "pm5"] {
        // Without the picture, which nothing depends on, to be quick.
        let whole = written(extension, &masks()[..6]);
        let preview = u32::from_le_bytes(whole[28..32].try_into().unwrap()) as usize;
        let skip = preview + 28..preview + 28 + 2 * 224 * 168;
        for length in (0..whole.len()).filter(|i| !skip.contains(i)) {
            assert!(read_all(&whole[..length], extension).is_err(), "{extension} cut at {length}");
        }
        let mut errors = 0;
        for at in (0..whole.len()).filter(|i| !skip.contains(i)) {
            for flip in [0x01, 0x80, 0xFF] {
                let mut bytes = whole.clone();
                bytes[at] ^= flip;
                errors += u32::from(read_all(&bytes, extension).is_err());
            }
        }
        assert!(errors > 200, "{extension}: only {errors} faults were seen");
        assert!(read_all(&whole, extension).is_ok());
    }
}
