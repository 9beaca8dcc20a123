//! Zip archives and folders of files: written so that two runs give the same bytes, read with bounds.

use super::bytes::ReadSeek;
use super::date::civil;
use super::{ReadError, WriteSeek};
use std::collections::BTreeMap;
use std::fs;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipArchive, ZipWriter};

/// Most members that are read from an archive or folder.
pub const MOST_MEMBERS: usize = 1 << 20;
/// Longest member of text that is read \[bytes\].
pub const LONGEST_TEXT: u64 = 1 << 26;

/// Deflate's quickest level: a PNG of a mask is mostly repetitions of one byte, which it shrinks tenfold.
const LEVEL: i64 = 1;

/// Where the members of a container go.
pub enum Sink<'a> {
    /// Into a zip archive, in their order.
    Zip(Box<ZipSink<'a>>),
    /// Into a folder that exists.
    Folder(PathBuf),
}

impl Sink<'_> {
    /// Writes a member.
    ///
    /// # Errors
    /// Those of the stream or of the folder.
    pub fn put(&mut self, name: &str, bytes: &[u8]) -> io::Result<()> {
        match self {
            Self::Zip(zip) => zip.put(name, bytes),
            Self::Folder(folder) => fs::write(folder.join(name), bytes),
        }
    }

    /// Writes what comes behind the members.
    ///
    /// # Errors
    /// Those of the stream.
    pub fn finish(self) -> io::Result<()> {
        match self {
            Self::Zip(zip) => zip.finish(),
            Self::Folder(_) => Ok(()),
        }
    }
}

/// A zip archive being written.
pub struct ZipSink<'a> {
    zip: ZipWriter<&'a mut dyn WriteSeek>,
    date: DateTime,
}

impl<'a> ZipSink<'a> {
    /// Begins an archive whose members are all dated `date` \[s since 1970 UTC\].
    pub fn new(out: &'a mut dyn WriteSeek, date: i64) -> Self {
        let [year, rest @ ..] = civil(date);
        let [month, day, hour, minute, second] = rest.map(|field| field as u8);
        // The format counts from 1980 to 2107, by two seconds.
        let date = u16::try_from(year)
            .ok()
            .and_then(|year| DateTime::from_date_and_time(year, month, day, hour, minute, second).ok())
            .unwrap_or_default();
        Self { zip: ZipWriter::new(out), date }
    }

    /// Appends a member.
    ///
    /// # Errors
    /// Those of the stream.
    pub fn put(&mut self, name: &str, bytes: &[u8]) -> io::Result<()> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .compression_level(Some(LEVEL))
            .last_modified_time(self.date)
            .unix_permissions(0o644)
            .system(System::Unix)
            .large_file(bytes.len() as u64 >= u64::from(u32::MAX));
        self.zip.start_file(name, options).map_err(io::Error::from)?;
        self.zip.write_all(bytes)
    }

    /// Writes the directory.
    ///
    /// # Errors
    /// Those of the stream.
    pub fn finish(self) -> io::Result<()> {
        self.zip.finish().map_err(io::Error::from)?.flush()
    }
}

/// The day and the time of day at `date` \[s since 1970 UTC\]: `2001-02-03` and `04:05:06`.
pub fn day_and_time(date: i64) -> [String; 2] {
    let [year, month, day, hour, minute, second] = civil(date);
    [format!("{year:04}-{month:02}-{day:02}"), format!("{hour:02}:{minute:02}:{second:02}")]
}

/// The members of a container that is read.
pub trait Members: Send {
    /// Their names.
    fn names(&self) -> Vec<String>;

    /// Whether there is such a member.
    fn has(&self, name: &str) -> bool;

    /// The bytes of a member.
    ///
    /// # Errors
    /// [`ReadError`] where it is missing, damaged or longer than `limit` bytes.
    fn read(&mut self, name: &str, limit: u64) -> Result<Vec<u8>, ReadError>;
}

/// A zip archive opened for reading.
pub struct Zip {
    zip: ZipArchive<BufReader<Box<dyn ReadSeek>>>,
    places: BTreeMap<String, usize>,
    length: u64,
}

impl Zip {
    /// Reads the directory of an archive.
    ///
    /// # Errors
    /// [`ReadError`]: `Foreign` where it is none, else what is wrong with it.
    pub fn open(mut input: Box<dyn ReadSeek>) -> Result<Self, ReadError> {
        let length = input.seek(SeekFrom::End(0))?;
        input.rewind()?;
        let mut first = Vec::new();
        input.by_ref().take(4).read_to_end(&mut first)?;
        input.rewind()?;
        if first != b"PK\x03\x04" && first != b"PK\x05\x06" {
            return Err(foreign(""));
        }
        let zip = ZipArchive::new(BufReader::new(input)).map_err(|error| match error {
            ZipError::Io(error) if error.kind() != io::ErrorKind::UnexpectedEof => ReadError::Io(error),
            _ => ReadError::Truncated { format: "zip", what: "its directory".to_owned(), end: length },
        })?;
        if zip.len() > MOST_MEMBERS {
            return Err(damaged(
                "zip",
                "the number of members",
                zip.len(),
                format!("at most {MOST_MEMBERS}"),
            ));
        }
        let mut places = BTreeMap::new();
        for index in 0..zip.len() {
            if let Some(Ok(name)) = zip.name_for_index(index) {
                places.insert(name.into_owned(), index);
            }
        }
        Ok(Self { zip, places, length })
    }
}

impl Members for Zip {
    fn names(&self) -> Vec<String> {
        self.places.keys().cloned().collect()
    }

