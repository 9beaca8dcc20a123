//! What the tests of all containers with one file per layer share.

use microtome::mask::{MaskLayer, Panel};
use microtome::resin::layer_files::open_zip;
use microtome::resin::{Container, LayerInfo, LayerSink, Motion, Preview, Print, Reader, Totals};
use std::io::Cursor;
use std::sync::Arc;

pub const TOTALS: Totals = Totals { time: 1234.5, volume_ml: 6.75, weight_g: 7.5, cost: 0.5 };

pub fn print(layers: u32) -> Print {
    let motion = Motion { lift: 5.0, lift_speed: 60.0, retract_speed: 150.0, ..Motion::default() };
    Print {
        name: "part_7".to_owned(),
        date: 1_700_000_001,
        machine: "Some Printer".to_owned(),
        printer_model: "SL1S".to_owned(),
        material: "Grey = \"good\" & <cheap>".to_owned(),
        panel: Panel {
            width: 61,
            height: 43,
            pitch_x: 19_000,
            pitch_y: 24_000,
            mirror_x: true,
            mirror_y: false,
            portrait: false,
        },
        build_height: 150.0,
        layers,
        layer_height: 0.05,
        first_layer_height: 0.1,
        exposure: 2.5,
        bottom_exposure: 30.0,
        bottom_layers: 3,
        transition_layers: 2,
        motion,
        bottom_motion: motion,
        light: 255,
        bottom_light: 255,
        anti_aliasing: 4,
        density: 1.1,
        cost: 30.0,
        config: "absolute_correction = 0\narea_fill = 35%\nfaded_layers = 0\n".to_owned(),
        preview: Arc::new(Preview { width: 3, height: 2, rgb: (0..18).collect() }),
    }
}

fn random(state: &mut u64) -> u32 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state >> 20) as u32
}

/// Black, lit, one pixel, two greys side by side over a row's end, then random ones.
pub fn masks(panel: &Panel, count: usize, seed: u64) -> Vec<MaskLayer> {
    let pixels = panel.pixels();
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut masks = vec![MaskLayer::default(); count];
    for (index, mask) in masks.iter_mut().enumerate() {
        match index {
            0 => {}
            1 => mask.push(0, pixels, 255),
            2 => mask.push(pixels - 1, pixels, 1),
            3 => {
                mask.push(panel.width - 3, panel.width, 100);
                mask.push(panel.width, (panel.width * 3 + 2).min(pixels), 101);
            }
            _ => {
                let spread = [2, 20, 200][index % 3];
                let mut at = random(&mut state) % spread;
                while at < pixels {
                    let end = (at + 1 + random(&mut state) % spread).min(pixels);
                    let grey = random(&mut state);
                    let value = if grey < u32::MAX / 3 { grey as u8 } else { 255 };
                    mask.push(at, end, value);
                    at = end + random(&mut state) % 3 * (random(&mut state) % spread);
                }
            }
        }
    }
    masks
}

/// What is told of a layer.
pub fn info(print: &Print, mask: &MaskLayer, index: u32) -> LayerInfo {
    LayerInfo {
        index,
        z: print.first_layer_height + f64::from(index) * print.layer_height,
        height: if index == 0 { print.first_layer_height } else { print.layer_height },
        exposure: if index < 3 { 30.0 } else { 2.5 },
        motion: print.motion,
        light: 255,
        lit: mask.lit(),
        area_mm2: mask.area() * print.panel.pixel_mm2(),
    }
}

pub fn fill(
    container: &dyn Container,
    mut sink: Box<dyn LayerSink + '_>,
    print: &Print,
    masks: &[MaskLayer],
) {
    for (index, mask) in masks.iter().enumerate() {
        sink.layer(&info(print, mask, index as u32), &container.encode(mask, &print.panel)).unwrap();
    }
    sink.finish(&TOTALS).unwrap();
}

pub fn write(container: &dyn Container, print: &Print, masks: &[MaskLayer]) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let sink = container.begin(&mut out, print).unwrap();
    fill(container, sink, print, masks);
    out.into_inner()
}

