//! What every container must do, written once.
//!
//! Everything goes through the public interface: a container writes into memory, a reader opens the bytes.

use microtome::mask::{MaskLayer, Panel};
use microtome::resin::{Container, LayerInfo, Motion, Preview, Print, ReadError, Reader, Totals};
use std::io::Cursor;
use std::sync::Arc;

/// Opens a file's bytes.
pub type Open<'a> = &'a dyn Fn(&[u8]) -> Result<Box<dyn Reader>, ReadError>;

/// The grey that a format keeps for a grey; the identity where it keeps all.
pub type Kept = fn(u8) -> u8;

/// A small panel whose rows are no multiple of eight.
pub fn panel() -> Panel {
    Panel {
        width: 61,
        height: 47,
        pitch_x: 19_000,
        pitch_y: 24_000,
        mirror_x: true,
        mirror_y: false,
        portrait: false,
    }
}

/// A print on [`panel`], with two-stage lifts, transition layers and a picture.
pub fn print(layers: u32) -> Print {
    let motion = Motion {
        lift: 3.0,
        lift_speed: 60.0,
        lift2: 4.0,
        lift2_speed: 180.0,
        retract_speed: 240.0,
        retract2: 3.0,
        retract2_speed: 90.0,
        rest_before_lift: 0.25,
        rest_after_lift: 0.5,
        rest_after_retract: 1.0,
    };
    let rgb = (0..40u32 * 30).flat_map(|i| [(i % 40 * 6) as u8, (i / 40 * 8) as u8, 90]).collect();
    Print {
        name: "part-1".into(),
        date: 1_700_000_000,
        machine: "Some Machine 12K".into(),
        printer_model: "SL1S".into(),
        material: "Some Resin".into(),
        panel: panel(),
        build_height: 200.0,
        layers,
        layer_height: 0.05,
        first_layer_height: 0.06,
        exposure: 2.5,
        bottom_exposure: 30.0,
        bottom_layers: 2,
        transition_layers: 2,
        motion,
        bottom_motion: Motion { lift: 5.0, lift_speed: 40.0, ..motion },
        light: 255,
        bottom_light: 250,
        anti_aliasing: 4,
        density: 1.1,
        cost: 30.0,
        config: "absolute_correction = 0\nlayer_height = 0.05\n".into(),
        preview: Arc::new(Preview { width: 40, height: 30, rgb }),
    }
}

/// What is said of layer `index` of `print`.
pub fn info(print: &Print, index: u32, mask: &MaskLayer) -> LayerInfo {
    let bottom = index < print.bottom_layers;
    LayerInfo {
        index,
        z: print.first_layer_height + print.layer_height * f64::from(index),
        height: if index == 0 { print.first_layer_height } else { print.layer_height },
        exposure: if bottom { print.bottom_exposure } else { print.exposure },
        motion: if bottom { print.bottom_motion } else { print.motion },
        light: if bottom { print.bottom_light } else { print.light },
        lit: mask.lit(),
        area_mm2: mask.area() * print.panel.pixel_mm2(),
    }
}

/// What is known at the end.
pub const TOTALS: Totals = Totals { time: 4321.0, volume_ml: 1.5, weight_g: 1.65, cost: 0.05 };

/// A small generator of numbers (Marsaglia's xorshift); the same seed gives the same masks.
pub struct Random(pub u64);

impl Random {
    /// A number below `n`.
    pub fn below(&mut self, n: u32) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 32) as u32) % n.max(1)
    }
}

