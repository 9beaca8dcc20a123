//! Chitubox's `.ctb`, versions 3 and 4 (written) and 2 to 5 (read), not encrypted.
//!
//! Sources: "The CBDDLP and CTB formats" of catibo (<https://github.com/cbiffle/catibo>,
//! `doc/cbddlp-ctb.adoc`) for version 2; what UVtools (<https://github.com/sn4k3/UVtools>) and uv3dp
//! (<https://github.com/ezrec/uv3dp>) say of it for the later ones. Numbers are little-endian, lengths
//! within runs big-endian. A header of 112 bytes names the places of all other sections.
//!
//! Greys have seven bits. A grey `v` is stored as `v >> 1` and read as 0 where that is 0, else as
//! `v | 1`: black and white stay what they are, and so do all masks without anti-aliasing. See
//! [`quantised`].

mod decode;
mod encode;
mod head;
mod key;
mod read;
mod sections;
mod write;

#[cfg(test)]
mod tests;

pub use encode::{canonical_grey, quantised};
pub use read::open;

use super::{Container, LayerSink, Motion, Print, WriteSeek};
use crate::mask::{MaskLayer, Panel};
use std::io;

/// The format's name.
pub const NAME: &str = "ctb";

/// The version of the format to write.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Version {
    /// What most printers of the kind read. Knows one stage of lift and retract and no rests: lifts are
    /// joined at the slower speed, rests become a light-off time that includes the motion.
    #[default]
    Three,
    /// Two stages, and rests.
    Four,
}

impl Version {
    fn number(self) -> u32 {
        match self {
            Self::Three => 3,
            Self::Four => 4,
        }
    }
}

/// Writes `.ctb` files.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ctb {
    /// The version to write.
    pub version: Version,
}

impl Container for Ctb {
    fn name(&self) -> &'static str {
        NAME
    }

    fn preview_size(&self) -> [u32; 2] {
        [400, 300]
    }

    fn losses(&self, print: &Print) -> Vec<String> {
        let two_stages = |m: &Motion| m.lift2 > 0.0 || m.retract2 > 0.0;
        if self.version == Version::Three && [print.motion, print.bottom_motion].iter().any(two_stages) {
            return vec![
                "ctb: version 3 moves in one stage, at the slower of two speeds; ctb_version 4 holds both"
                    .to_owned(),
            ];
        }
        Vec::new()
    }

    fn encode(&self, mask: &MaskLayer, panel: &Panel) -> Vec<u8> {
        encode::encode(mask, panel.pixels())
    }

    fn begin<'a>(
        &'a self,
        out: &'a mut dyn WriteSeek,
        print: &'a Print,
    ) -> io::Result<Box<dyn LayerSink + 'a>> {
        Ok(Box::new(write::Sink::begin(out, print, self.version)?))
    }
}
