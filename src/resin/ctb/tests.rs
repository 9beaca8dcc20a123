//! Hand-made bytes, round trips and damage.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::{Ctb, Version, decode::decode, encode::encode, key, open, quantised};
use crate::mask::{MaskLayer, Panel};
use crate::resin::testing::{Random, info, masks, print, written};
use crate::resin::{Container, ReadError, Totals};
use std::io::{Cursor, Read, Seek, SeekFrom, Write};

const VERSIONS: [Version; 2] = [Version::Three, Version::Four];

const WORDS_1_0: [u32; 10] = [
    0x6810_DBC3,
    0x6E3C_DD92,
    0x7468_DF61,
    0x7A94_E130,
    0x80C0_E2FF,
    0x86EC_E4CE,
    0x8D18_E69D,
    0x9344_E86C,
    0x9970_EA3B,
    0x9F9C_EC0A,
];
const WORDS_12345678_7: [u32; 10] = [
    0x23E7_8638,
    0x785F_EAFB,
    0xCCD8_4FBE,
    0x2150_B481,
    0x75C9_1944,
    0xCA41_7E07,
    0x1EB9_E2CA,
    0x7332_478D,
    0xC7AA_AC50,
    0x1C23_1113,
];

fn mask(runs: &[(u32, u32, u8)]) -> MaskLayer {
    let mut mask = MaskLayer::default();
    runs.iter().for_each(|(start, end, value)| mask.push(*start, *end, *value));
    mask
}

#[test]
fn hand_made_runs_are_read_and_written() {
    for (bytes, pixels, runs) in [
        (&[0x00][..], 1, &[][..]),
        (&[0x7F], 1, &[(0, 1, 255)]),
        (&[0x80, 0x05], 5, &[]),
        (&[0xFF, 0x7F], 127, &[(0, 127, 255)]),
        (&[0xFF, 0x80, 0x80], 128, &[(0, 128, 255)]),
        (&[0xFF, 0xBF, 0xFF], 0x3FFF, &[(0, 0x3FFF, 255)]),
        (&[0xFF, 0xC0, 0x40, 0x00], 0x4000, &[(0, 0x4000, 255)]),
        (&[0xFF, 0xDF, 0xFF, 0xFF], 0x1F_FFFF, &[(0, 0x1F_FFFF, 255)]),
        (&[0xFF, 0xE0, 0x20, 0x00, 0x00], 0x20_0000, &[(0, 0x20_0000, 255)]),
        (&[0xFF, 0xEF, 0xFF, 0xFF, 0xFF], 0xFFF_FFFF, &[(0, 0xFFF_FFFF, 255)]),
        (&[0x80, 0x02, 0x40, 0x81, 0x03, 0x00], 7, &[(2, 3, 129), (3, 6, 3)]),
    ] {
        let mask = mask(runs);
        assert_eq!(decode(bytes, pixels, 0).unwrap(), mask, "{bytes:02x?}");
        assert_eq!(encode(&mask, pixels), bytes, "{bytes:02x?}");
    }
}

#[test]
fn keys_give_the_published_words() {
    // Computed from the formula with other tools.
    for (key, index, words) in [(1, 0, WORDS_1_0), (0x1234_5678, 7, WORDS_12345678_7)] {
        let expected: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
        for length in 0..=40 {
            let mut data = vec![0; length];
            key::apply(key, index, &mut data);
            assert_eq!(data, expected[..length]);
            key::apply(key, index, &mut data);
            assert!(data.iter().all(|b| *b == 0));
        }
    }
}

