//! Hand-made bytes, round trips and damage.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::{Goo, decode::decode, encode::encode, open};
use crate::mask::{MaskLayer, Panel};
use crate::resin::testing::{Random, masks, print, written};
use crate::resin::{Container, Print, ReadError};
use std::io::Cursor;

/// An image around the given chunks.
fn image(chunks: &[u8]) -> Vec<u8> {
    let sum = chunks.iter().fold(0, |s: u8, b| s.wrapping_add(*b));
    [&[0x55], chunks, &[!sum]].concat()
}

fn mask(runs: &[(u32, u32, u8)]) -> MaskLayer {
    let mut mask = MaskLayer::default();
    runs.iter().for_each(|(start, end, value)| mask.push(*start, *end, *value));
    mask
}

#[test]
fn the_specifications_examples_are_read_and_written() {
    for (chunks, pixels, runs) in [
        (&[0x05][..], 5, &[][..]),
        (&[0x1F, 0x80], 2063, &[]),
        (&[0xF1, 0xCC, 0xBB, 0xAA], 0xCCB_BAA1, &[(0, 0xCCB_BAA1, 255)]),
        (&[0x41, 0x50, 0x81], 2, &[(0, 1, 80), (1, 2, 81)]),
        (&[0x43, 0x0A, 0xB2, 0xEE], 241, &[(0, 3, 10), (3, 241, 8)]),
        (&[0x50, 0x10, 0x01], 16, &[(0, 16, 16)]),
        (&[0x7F, 0x80, 1, 2, 3], 0x01_0203F, &[(0, 0x01_0203F, 128)]),
        (&[0x41, 0x0F, 0x01], 2, &[(0, 1, 15)]),
        (&[0x01, 0x8F, 0x01], 3, &[(1, 2, 15)]),
        (&[0x02, 0xC3, 0x04], 9, &[(2, 5, 255)]),
    ] {
        let mask = mask(runs);
        assert_eq!(decode(&image(chunks), pixels, 0).unwrap(), mask, "{chunks:02x?}");
        assert_eq!(encode(&mask, pixels), image(chunks), "{chunks:02x?}");
    }
}

#[test]
fn bytes_other_writers_use_are_read() {
    // Differences over several pixels, of nothing, and empty runs.
    let chunks = [0xB2, 0x03, 0x80, 0x00, 0x9F, 0x02, 0xAF];
    let error = decode(&image(&chunks), 8, 3).unwrap_err().to_string();
    assert!(error.contains("layer 3, difference at byte 1 is 2 from grey 0"), "{error}");
    let chunks = [0x92, 0x03, 0x80, 0x00, 0x9F, 0x02, 0xAF];
    assert_eq!(decode(&image(&chunks), 7, 0).unwrap(), mask(&[(0, 4, 2), (4, 6, 15)]));
}

#[test]
fn every_length_comes_back() {
    let mut lengths: Vec<u32> = (1..300).collect();
    lengths.extend([12, 14, 20].iter().flat_map(|bits| (1u32 << bits) - 2..(1 << bits) + 3));
    lengths.extend([(1 << 28) - 2, (1 << 28) - 1, 1 << 28, (1 << 28) + 1, (1 << 28) + 100, 3 << 28]);
    for length in lengths {
        for value in [1, 9, 15, 16, 128, 254, 255] {
            for (before, after) in [(0, 0), (3, 0), (0, 7)] {
                let pixels = before + length + after;
                let mask = mask(&[(before, before + length, value)]);
                let bytes = encode(&mask, pixels);
                assert_eq!(decode(&bytes, pixels, 0).unwrap(), mask, "{length} of {value}");
                assert!(decode(&bytes, pixels + 1, 0).is_err() && decode(&bytes, pixels - 1, 0).is_err());
            }
        }
    }
    let all = mask(&[(0, u32::MAX, 7)]);
    assert_eq!(decode(&encode(&all, u32::MAX), u32::MAX, 0).unwrap(), all);
    assert!(encode(&MaskLayer::default(), 0).len() == 2);
}

