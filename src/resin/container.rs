//! What every container can do.

use super::{Head, LayerInfo, Print, ReadError, Totals};
use crate::mask::{MaskLayer, Panel};
use std::io::{self, Seek, Write};

/// Where a container is written: a file, so that heads can be completed at the end.
pub trait WriteSeek: Write + Seek {}

impl<T: Write + Seek> WriteSeek for T {}

/// A format that masks can be written in. Two runs give the same bytes.
pub trait Container: Send + Sync {
    /// The format's name, such as `goo`.
    fn name(&self) -> &'static str;

    /// Size of the largest picture of the part that is stored: the one that [`Print::preview`] should have
    /// \[pixels\].
    fn preview_size(&self) -> [u32; 2] {
        [800, 480]
    }

    /// What of the print the format cannot say, one line each for people.
    fn losses(&self, _print: &Print) -> Vec<String> {
        Vec::new()
    }

    /// Compresses a mask. Depends on nothing but its arguments, so that equal layers share the result
    /// and layers can be compressed side by side.
    fn encode(&self, mask: &MaskLayer, panel: &Panel) -> Vec<u8>;

    /// Begins a file.
    ///
    /// # Errors
    /// Those of the stream; `InvalidInput` where the format cannot hold such a print, with the reason.
    fn begin<'a>(
        &'a self,
        out: &'a mut dyn WriteSeek,
        print: &'a Print,
    ) -> io::Result<Box<dyn LayerSink + 'a>>;
}

/// A file whose layers are being written, in their order.
pub trait LayerSink {
    /// Appends a layer; `encoded` comes from [`Container::encode`].
    ///
    /// # Errors
    /// Those of the stream.
    fn layer(&mut self, info: &LayerInfo, encoded: &[u8]) -> io::Result<()>;

    /// Completes the file.
    ///
    /// # Errors
    /// Those of the stream.
    fn finish(self: Box<Self>, totals: &Totals) -> io::Result<()>;
}

/// A container opened for reading.
pub trait Reader: Send {
    /// What it says of itself.
    fn head(&self) -> &Head;

    /// The mask of layer `index`, and what the file says of the layer where it says anything (else
    /// zeros).
    ///
    /// # Errors
    /// [`ReadError`] where the layer is missing or damaged. Reading another layer stays possible.
    fn layer(&mut self, index: u32) -> Result<(MaskLayer, LayerInfo), ReadError>;
}
