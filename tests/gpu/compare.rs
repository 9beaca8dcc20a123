//! Comparisons that say where two results part.

use libtest_mimic::Failed;
use microtome::slice::Segments;
use std::fmt::Debug;

/// Whether two arrays are equal; the message names the first difference.
pub fn same<T: PartialEq + Debug>(what: &str, device: &[T], twin: &[T]) -> Result<(), Failed> {
    if device.len() != twin.len() {
        return Err(format!("{what}: length {} on the device, {} expected", device.len(), twin.len()).into());
    }
    match device.iter().zip(twin).position(|(d, t)| d != t) {
        Some(i) => Err(format!("{what}[{i}]: {:?} on the device, {:?} expected", device[i], twin[i]).into()),
        None => Ok(()),
    }
}

/// Whether all four arrays are equal.
pub fn same_segments(what: &str, device: &Segments, twin: &Segments) -> Result<(), Failed> {
    same(&format!("{what}: first"), &device.first, &twin.first)?;
    same(&format!("{what}: offset"), &device.offset, &twin.offset)?;
    same(&format!("{what}: start"), &device.start, &twin.start)?;
    same(&format!("{what}: next"), &device.next, &twin.next)
}

/// Fails with a message unless something holds.
pub fn ensure(holds: bool, message: impl Into<String>) -> Result<(), Failed> {
    if holds { Ok(()) } else { Err(message.into().into()) }
}