/// Masks that stress run-length coders: black, white, first and last pixel, chequers, every grey, runs over
/// row ends, runs of many lengths, and `random` seeded ones, binary and grey.
pub fn masks(panel: &Panel, random: u32, seed: u64) -> Vec<MaskLayer> {
    let pixels = panel.pixels();
    let of = |runs: &[(u32, u32, u8)]| {
        let mut mask = MaskLayer::default();
        for &(start, end, value) in runs {
            mask.push(start, end.min(pixels), value);
        }
        mask
    };
    let w = panel.width;
    let chequers: Vec<_> = (0..pixels / 2).map(|i| (2 * i, 2 * i + 1, 255)).collect();
    let greys: Vec<_> = (0..255).map(|i| (3 * i, 3 * i + 2, (i + 1) as u8)).collect();
    let ramp: Vec<_> = (0..255).map(|i| (5 * i, 5 * i + 5, (255 - i) as u8)).collect();
    let lengths: Vec<_> = (1..60).map(|i| (i * (i + 1), i * (i + 2), 255)).collect();
    let mut all = vec![
        of(&[]),
        of(&[(0, pixels, 255)]),
        of(&[(0, 1, 255)]),
        of(&[(pixels - 1, pixels, 255)]),
        of(&[(w - 1, w + 1, 255), (3 * w, 5 * w, 255)]),
        of(&[(0, pixels, 128)]),
        of(&[(1, pixels - 1, 1)]),
        of(&chequers),
        of(&greys),
        of(&ramp),
        of(&lengths),
    ];
    let mut random_numbers = Random(seed | 1);
    for i in 0..random {
        let longest = 1 + random_numbers.below(if i % 3 == 0 { 8 } else { pixels / 4 });
        let (mut mask, mut at) = (MaskLayer::default(), 0);
        while at < pixels {
            let end = (at + 1 + random_numbers.below(longest)).min(pixels);
            let value = if i % 2 == 0 {
                255 * (random_numbers.below(2) as u8)
            } else {
                random_numbers.below(256) as u8
            };
            mask.push(at, end, value);
            at = end;
        }
        all.push(mask);
    }
    // Equal layers, which may share their data.
    all.push(all[all.len() - 1].clone());
    all.push(of(&lengths));
    all
}

/// The mask that a reader should get.
pub fn kept(mask: &MaskLayer, keep: Kept) -> MaskLayer {
    let mut out = MaskLayer::default();
    for r in &mask.runs {
        out.push(r.start, r.end, keep(r.value));
    }
    out
}

/// A whole file.
pub fn file(container: &dyn Container, print: &Print, masks: &[MaskLayer]) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let mut sink = container.begin(&mut out, print).unwrap();
    for (index, mask) in masks.iter().enumerate() {
        let encoded = container.encode(mask, &print.panel);
        assert_eq!(encoded, container.encode(mask, &print.panel), "encoding is a function of the mask");
        sink.layer(&info(print, index as u32, mask), &encoded).unwrap();
    }
    sink.finish(&TOTALS).unwrap();
    out.into_inner()
}

/// Masks are read back equal (greys as the format keeps them), forwards and backwards; the head says what
/// was written; two runs give the same bytes; a layer too many is an error.
pub fn round_trip(container: &dyn Container, open: Open<'_>, keep: Kept) {
    let name = container.name();
    for seed in [1, 0x9E37_79B9_7F4A_7C15] {
        let masks = masks(&panel(), 24, seed);
        let print = print(masks.len() as u32);
        let bytes = file(container, &print, &masks);
        assert!(bytes == file(container, &print, &masks), "{name}: two runs give the same bytes");
        let mut reader = open(&bytes).unwrap();

        let head = reader.head().clone();
        assert_eq!((head.width, head.height, head.layers), (61, 47, masks.len() as u32), "{name}");
        let near = |a: f64, b: f64| (a - b).abs() < 1e-5;
        assert!(near(head.layer_height, 0.05), "{name}: {head:?}");
        for (said, wrote) in [(head.exposure, 2.5), (head.bottom_exposure, 30.0)] {
            // 0 = the format has no place for it.
            assert!(said == 0.0 || near(said, wrote), "{name}: {head:?}");
        }
        assert!(head.time.is_none_or(|t| (t - TOTALS.time).abs() <= 1.0), "{name}: {head:?}");
        assert!(head.volume_ml.is_none_or(|v| near(v, TOTALS.volume_ml)), "{name}: {head:?}");
        if let Some([width, height]) = head.display {
            assert!((width - 1.159).abs() < 0.01 && (height - 1.128).abs() < 0.01, "{name}: {head:?}");
        }

        let count = masks.len() as u32;
        for index in (0..count).chain((0..count).rev()) {
            let (mask, said) = reader.layer(index).unwrap();
            let expected = kept(&masks[index as usize], keep);
            assert_eq!(mask, expected, "{name}, seed {seed}, layer {index}");
            assert!(said.lit == 0 || said.lit == expected.lit() || said.lit == masks[index as usize].lit());
            // Some formats have one thickness for all layers, or none.
            let thicknesses = [0.0, print.layer_height, info(&print, index, &mask).height];
            assert!(thicknesses.iter().any(|t| near(said.height, *t)), "{name}: {said:?}");
        }
        assert!(matches!(reader.layer(count), Err(ReadError::NoLayer { .. })), "{name}");
        // The comparison above sees one pixel.
        let mut other = masks[1].clone();
        other.runs[0].end -= 1;
        assert_ne!(reader.layer(1).unwrap().0, kept(&other, keep));
    }
}