pub fn open(bytes: Vec<u8>) -> Result<Box<dyn Reader>, microtome::resin::ReadError> {
    open_zip(Box::new(Cursor::new(bytes)))
}

/// Writes and reads several sizes of panel; two runs give the same bytes.
pub fn round_trip(container: &dyn Container) {
    for (seed, (width, height)) in [(61, 43), (1, 1), (258, 3), (7, 129)].into_iter().enumerate() {
        let mut print = print(9);
        (print.panel.width, print.panel.height) = (width, height);
        let masks =
            if width == 1 { vec![MaskLayer::default(); 9] } else { masks(&print.panel, 9, seed as u64) };
        let bytes = write(container, &print, &masks);
        assert_eq!(bytes, write(container, &print, &masks), "two runs differ");
        let mut reader = open(bytes).unwrap();
        let head = reader.head().clone();
        assert_eq!((head.width, head.height, head.layers), (width, height, 9));
        assert_eq!(head.format, container.name());
        for index in (0..9).rev() {
            let (mask, info) = reader.layer(index).unwrap();
            assert_eq!(mask, masks[index as usize], "layer {index} of seed {seed}");
            assert_eq!(info.index, index);
        }
        let missing = reader.layer(9).unwrap_err().to_string();
        assert!(missing.contains("no layer 9"), "{missing}");
    }
}

/// Reads all that can be read; never more than errors.
fn read_all(bytes: Vec<u8>) -> Result<Vec<MaskLayer>, String> {
    let mut reader = open(bytes).map_err(|e| e.to_string())?;
    (0..reader.head().layers.min(100)).map(|i| Ok(reader.layer(i).map_err(|e| e.to_string())?.0)).collect()
}

/// Cuts and changes a small file everywhere: errors of one line, or the right masks.
pub fn damage(container: &dyn Container) {
    let mut print = print(5);
    print.preview = Arc::new(Preview { width: 0, height: 0, rgb: Vec::new() });
    let masks = masks(&print.panel, 5, 3);
    let good = write(container, &print, &masks);
    assert_eq!(read_all(good.clone()).unwrap(), masks);
    for end in (0..good.len()).step_by(good.len() / 150 + 1) {
        let error = read_all(good[..end].to_vec()).expect_err("a truncated file is not whole");
        assert!(!error.contains('\n') && error.len() < 400, "{error}");
    }
    let mut state = 77u64;
    let mut wrong = 0;
    for _ in 0..600 {
        let mut bad = good.clone();
        let at = random(&mut state) as usize % bad.len();
        bad[at] ^= 1 << (random(&mut state) % 8);
        match read_all(bad) {
            Ok(read) => assert_eq!(read, masks, "byte {at} changes a mask unseen"),
            Err(error) => {
                wrong += 1;
                assert!(!error.contains('\n') && error.len() < 600, "{error}");
            }
        }
    }
    assert!(wrong > 50, "only {wrong} changes were noticed");
}

/// The members of an archive: names and bytes.
pub fn members(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
    let mut zip = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    (0..zip.len())
        .map(|i| {
            let mut file = zip.by_index(i).unwrap();
            let mut bytes = Vec::new();
            std::io::Read::read_to_end(&mut file, &mut bytes).unwrap();
            (file.name().unwrap().into_owned(), bytes)
        })
        .collect()
}

/// An archive of other members.
pub fn archive(members: &[(String, Vec<u8>)]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in members {
        zip.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        std::io::Write::write_all(&mut zip, bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// Replaces text in a member, or removes the member, and gives the error of opening what results.
pub fn error_after(bytes: &[u8], member: &str, change: Option<(&str, &str)>) -> String {
    let mut all = members(bytes);
    let at = all.iter().position(|(name, _)| name == member).expect("the member is there");
    match change {
        None => drop(all.remove(at)),
        Some((from, to)) => {
            let text = String::from_utf8(all[at].1.clone()).unwrap();
            assert!(text.contains(from), "{text}");
            all[at].1 = text.replacen(from, to, 1).into_bytes();
        }
    }
    read_all(archive(&all)).expect_err("the change is noticed")
}