    fn has(&self, name: &str) -> bool {
        self.places.contains_key(name)
    }

    fn read(&mut self, name: &str, limit: u64) -> Result<Vec<u8>, ReadError> {
        let Some(index) = self.places.get(name) else {
            return Err(damaged("zip", &format!("member {name}"), "missing", "present"));
        };
        let length = self.length;
        let failed = |error: io::Error| match error.kind() {
            io::ErrorKind::UnexpectedEof => {
                ReadError::Truncated { format: "zip", what: name.to_owned(), end: length }
            }
            io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput | io::ErrorKind::Other => {
                damaged("zip", &format!("member {name}"), format!("not readable ({error})"), "readable")
            }
            _ => ReadError::Io(error),
        };
        let file = self.zip.by_index(*index).map_err(|e| failed(e.into()))?;
        read_bounded(file, limit, name, failed)
    }
}

/// A folder opened for reading. Only plain names of files in it are read.
pub struct Folder {
    path: PathBuf,
    names: BTreeMap<String, ()>,
}

impl Folder {
    /// Lists a folder.
    ///
    /// # Errors
    /// [`ReadError`] of the system, or where there are too many files.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let mut names = BTreeMap::new();
        for entry in fs::read_dir(path)? {
            if let Ok(name) = entry?.file_name().into_string() {
                names.insert(name, ());
            }
            if names.len() > MOST_MEMBERS {
                let most = format!("at most {MOST_MEMBERS}");
                return Err(damaged("folder", "the number of files", "more", most));
            }
        }
        Ok(Self { path: path.to_owned(), names })
    }
}

impl Members for Folder {
    fn names(&self) -> Vec<String> {
        self.names.keys().cloned().collect()
    }

    fn has(&self, name: &str) -> bool {
        self.names.contains_key(name)
    }

    fn read(&mut self, name: &str, limit: u64) -> Result<Vec<u8>, ReadError> {
        // A name from the listing has no separators: nothing outside the folder is ever opened.
        if !self.has(name) {
            return Err(damaged("folder", &format!("file {name}"), "missing", "present"));
        }
        read_bounded(fs::File::open(self.path.join(name))?, limit, name, ReadError::Io)
    }
}

/// Reads to the end; what is allocated grows with what has been read.
fn read_bounded(
    mut file: impl Read,
    limit: u64,
    name: &str,
    failed: impl Fn(io::Error) -> ReadError,
) -> Result<Vec<u8>, ReadError> {
    let mut bytes = Vec::new();
    file.by_ref().take(limit).read_to_end(&mut bytes).map_err(&failed)?;
    if bytes.len() as u64 == limit && file.read(&mut [0]).map_err(&failed)? > 0 {
        let limit = format!("at most {limit} bytes");
        return Err(damaged("zip", &format!("the length of {name}"), "more", limit));
    }
    Ok(bytes)
}

/// The error for what none of the readers here knows.
pub fn foreign(hint: &str) -> ReadError {
    ReadError::Foreign {
        hint: hint.to_owned(),
        known: "sl1, nanodlp, and zips or folders of layers".to_owned(),
    }
}

/// The error for a field that contradicts the format.
pub fn damaged(
    format: &'static str,
    what: &str,
    value: impl std::fmt::Display,
    expected: impl std::fmt::Display,
) -> ReadError {
    ReadError::Damaged {
        format,
        what: what.to_owned(),
        value: value.to_string(),
        expected: expected.to_string(),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
mod tests {
    use super::*;
    use std::io::Cursor;

    #[test]
    fn dates_before_1980_are_1980() {
        for date in [i64::MIN / 100_000, -1, 0, 315_532_799] {
            let mut file = Cursor::new(Vec::new());
            let mut sink = ZipSink::new(&mut file, date);
            sink.put("a", b"").unwrap();
            sink.finish().unwrap();
            let mut zip = ZipArchive::new(file).unwrap();
            assert_eq!(zip.by_index(0).unwrap().last_modified(), Some(DateTime::default()));
        }
        assert_eq!(day_and_time(951_782_401), ["2000-02-29", "00:00:01"]);
    }

    #[test]
    fn members_come_back_and_bounds_hold() {
        let mut file = Cursor::new(Vec::new());
        let mut sink = Sink::Zip(Box::new(ZipSink::new(&mut file, 1_700_000_000)));
        sink.put("a.bin", b"stored").unwrap();
        sink.put("b.txt", &[b'x'; 1 << 20]).unwrap();
        sink.finish().unwrap();
        let bytes = file.into_inner();
        assert!(bytes.len() < 1 << 16);
        let mut zip = Zip::open(Box::new(Cursor::new(bytes.clone()))).unwrap();
        assert_eq!(zip.names(), ["a.bin", "b.txt"]);
        assert_eq!(zip.read("a.bin", 6).unwrap(), b"stored");
        assert!(matches!(zip.read("a.bin", 5), Err(ReadError::Damaged { .. })));
        assert!(matches!(zip.read("b.txt", 1000), Err(ReadError::Damaged { .. })), "a bomb is cut off");
        assert!(matches!(zip.read("c", 1000), Err(ReadError::Damaged { .. })));
        assert!(matches!(Zip::open(Box::new(Cursor::new(b"none".to_vec()))), Err(ReadError::Foreign { .. })));
        let cut = bytes[..bytes.len() / 2].to_vec();
        assert!(matches!(Zip::open(Box::new(Cursor::new(cut))), Err(ReadError::Truncated { .. })));
    }
}
