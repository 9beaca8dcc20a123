//! `microtome inspect`.

use super::exit::CliError;
use super::report;
use crate::job::JobError;
use crate::job::output::{OutputError, OutputFile};
use crate::picture::mask_png;
use crate::resin::{Head, ReadError, Reader, format};
use clap::Args;
use serde::Serialize;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// So many damaged layers are listed at most; the others are counted.
const LISTED: usize = 20;

/// Arguments of `inspect`.
#[derive(Debug, Args)]
pub struct InspectArgs {
    /// A file, or a folder of pictures, for a resin printer
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// List all layers
    #[arg(long, conflicts_with = "head")]
    layers: bool,
    /// Read nothing but the head; by default every layer is decoded, so that damage is found
    #[arg(long)]
    head: bool,
    /// Read this layer alone, counted from 0
    #[arg(long, value_name = "N", conflicts_with = "head")]
    layer: Option<u32>,
    /// Write the layer as a grey PNG
    #[arg(long, value_name = "OUT", requires = "layer")]
    png: Option<PathBuf>,
    /// Print everything, with all layers, as one JSON object on stdout
    #[arg(long)]
    json: bool,
}

/// What a container says and holds. Lengths \[mm\], times \[s\].
#[derive(Debug, Serialize)]
struct Findings {
    file: String,
    format: &'static str,
    machine: String,
    width: u32,
    height: u32,
    display: Option<[f64; 2]>,
    mirror: Option<[bool; 2]>,
    layers: u32,
    layer_height: f64,
    exposure: f64,
    bottom_exposure: f64,
    bottom_layers: u32,
    time: Option<f64>,
    volume_ml: Option<f64>,
    /// Number of layers that were decoded.
    decoded: u32,
    /// Number of layers that could not be.
    damaged: u32,
    /// The first of them.
    damage: Vec<Damage>,
    /// Layers whose lit pixels the file counts otherwise; the first of them.
    miscounted: u32,
    first_miscounted: Option<u32>,
    /// Volume of all decoded layers, where the file has the size of pixels.
    mask_volume_ml: Option<f64>,
    per_layer: Vec<Figures>,
}

#[derive(Debug, Serialize)]
struct Damage {
    layer: u32,
    error: String,
}

/// One layer.
#[derive(Debug, Serialize)]
struct Figures {
    index: u32,
    z: f64,
    height: f64,
    exposure: f64,
    /// Lit pixels of any grey.
    lit: u64,
    /// Lit area, greys by their share.
    area_mm2: Option<f64>,
    runs: usize,
}

/// Reads a container and says what is in it.
///
/// # Errors
/// [`CliError`]: where the file is none or damaged, after what can be said has been.
pub fn run(args: &InspectArgs) -> Result<(), CliError> {
    let fail = |source| CliError::Container { path: args.file.clone(), source };
    let mut reader = format::open(&args.file).map_err(fail)?;
    let mut findings = Findings::new(&args.file, reader.head());
    let mut first = None;
    if let Some(index) = args.layer {
        let (mask, _) = reader.layer(index).map_err(fail)?;
        if let Some(out) = &args.png {
            picture(&mask, reader.head(), out)?;
        }
        first = findings.read(reader.as_mut(), index..index + 1);
    } else if !args.head {
        first = findings.read(reader.as_mut(), 0..findings.layers);
    }
    if args.json {
        report::json(&findings)?;
    } else {
        let mut out = io::BufWriter::new(io::stdout().lock());
        findings.people(&mut out, args)?;
        out.flush()?;
    }
    match first {
        Some(first) => Err(CliError::DamagedLayers {
            path: args.file.clone(),
            damaged: findings.damaged,
            layers: findings.layers,
            first,
        }),
        None => Ok(()),
    }
}

fn picture(mask: &crate::mask::MaskLayer, head: &Head, path: &Path) -> Result<(), CliError> {
    let mut out = OutputFile::create(path).map_err(JobError::from)?;
    mask_png::write(mask, head.width, head.height, &mut out)
        .map_err(|e| JobError::from(OutputError::new(path, e)))?;
    out.commit().map_err(JobError::from)?;
    Ok(())
}

impl Findings {
    fn new(path: &Path, head: &Head) -> Self {
        Self {
            file: path.display().to_string(),
            format: head.format,
            machine: head.machine.clone(),
            width: head.width,
            height: head.height,
            display: head.display,
            mirror: head.mirror,
            layers: head.layers,
            layer_height: head.layer_height,
            exposure: head.exposure,
            bottom_exposure: head.bottom_exposure,
            bottom_layers: head.bottom_layers,
            time: head.time,
            volume_ml: head.volume_ml,
            decoded: 0,
            damaged: 0,
            damage: Vec::new(),
            miscounted: 0,
            first_miscounted: None,
            mask_volume_ml: None,
            per_layer: Vec::new(),
        }
    }