#[test]
fn random_masks_come_back() {
    for seed in 0..300 {
        let mut random = Random(seed);
        let pixels = 1 + random.below(5_000);
        for mask in masks(&mut random, pixels) {
            let bytes = encode(&mask, pixels);
            assert_eq!(decode(&bytes, pixels, 0).unwrap(), mask, "seed {seed}");
        }
    }
}

#[test]
fn damaged_images_are_refused() {
    let right = encode(&mask(&[(3, 40, 255), (40, 41, 200), (41, 60, 190), (70, 90, 77)]), 100);
    assert!(decode(&right, 100, 0).is_ok());
    for length in 0..right.len() {
        assert!(decode(&right[..length], 100, 0).is_err());
    }
    for place in 0..right.len() {
        for flip in 1..=255 {
            let mut wrong = right.clone();
            wrong[place] ^= flip;
            assert!(decode(&wrong, 100, 0).is_err(), "the checksum sees every single byte");
            // With the checksum put right, what is accepted still covers all pixels.
            let last = wrong.len() - 1;
            let wrong = image(&wrong[1..last]);
            if let Ok(mask) = decode(&wrong, 100, 0) {
                assert!(mask.runs.last().is_none_or(|r| r.end <= 100));
            }
        }
    }
    for chunks in [&[0x41][..], &[0x51, 0x05], &[0x10], &[0xF0, 1, 2], &[0x90]] {
        let error = decode(&image(chunks), 100, 12).unwrap_err().to_string();
        assert!(error.starts_with("goo: layer 12, last chunk is cut off at byte 1"), "{error}");
    }
    let error = decode(&image(&[0x05, 0xC6]), 10, 12).unwrap_err().to_string();
    assert!(
        error.contains("length of the chunk at byte 2 is 6, expected at most the 5 pixels left"),
        "{error}"
    );
    let error = decode(&image(&[0x05]), 10, 12).unwrap_err().to_string();
    assert!(error.contains("number of pixels covered is 5, expected 10"), "{error}");
}

fn panel(width: u32, height: u32) -> Panel {
    Panel {
        width,
        height,
        pitch_x: 19_000,
        pitch_y: 24_000,
        mirror_x: true,
        mirror_y: false,
        portrait: false,
    }
}

#[test]
fn files_come_back() {
    let print = print(panel(37, 21), 5);
    let layers = masks(&mut Random(5), 37 * 21);
    let (bytes, infos) = written(&Goo, &print, &layers);
    assert_eq!(bytes, written(&Goo, &print, &layers).0, "two runs give the same bytes");
    let at = |start: usize, end: usize| &bytes[start..end];
    assert_eq!(at(0, 12), b"V3.0\x07\0\0\0DLP\0");
    assert_eq!(at(68, 92), b"2023-11-14 22:13:20\0\0\0\0\0");
    assert_eq!(at(92, 106), b"TEST Printer 3");
    assert_eq!([at(27_106, 27_108), at(195_308, 195_310)], [b"\r\n"; 2]);
    assert_eq!(at(195_310, 195_320), [0, 0, 0, 5, 0, 37, 0, 21, 1, 0]);
    assert_eq!(at(195_320, 195_324), 0.703f32.to_be_bytes());
    assert_eq!(at(195_340, 195_341), [1]);
    assert_eq!(at(195_369, 195_377), [&30f32.to_be_bytes()[..], &[0, 0, 0, 2]].concat());
    assert_eq!(at(195_445, 195_450), [1, 0, 0, 0x04, 0xD2], "advance mode and time");
    assert_eq!(at(195_450, 195_454), 2500f32.to_be_bytes());
    assert_eq!(at(195_470, 195_477), [0, 2, 0xFB, 0x95, 1, 0, 1]);
    assert_eq!(at(195_477 + 64, 195_477 + 66), b"\r\n");
    assert_eq!(at(bytes.len() - 11, bytes.len()), b"\0\0\0\x07\0\0\0DLP\0");
    for (start, end) in [(194, 27_106), (27_108, 195_308)] {
        assert!(at(start, end).iter().any(|b| *b != 0), "previews are not black");
    }

    let mut reader = open(Box::new(Cursor::new(bytes))).unwrap();
    let head = reader.head().clone();
    assert_eq!((head.width, head.height, head.layers, head.bottom_layers), (37, 21, 5, 2));
    assert_eq!((head.machine.as_str(), head.mirror), ("TEST Printer 3", Some([true, false])));
    assert_eq!((head.time, head.volume_ml, head.exposure), (Some(1234.0), Some(2.5), 2.3));
    for index in [4, 0, 2, 1, 3, 4] {
        let (mask, info) = reader.layer(index).unwrap();
        assert_eq!(mask, layers[index as usize]);
        let given = &infos[index as usize];
        assert_eq!((info.index, info.light), (index, given.light));
        for (a, b) in [
            (info.z, given.z),
            (info.exposure, given.exposure),
            (info.motion.lift, given.motion.lift),
            (info.motion.retract2_speed, given.motion.retract2_speed),
            (info.motion.rest_after_retract, given.motion.rest_after_retract),
            (info.motion.retract(), given.motion.retract()),
        ] {
            assert!((a - b).abs() < 1e-5, "{a} {b}");
        }
    }
    assert!(matches!(reader.layer(5), Err(ReadError::NoLayer { index: 5, layers: 5 })));
}