/// Reads all layers; the sum of lit pixels, or the first error.
pub fn read_all(open: Open<'_>, bytes: &[u8]) -> Result<u64, ReadError> {
    let mut reader = open(bytes)?;
    // A damaged count may be huge where the format does not hold it against the length of the file.
    let layers = reader.head().layers.min(1000);
    let (mut lit, mut first) = (0, None);
    for index in 0..layers {
        match reader.layer(index) {
            Ok((mask, _)) => lit += mask.lit(),
            // Other layers stay readable, or fail on their own.
            Err(e) => drop(first.get_or_insert(e)),
        }
    }
    first.map_or(Ok(lit), Err)
}

/// Bytes of a file that are taken away or changed, spread evenly, and all of the first and last 300.
fn places(length: usize, most: usize) -> impl Iterator<Item = usize> {
    let step = (length / most.max(1)).max(1);
    (0..length).filter(move |i| *i < 300 || i + 300 >= length || i % step == 0)
}

/// Files cut off anywhere are errors; files with any byte changed give an error or masks, and never a panic.
/// `most` bounds the number of places tried.
pub fn damage(container: &dyn Container, open: Open<'_>, most: usize) {
    let name = container.name();
    let masks = masks(&panel(), 2, 7);
    let print = print(masks.len() as u32);
    let whole = file(container, &print, &masks);
    let lit = read_all(open, &whole).unwrap();
    for length in places(whole.len(), most) {
        // A file may end in something that nothing depends on; its masks must then be whole.
        if let Ok(found) = read_all(open, &whole[..length]) {
            assert_eq!(found, lit, "{name}: cut off at {length} of {} without an error", whole.len());
            assert!(length * 10 > whole.len() * 9, "{name}: cut off at {length} of {}", whole.len());
        }
    }
    let (mut errors, mut tried) = (0, 0);
    for place in places(whole.len(), most) {
        for flip in [0x01, 0x80, 0xFF] {
            let mut bytes = whole.clone();
            bytes[place] ^= flip;
            tried += 1;
            match read_all(open, &bytes) {
                Ok(_) => {}
                Err(e) => {
                    errors += 1;
                    assert!(
                        !e.to_string().is_empty() && !e.to_string().contains('\n'),
                        "{name}: one line: {e}"
                    );
                }
            }
        }
    }
    assert!(errors > 0, "{name}: none of {tried} changes was seen");
    assert!(open(&[]).is_err() && open(&[0; 64]).is_err() && open(b"PK\x03\x04").is_err(), "{name}");
}

/// The writer refuses other layers than announced. For formats whose head is written before the layers;
/// those that list their layers at the end need not mind.
pub fn counts(container: &dyn Container) {
    let mask = MaskLayer::default();
    let print = print(1);
    let encoded = container.encode(&mask, &print.panel);
    let mut out = Cursor::new(Vec::new());
    assert!(container.begin(&mut out, &print).unwrap().finish(&TOTALS).is_err(), "{}", container.name());
    let mut out = Cursor::new(Vec::new());
    let mut sink = container.begin(&mut out, &print).unwrap();
    sink.layer(&info(&print, 0, &mask), &encoded).unwrap();
    let more = sink.layer(&info(&print, 1, &mask), &encoded).and_then(|()| sink.finish(&TOTALS));
    assert!(more.is_err(), "{}", container.name());
}
