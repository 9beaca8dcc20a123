#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
use super::*;
use crate::mask::Run;

const PLACE: Place<'static> = Place { format: "test", name: "0.png" };

fn panel(width: u32, height: u32) -> Panel {
    Panel { width, height, pitch_x: 1, pitch_y: 1, mirror_x: false, mirror_y: false, portrait: false }
}

fn random(state: &mut u64) -> u32 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state >> 20) as u32
}

fn pixels(mask: &MaskLayer, count: u32) -> Vec<u8> {
    mask.lengths(count).flat_map(|(n, v)| std::iter::repeat_n(v, n as usize)).collect()
}

/// Pixels as the png crate reads them.
fn read_back(bytes: &[u8]) -> (u32, u32, Vec<u8>) {
    let mut options = DecodeOptions::default();
    options.set_ignore_adler32(false);
    let mut reader = Decoder::new_with_options(Cursor::new(bytes), options).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    reader.finish().unwrap();
    assert_eq!((info.color_type, info.bit_depth), (ColorType::Grayscale, BitDepth::Eight));
    (info.width, info.height, pixels)
}

fn check(mask: &MaskLayer, width: u32, height: u32) {
    let bytes = encode(mask, &panel(width, height));
    let expected = pixels(mask, width * height);
    assert_eq!(read_back(&bytes), (width, height, expected), "{width} x {height}");
    assert_eq!(&decode(&bytes, width, height, Packing::Grey, PLACE).unwrap(), mask);
}

#[test]
fn random_masks_come_back() {
    for seed in 1..=300u64 {
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let (width, height) = (1 + random(&mut state) % 700, 1 + random(&mut state) % 40);
        let spread = [3, 40, 900, 20_000][seed as usize % 4];
        let greys = [1, 3, 255][seed as usize % 3];
        let mut mask = MaskLayer::default();
        let mut at = random(&mut state) % spread;
        while at < width * height {
            let end = (at + 1 + random(&mut state) % spread).min(width * height);
            let value = 255 - (random(&mut state) % greys) as u8;
            mask.push(at, end, value);
            at = end + random(&mut state) % 3 * (random(&mut state) % spread);
        }
        check(&mask, width, height);
    }
}

#[test]
fn black_and_lit_panels_come_back() {
    for (width, height) in [(1, 1), (1, 300), (258, 2), (259, 1), (1032, 100)] {
        check(&MaskLayer::default(), width, height);
        for value in [255, 1, 128] {
            let run = Run { start: 0, end: width * height, value };
            check(&MaskLayer { runs: vec![run] }, width, height);
        }
    }
    let black = encode(&MaskLayer::default(), &panel(11520, 5120));
    assert!(black.len() < 57_400, "{} bytes are above deflate's bound", black.len());
}

#[test]
fn every_length_of_a_run_comes_back() {
    for length in 1..=800 {
        let mut mask = MaskLayer::default();
        mask.push(5, 5 + length, 200);
        check(&mask, 1000, 2);
    }
}

#[test]
fn runs_beyond_the_panel_are_left_out() {
    let runs = vec![Run { start: 3, end: 99, value: 7 }, Run { start: 120, end: 130, value: 7 }];
    let bytes = encode(&MaskLayer { runs }, &panel(5, 2));
    let kept = MaskLayer { runs: vec![Run { start: 3, end: 10, value: 7 }] };
    assert_eq!(decode(&bytes, 5, 2, Packing::Grey, PLACE).unwrap(), kept);
}

#[test]
fn long_streams_are_split() {
    let mut mask = MaskLayer::default();
    (0..300).for_each(|i| mask.push(7 * i, 7 * i + 3, (i % 255) as u8 + 1));
    let mut bytes = encode(&mask, &panel(300, 9));
    let end = bytes.split_off(bytes.len() - 12);
    split(&mut bytes, 33, 100);
    bytes.extend_from_slice(&end);
    assert!(bytes.windows(4).filter(|w| w == b"IDAT").count() > 2);
    assert_eq!(decode(&bytes, 300, 9, Packing::Grey, PLACE).unwrap(), mask);
}

#[test]
fn a_changed_byte_is_noticed() {
    let mut mask = MaskLayer::default();
    mask.push(10, 2000, 255);
    mask.push(2100, 2101, 17);
    let good = encode(&mask, &panel(100, 40));
    for at in 0..good.len() {
        let mut bad = good.clone();
        bad[at] ^= 0x40;
        // Nothing is after the end's own name; every other byte is under a check sum or the signature.
        let read = decode(&bad, 100, 40, Packing::Grey, PLACE);
        assert!(read.is_err() || read.unwrap() == mask, "byte {at}");
    }
    for end in 0..good.len() {
        let read = decode(&good[..end], 100, 40, Packing::Grey, PLACE);
        assert!(read.is_err() || end >= good.len() - 12, "cut at {end}");
    }
}

#[test]
fn other_kinds_of_pictures_are_refused() {
    let write = |color, depth, width: u32, data: &[u8]| {
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, width, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        out
    };
    let grey = |bytes: &[u8], width| decode(bytes, width, 1, Packing::Grey, PLACE).map_err(|e| e.to_string());
    let bits = write(ColorType::Grayscale, BitDepth::One, 4, &[0b0110_0000]);
    assert_eq!(grey(&bits, 4).unwrap().runs, [Run { start: 1, end: 3, value: 255 }]);
    assert!(grey(&bits, 5).unwrap_err().contains("4 x 1, expected 5 x 1"));
    let rgb = write(ColorType::Rgb, BitDepth::Eight, 1, &[0, 9, 9]);
    assert!(grey(&rgb, 1).unwrap_err().contains("Rgb"));
    let three = decode(&rgb, 3, 1, Packing::GreyOrThree, PLACE).unwrap();
    assert_eq!(three.runs, [Run { start: 1, end: 3, value: 9 }]);
    let two = decode(&rgb, 2, 1, Packing::GreyOrThree, PLACE).unwrap();
    assert_eq!(two.runs, [Run { start: 1, end: 2, value: 9 }]);
    assert!(grey(&write(ColorType::Grayscale, BitDepth::Sixteen, 1, &[0, 9]), 1).is_err());
    assert!(grey(&write(ColorType::GrayscaleAlpha, BitDepth::Eight, 1, &[0, 9]), 1).is_err());
}

#[test]
fn previews_are_pictures_in_colours() {
    let preview = Preview { width: 2, height: 1, rgb: vec![1, 2, 3, 4, 5, 6] };
    let bytes = encode_preview(&preview, 4, 2).unwrap();
    assert_eq!(size(&bytes, PLACE).unwrap(), [4, 2]);
    assert!(encode_rgb(&Preview { width: 2, height: 2, rgb: vec![0; 6] }).is_err());
}