    /// Area of a pixel \[mm²\].
    fn pixel_mm2(&self) -> Option<f64> {
        let [width, height] = self.display?;
        let area = width / f64::from(self.width.max(1)) * (height / f64::from(self.height.max(1)));
        (area > 0.0).then_some(area)
    }

    /// Decodes layers; the first error, if any.
    fn read(&mut self, reader: &mut dyn Reader, layers: std::ops::Range<u32>) -> Option<ReadError> {
        let pixel = self.pixel_mm2();
        let mut first = None;
        let mut volume = 0.0;
        for index in layers {
            match reader.layer(index) {
                Ok((mask, info)) => {
                    let area_mm2 = pixel.map(|p| p * mask.area());
                    let height = if info.height > 0.0 { info.height } else { self.layer_height };
                    volume += area_mm2.unwrap_or(0.0) * height / 1000.0;
                    let lit = mask.lit();
                    // 0 = the file does not say.
                    if info.lit != 0 && info.lit != lit {
                        self.miscounted += 1;
                        self.first_miscounted.get_or_insert(index);
                    }
                    self.decoded += 1;
                    self.per_layer.push(Figures {
                        index,
                        z: info.z,
                        height: info.height,
                        exposure: info.exposure,
                        lit,
                        area_mm2,
                        runs: mask.runs.len(),
                    });
                }
                Err(e) => {
                    self.damaged += 1;
                    if self.damage.len() < LISTED {
                        self.damage.push(Damage { layer: index, error: e.to_string() });
                    }
                    first.get_or_insert(e);
                }
            }
        }
        self.mask_volume_ml = pixel.map(|_| volume);
        first
    }

    fn people(&self, out: &mut impl Write, args: &InspectArgs) -> io::Result<()> {
        writeln!(out, "{}: {}, {} layers of {} mm", self.file, self.format, self.layers, self.layer_height)?;
        if !self.machine.is_empty() {
            writeln!(out, "machine: {}", self.machine)?;
        }
        write!(out, "panel: {} x {} pixels", self.width, self.height)?;
        if let Some([width, height]) = self.display {
            write!(out, ", {width} x {height} mm")?;
        }
        match self.mirror {
            Some([true, true]) => writeln!(out, ", mirrored along rows and across them")?,
            Some([true, false]) => writeln!(out, ", mirrored along rows")?,
            Some([false, true]) => writeln!(out, ", mirrored across rows")?,
            _ => writeln!(out)?,
        }
        let bottom = format!("{} bottom layers of {} s", self.bottom_layers, self.bottom_exposure);
        writeln!(out, "exposure: {} s, {bottom}", self.exposure)?;
        if let Some(time) = self.time.filter(|t| *t > 0.0) {
            let minutes = (time / 60.0).round() as u64;
            writeln!(out, "print time: {} h {:02} min", minutes / 60, minutes % 60)?;
        }
        if let Some(volume) = self.volume_ml.filter(|v| *v > 0.0) {
            writeln!(out, "resin: {volume:.3} ml")?;
        }
        if args.head {
            return Ok(());
        }
        if args.layers || args.layer.is_some() {
            writeln!(out, "layer       z mm  height  exposure s  lit pixels     area mm2     runs")?;
            for l in &self.per_layer {
                let area = l.area_mm2.map_or("-".to_owned(), |a| format!("{a:.3}"));
                writeln!(
                    out,
                    "{:5} {:10.3} {:7.3} {:11.2} {:11} {area:>12} {:8}",
                    l.index, l.z, l.height, l.exposure, l.lit, l.runs
                )?;
            }
        } else {
            let lit = self.per_layer.iter().map(|l| l.lit);
            let (least, most) = (lit.clone().min().unwrap_or(0), lit.clone().max().unwrap_or(0));
            writeln!(out, "lit pixels: {} in all, {least} to {most} a layer", lit.sum::<u64>())?;
            if let Some(volume) = self.mask_volume_ml {
                writeln!(out, "volume of the masks: {volume:.3} ml")?;
            }
        }
        if let Some(layer) = self.first_miscounted {
            let count = self.miscounted;
            writeln!(out, "{count} layers have other lit pixels than the file says, the first is {layer}")?;
        }
        writeln!(out, "{} layers decoded, {} damaged", self.decoded, self.damaged)
    }
}
