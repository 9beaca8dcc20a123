//! Reading a `.goo` file.

use super::{NAME, decode, head, write};
use crate::mask::MaskLayer;
use crate::resin::bytes::{Order, ReadSeek, Source};
use crate::resin::{Head, LayerInfo, ReadError, Reader};

/// Opens a `.goo` file of version V3.0. `stream` should be buffered.
///
/// Layers are found from one record to the next, so a damaged size hides what follows it, and nothing
/// before it.
///
/// # Errors
/// [`ReadError`] where the header is damaged or the file is too short for its layers.
pub fn open(stream: Box<dyn ReadSeek>) -> Result<Box<dyn Reader>, ReadError> {
    let mut source = Source::new(NAME, stream)?;
    let head = head::read(source.fields(0, head::LENGTH, Order::Big, "header")?)?;
    let least = u64::from(head.layers) * (head::RECORD + head::DELIMITER.len() as u64);
    if least > source.length() - head::LENGTH {
        return Err(ReadError::Truncated {
            format: NAME,
            what: format!("{} layers", head.layers),
            end: source.length(),
        });
    }
    Ok(Box::new(Goo { source, head, starts: vec![head::LENGTH] }))
}

struct Goo {
    source: Source,
    head: Head,
    /// Where the records known so far begin, and the next.
    starts: Vec<u64>,
}

impl Goo {
    /// The record of layer `index` at byte `start`, and where its image lies.
    fn record(&mut self, index: u32, start: u64) -> Result<(LayerInfo, u64, u64), ReadError> {
        let what = format_args!("layer {index}, record");
        let fields = self.source.fields(start, head::RECORD, Order::Big, what)?;
        let (info, size) = head::read_record(fields, index)?;
        Ok((info, start + head::RECORD, size.into()))
    }
}

impl Reader for Goo {
    fn head(&self) -> &Head {
        &self.head
    }

    fn layer(&mut self, index: u32) -> Result<(MaskLayer, LayerInfo), ReadError> {
        if index >= self.head.layers {
            return Err(ReadError::NoLayer { index, layers: self.head.layers });
        }
        loop {
            let known = self.starts.len() as u32 - 1;
            let reached = known.min(index);
            let start = self.starts.get(reached as usize).copied().unwrap_or(head::LENGTH);
            let (info, image, size) = self.record(reached, start)?;
            if reached < index {
                self.starts.push(image + size + head::DELIMITER.len() as u64);
                continue;
            }
            let length = size + head::DELIMITER.len() as u64;
            let bytes = self.source.block(image, length, format_args!("layer {index}, image"))?;
            let (bytes, behind) = bytes.split_at(bytes.len().saturating_sub(head::DELIMITER.len()));
            if behind != head::DELIMITER {
                return Err(ReadError::Damaged {
                    format: NAME,
                    what: format!("layer {index}, what follows the image"),
                    value: format!("{behind:02x?}"),
                    expected: format!("{:02x?}", head::DELIMITER),
                });
            }
            let mask = decode::decode(bytes, self.head.width * self.head.height, index)?;
            if index + 1 == self.head.layers {
                let ending = write::ending();
                let mut fields =
                    self.source.fields(image + length, ending.len() as u64, Order::Big, "ending")?;
                fields.expect(&ending, "bytes")?;
            }
            return Ok((mask, info));
        }
    }
}
