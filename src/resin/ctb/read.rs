//! Reading a `.ctb` file.

use super::{NAME, decode, head, key, sections};
use crate::mask::MaskLayer;
use crate::resin::bytes::{Order, ReadSeek, Source};
use crate::resin::{Head, LayerInfo, ReadError, Reader};

/// Opens a `.ctb` file of version 2 to 5. `stream` should be buffered. Greys are those of
/// [`super::quantised`].
///
/// # Errors
/// [`ReadError::Foreign`] for encrypted files, others where the header is damaged or the file is too
/// short for its layers.
pub fn open(stream: Box<dyn ReadSeek>) -> Result<Box<dyn Reader>, ReadError> {
    let mut source = Source::new(NAME, stream)?;
    let found = head::read(&mut source)?;
    Ok(Box::new(Ctb { source, found }))
}

struct Ctb {
    source: Source,
    found: head::Found,
}

impl Reader for Ctb {
    fn head(&self) -> &Head {
        &self.found.head
    }

    fn layer(&mut self, index: u32) -> Result<(MaskLayer, LayerInfo), ReadError> {
        let head::Found { head, version, key, table } = &self.found;
        if index >= head.layers {
            return Err(ReadError::NoLayer { index, layers: head.layers });
        }
        let record = u64::from(sections::RECORD);
        let what = format_args!("layer {index}, record");
        let at = table + u64::from(index) * record;
        let fields = self.source.fields(at, record, Order::Little, what)?;
        let (mut info, place) = head::read_record(fields, index)?;
        if *version >= 3 && place.extended {
            let length = u64::from(sections::EXTENDED);
            let what = format_args!("layer {index}, record before the data");
            let fields = self.source.fields(place.at - length, length, Order::Little, what)?;
            head::read_extended(fields, *version, &mut info)?;
        }
        let what = format_args!("layer {index}, data");
        let mut data = self.source.block(place.at, place.size.into(), what)?;
        if *key != 0 {
            key::apply(*key, index, &mut data);
        }
        Ok((decode::decode(&data, head.width * head.height, index)?, info))
    }
}