#[test]
fn the_header_rules_where_layers_follow_it() {
    let mut print = print(panel(8, 8), 5);
    print.transition_layers = 0;
    let advance = |print: &Print| written(&Goo, print, &vec![MaskLayer::default(); 5]).0[195_445];
    assert_eq!(advance(&print), 0);
    print.transition_layers = 1;
    assert_eq!(advance(&print), 1, "an exposure between bottom and normal");
    print.transition_layers = 0;
    print.first_layer_height = 0.08;
    assert_eq!(advance(&print), 1, "another first layer");
}

#[test]
fn truncated_and_corrupt_files_are_refused_or_equal() {
    let print = print(panel(6, 4), 3);
    let layers: Vec<_> = masks(&mut Random(9), 24).into_iter().take(3).collect();
    let (bytes, _) = written(&Goo, &print, &layers);
    // All layers, or the first error.
    let all = |bytes: &[u8]| {
        let mut reader = open(Box::new(Cursor::new(bytes.to_vec())))?;
        (0..reader.head().layers).map(|i| Ok(reader.layer(i)?.0)).collect::<Result<Vec<_>, ReadError>>()
    };
    assert_eq!(all(&bytes).unwrap(), layers);
    let head = 195_310;
    for length in (0..head).step_by(9973).chain(head..bytes.len()) {
        let error = all(&bytes[..length]).unwrap_err();
        assert!(matches!(error, ReadError::Truncated { end, .. } if end == length as u64), "{error}");
    }
    for place in (0..12).chain(head..bytes.len()) {
        for flip in [1, 2, 0x10, 0x40, 0x80, 0xFF] {
            let mut wrong = bytes.clone();
            wrong[place] ^= flip;
            if let Ok(masks) = all(&wrong) {
                let size = |at: usize| place >= at && place < at + 4;
                assert!(masks == layers || size(head) || size(head + 4), "byte {place} ^ {flip}");
            }
        }
    }
    let error = all(b"V3.0").unwrap_err().to_string();
    assert!(error.contains("ends at byte 4 within header"), "{error}");
    let mut nan = bytes.clone();
    nan[195_336..195_340].copy_from_slice(&f32::NAN.to_be_bytes());
    let error = all(&nan).unwrap_err().to_string();
    assert!(error.contains("header, exposure is NaN"), "{error}");
}

#[test]
fn prints_that_do_not_fit_are_refused() {
    let mut out = Cursor::new(Vec::new());
    let wide = print(panel(65_536, 1), 1);
    let error = Goo.begin(&mut out, &wide).err().unwrap().to_string();
    assert_eq!(error, "the panel's width is 65536; a goo file holds at most 65535");
    assert!(Goo.begin(&mut out, &print(panel(5, 0), 1)).is_err());
    let mut nan = print(panel(5, 5), 1);
    nan.exposure = f64::NAN;
    assert!(Goo.begin(&mut out, &nan).err().unwrap().to_string().starts_with("exposure is NaN"));
    let few = print(panel(5, 5), 2);
    assert!(Goo.begin(&mut out, &few).unwrap().finish(&Default::default()).is_err());
}