#[test]
fn every_length_comes_back() {
    let mut lengths: Vec<u32> = (1..300).collect();
    lengths.extend([14, 21].iter().flat_map(|bits| (1u32 << bits) - 2..(1 << bits) + 3));
    lengths.extend([(1 << 28) - 2, (1 << 28) - 1, 1 << 28, (1 << 28) + 1, (1 << 28) + 100, 3 << 28]);
    for length in lengths {
        for value in [3, 127, 255] {
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
    assert!(encode(&MaskLayer::default(), 0).is_empty());
}

#[test]
fn random_masks_come_back_quantised() {
    for seed in 0..300 {
        let mut random = Random(seed);
        let pixels = 1 + random.below(5_000);
        for mask in masks(&mut random, pixels) {
            let read = decode(&encode(&mask, pixels), pixels, 0).unwrap();
            assert_eq!(read, quantised(&mask), "seed {seed}");
            assert_eq!(read, quantised(&read), "seed {seed}: once is enough");
            if mask.runs.iter().all(|r| r.value == 255) {
                assert_eq!(read, mask, "seed {seed}");
            }
        }
    }
    for v in 0..=255u8 {
        let expected = if v >> 1 == 0 { 0 } else { (v >> 1) << 1 | 1 };
        assert_eq!(quantised(&mask(&[(2, 5, v)])), mask(&[(2, 5, expected)]));
    }
    assert_eq!(quantised(&mask(&[(0, 1, 254), (1, 2, 255), (2, 3, 1), (3, 4, 2)])).runs.len(), 2);
}

fn panel(width: u32, height: u32) -> Panel {
    Panel {
        width,
        height,
        pitch_x: 50_000,
        pitch_y: 40_000,
        mirror_x: true,
        mirror_y: false,
        portrait: false,
    }
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

fn f32_at(bytes: &[u8], at: usize) -> f32 {
    f32::from_bits(u32_at(bytes, at))
}

#[test]
fn files_come_back() {
    let print = print(panel(40, 25), 5);
    let layers = masks(&mut Random(5), 40 * 25);
    for version in VERSIONS {
        let ctb = Ctb { version };
        let (bytes, infos) = written(&ctb, &print, &layers);
        assert_eq!(bytes, written(&ctb, &print, &layers).0, "two runs give the same bytes");
        let mut reader = open(Box::new(Cursor::new(bytes))).unwrap();
        let head = reader.head().clone();
        assert_eq!((head.width, head.height, head.layers, head.bottom_layers), (40, 25, 5, 2));
        assert_eq!((head.machine.as_str(), head.display), ("TEST Printer 3", Some([2.0, 1.0])));
        assert_eq!((head.time, head.volume_ml), (Some(1234.0), Some(2.5)));
        for index in [4, 0, 2, 1, 3] {
            let (mask, info) = reader.layer(index).unwrap();
            assert_eq!(mask, quantised(&layers[index as usize]));
            let given = &infos[index as usize];
            assert_eq!((info.index, info.light), (index, given.light));
            assert!((info.z - given.z).abs() < 1e-5 && (info.exposure - given.exposure).abs() < 1e-5);
            if version == Version::Four {
                let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-5, "{a} {b}");
                close(info.motion.lift, given.motion.lift);
                close(info.motion.lift2, given.motion.lift2);
                close(info.motion.retract2_speed, given.motion.retract2_speed);
                close(info.motion.rest_before_lift, given.motion.rest_before_lift);
                close(info.motion.rest_after_retract, given.motion.rest_after_retract);
            } else {
                // The slower speed of two holds for the whole.
                let joined = given.motion.lift + given.motion.lift2;
                assert_eq!((info.motion.lift, info.motion.lift_speed), (joined, 60.0));
                assert_eq!((info.motion.retract_speed, info.motion.rest_after_retract), (50.0, 0.0));
            }
        }
        assert!(matches!(reader.layer(5), Err(ReadError::NoLayer { index: 5, layers: 5 })));
    }
}

#[test]
fn sections_lie_where_the_header_says() {
    let print = print(panel(40, 25), 5);
    let layers = masks(&mut Random(5), 40 * 25);
    for version in VERSIONS {
        let (b, infos) = written(&Ctb { version }, &print, &layers);
        let at = |i: usize| u32_at(&b, i) as usize;
        let four = version == Version::Four;
        assert_eq!((at(0), at(4)), if four { (0x12FD_0106, 4) } else { (0x12FD_0086, 3) });
        assert_eq!([f32_at(&b, 8), f32_at(&b, 12), f32_at(&b, 16)], [2.0, 1.0, 250.0]);
        assert_eq!([f32_at(&b, 0x1C), f32_at(&b, 0x20)], [0.25, 0.05]);
        assert_eq!([f32_at(&b, 0x24), f32_at(&b, 0x28)], [2.3, 30.0]);
        // 2.25 s of rests, 8 mm up at 60 and down at 50 mm/min.
        assert!((f32_at(&b, 0x2C) - if four { 0.0 } else { 2.25 + 8.0 + 9.6 }).abs() < 1e-5);
        assert_eq!([at(0x30), at(0x34), at(0x38), at(0x44)], [2, 40, 25, 5]);
        assert_eq!([at(0x4C), at(0x50), at(0x58), at(0x5C), at(0x6C)], [1234, 1, 60, 1, 76]);
        assert_eq!(b[0x60..0x64], [255, 0, 250, 0]);
        let key = at(0x64) as u32;
        assert!((0x100..0x8000_0000).contains(&key));

        let (large, small, parameters) = (at(0x3C), at(0x48), at(0x54));
        assert_eq!([at(large), at(large + 4), at(large + 8)], [400, 300, large + 32]);
        assert_eq!([at(small), at(small + 4), at(small + 8)], [200, 125, small + 32]);
        assert_eq!([large + 32 + at(large + 12), small + 32 + at(small + 12)], [small, parameters]);
        assert_eq!((f32_at(&b, parameters), f32_at(&b, parameters + 8)), (9.0, 8.0), "whole lifts");
        assert_eq!(f32_at(&b, parameters + 0x14), 2.5);

        let slicer = at(0x68);
        assert_eq!(slicer, parameters + 60);
        let (name, length) = (at(slicer + 0x1C), at(slicer + 0x20));
        assert_eq!((name, &b[name..name + length]), (slicer + 76, &b"TEST Printer 3"[..]));
        assert_eq!([b[slicer + 0x24], b[slicer + 0x27]], [7, if four { 0x40 } else { 0x30 }]);
        assert_eq!(at(slicer + 0x28), 1_700_000_000 / 60);
        assert_eq!(f32_at(&b, slicer + 8), if four { 5.0 } else { 0.0 });
        let table = at(0x40);
        if four {
            let two = at(slicer + 0x40);
            assert_eq!([two, table], [name + length + 320, two + 464]);
            assert_eq!([at(two + 0x48), at(two + 0x4C), at(two + 0x34)], [name + length, 320, 4]);
        } else {
            assert_eq!([at(slicer + 0x40), table], [0, name + length]);
        }
        let mut next = table + 5 * 36;
        for (index, mask) in layers.iter().enumerate() {
            let record = table + index * 36;
            let (data, size) = (at(record + 12), at(record + 16));
            assert_eq!((data, at(record + 20), at(record + 24)), (next + 84, 0, 84));
            assert_eq!(b[record..record + 36], b[data - 84..data - 48], "a copy before the data");
            assert_eq!((at(data - 48), f32_at(&b, data - 4)), (84 + size, f32::from(infos[index].light)));
            let mut plain = encode(mask, 1000);
            key::apply(key, index as u32, &mut plain);
            assert_eq!(b[data..data + size], plain);
            next = data + size;
        }
        assert_eq!(next, b.len());
    }
}

#[test]
fn keys_follow_the_content() {
    let key_of = |print, layers: &[MaskLayer]| u32_at(&written(&Ctb::default(), print, layers).0, 0x64);
    let first = print(panel(40, 25), 5);
    let mut other = first.clone();
    other.exposure = 2.4;
    let (some, others) = (masks(&mut Random(5), 1000), vec![mask(&[(0, 4, 255)]); 5]);
    assert_ne!(key_of(&first, &some), key_of(&other, &some));
    assert_ne!(key_of(&first, &some), key_of(&first, &others));
}

/// All layers, or the first error.
fn all(bytes: &[u8]) -> Result<Vec<MaskLayer>, ReadError> {
    let mut reader = open(Box::new(Cursor::new(bytes.to_vec())))?;
    (0..reader.head().layers).map(|i| Ok(reader.layer(i)?.0)).collect()
}

#[test]
fn truncated_and_corrupt_files_are_refused_or_read() {
    let mut print = print(panel(6, 4), 3);
    // A preview of one colour keeps the file small.
    print.preview = std::sync::Arc::new(crate::resin::Preview { width: 4, height: 3, rgb: vec![99; 36] });
    let layers: Vec<_> = masks(&mut Random(9), 24).into_iter().take(3).collect();
    for version in VERSIONS {
        let (bytes, _) = written(&Ctb { version }, &print, &layers);
        assert!(bytes.len() < 4000, "{}", bytes.len());
        let right: Vec<_> = layers.iter().map(quantised).collect();
        assert_eq!(all(&bytes).unwrap(), right);
        for length in 0..bytes.len() {
            let error = all(&bytes[..length]).unwrap_err();
            assert!(matches!(error, ReadError::Truncated { end, .. } if end == length as u64), "{error}");
        }
        let (mut refused, mut read) = (0, 0);
        for place in 0..bytes.len() {
            for flip in [1, 2, 0x10, 0x40, 0x80, 0xFF] {
                let mut wrong = bytes.clone();
                wrong[place] ^= flip;
                match all(&wrong) {
                    Ok(masks) => {
                        read += 1;
                        // The format has no checksum, so greys may differ; never what is covered.
                        let last = |m: &MaskLayer| m.runs.last().map_or(0, |r| r.end);
                        let sizes = 0x34..0x3C;
                        assert!(masks.iter().all(|m| last(m) <= 24) || sizes.contains(&place));
                    }
                    Err(_) => refused += 1,
                }
            }
        }
        assert!(refused > 300 && read > 300, "{refused} {read}");
    }
}

#[test]
fn foreign_and_absurd_files_are_refused() {
    let print = print(panel(6, 4), 1);
    let (bytes, _) = written(&Ctb::default(), &print, &[mask(&[(1, 5, 255)])]);
    let with = |at: usize, value: u32| {
        let mut wrong = bytes.clone();
        wrong[at..at + 4].copy_from_slice(&value.to_le_bytes());
        all(&wrong).unwrap_err().to_string()
    };
    assert!(with(0, 0x12FD_0107).contains("is no container known here, but an encrypted ctb"));
    assert!(with(0, 0x12FD_0019).contains("cbddlp"));
    assert!(with(0, 1).contains("is no container known here; known are ctb of versions 2 to 5"));
    assert!(with(4, 1).contains("ctb: header, version is 1, expected 2 to 5"));
    assert!(with(0x24, f32::NAN.to_bits()).contains("ctb: header, exposure is NaN"));
    assert!(with(0x44, u32::MAX).contains("within layer table of 4294967295 layers"));
    assert!(with(0x34, u32::MAX).contains("header, size of the image is 4294967295 x 4"));
    assert!(with(0x34, 7).contains("layer 0, number of pixels covered is 24, expected 28"));
    assert!(with(0x38, 2).contains("layer 0, length of the run at byte"));
    let table = u32_at(&bytes, 0x40) as usize;
    assert!(with(table + 16, u32::MAX).contains("within layer 0, data"));
    assert!(with(table + 20, u32::MAX).contains("within layer 0, record before the data"));
    let error = decode(&[0xFF, 0xF0, 0, 0, 0, 0], 9, 2).unwrap_err().to_string();
    assert!(
        error.contains("layer 2, length of the run at byte 0 is 0xf0..., expected below 0xf0"),
        "{error}"
    );
    for cut in [&[0x05, 0xFF][..], &[0x05, 0xFF, 0x80], &[0x05, 0xFF, 0xE0, 0, 0]] {
        let error = decode(cut, 9, 2).unwrap_err().to_string();
        assert!(error.contains("layer 2, last run is cut off at byte 1"), "{error}");
    }
}

/// A file that starts with what is written first and has a hole of 4 GiB before what comes last.
#[derive(Clone, Default)]
struct Sparse {
    start: Vec<u8>,
    behind: Vec<u8>,
    at: u64,
}

const HOLE: u64 = 1 << 32;

impl Write for Sparse {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let (part, at) = match self.at.checked_sub(HOLE) {
            Some(at) => (&mut self.behind, at as usize),
            None => (&mut self.start, self.at as usize),
        };
        part.resize(part.len().max(at + bytes.len()), 0);
        part[at..at + bytes.len()].copy_from_slice(bytes);
        self.at += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Read for Sparse {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        let part = match self.at.checked_sub(HOLE) {
            Some(at) => self.behind.get(at as usize..),
            None => self.start.get(self.at as usize..),
        };
        let count = part.unwrap_or_default().read(bytes)?;
        self.at += count as u64;
        Ok(count)
    }
}

impl Seek for Sparse {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.at = match to {
            SeekFrom::Start(at) => at,
            SeekFrom::End(_) => HOLE + self.behind.len() as u64,
            SeekFrom::Current(step) => self.at.wrapping_add_signed(step),
        };
        Ok(self.at)
    }
}

#[test]
fn layers_behind_4_gib_have_a_page() {
    let print = print(panel(6, 4), 2);
    let layers = [mask(&[(1, 5, 255)]), mask(&[(2, 9, 255)])];
    let mut out = Sparse::default();
    let ctb = Ctb::default();
    let mut sink = super::write::Sink::begin(&mut out, &print, ctb.version).unwrap();
    crate::resin::LayerSink::layer(&mut sink, &info(&print, 0), &encode(&layers[0], 24)).unwrap();
    sink.jump(HOLE);
    crate::resin::LayerSink::layer(&mut sink, &info(&print, 1), &encode(&layers[1], 24)).unwrap();
    crate::resin::LayerSink::finish(Box::new(sink), &Totals::default()).unwrap();
    let table = u32_at(&out.start, 0x40) as usize;
    assert_eq!([u32_at(&out.start, table + 20), u32_at(&out.start, table + 56)], [0, 1]);
    assert_eq!(u32_at(&out.start, table + 48), 84);
    let mut reader = open(Box::new(out)).unwrap();
    assert_eq!(
        [reader.layer(1).unwrap().0, reader.layer(0).unwrap().0],
        [layers[1].clone(), layers[0].clone()]
    );
}

#[test]
fn prints_that_do_not_fit_are_refused() {
    let mut out = Cursor::new(Vec::new());
    assert!(Ctb::default().begin(&mut out, &print(panel(65_536, 65_536), 1)).is_err());
    assert!(Ctb::default().begin(&mut out, &print(panel(5, 5), 0)).is_err());
    let few = print(panel(5, 5), 1);
    let ctb = Ctb::default();
    let mut sink = ctb.begin(&mut out, &few).unwrap();
    sink.layer(&info(&few, 0), &[]).unwrap();
    assert!(sink.layer(&info(&few, 1), &[]).is_err());
    drop(sink);
    assert!(ctb.begin(&mut out, &few).unwrap().finish(&Totals::default()).is_err());
}
