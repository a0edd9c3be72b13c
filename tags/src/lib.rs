//! Time tags of photons as instruments record them: one record for each detection, and for each
//! marker that tells where a code period begins.
//!
//! Read are PicoQuant's PTU files in T2 mode (PicoHarp 300, HydraHarp 400 versions 1 and 2, TimeHarp 260 N
//! and P, MultiHarp 150), and plain pairs of 64-bit numbers: picoseconds, channel. Times come out in
//! ticks of the file, unwrapped, block by block, so that memory stays the same however long the file is.
//!
//! ```
//! use std::io::Cursor;
//!
//! use goldtof_tags::{Channel, Format, TagReader};
//!
//! // A photon of channel 1 at 1,500 ps, then one of channel 2 at 2,750 ps.
//! let pairs = [1500_u64, 1, 2750, 2];
//! let bytes: Vec<u8> = pairs.iter().flat_map(|number| number.to_le_bytes()).collect();
//! let mut reader = TagReader::new(Cursor::new(bytes), "pairs.bin", Some(Format::Pairs))?;
//! let mut tags = Vec::new();
//! assert!(reader.read(&mut tags)?);
//! assert_eq!((tags[1].ticks, tags[1].channel), (2750, Channel::Input(2)));
//! assert_eq!(reader.tick_ps(), 1.0);
//! # Ok::<(), goldtof_tags::TagError>(())
//! ```

mod header;
mod records;
mod sink;

use std::fmt;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;
use std::str::FromStr;

use self::header::Header;
use self::records::Unwrap;
use self::sink::{Ordered, RecordOrder, Selected, Sink};

/// Records that are decoded at once.
const BLOCK: usize = 1 << 16;

/// Where a record comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Channel {
    /// The sync input of an instrument that records it.
    Sync,
    /// A photon input, numbered from 1 as on the instrument's front; of pairs the channel's number.
    Input(u16),
    /// A marker input, 1 to 4. Several at once are a record each.
    Marker(u8),
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Channel::Sync => write!(f, "sync"),
            Channel::Input(number) => write!(f, "{number}"),
            Channel::Marker(number) => write!(f, "m{number}"),
        }
    }
}

impl FromStr for Channel {
    type Err = String;

    fn from_str(text: &str) -> Result<Channel, String> {
        let marker = || text.strip_prefix('m')?.parse().ok().filter(|m| (1..=4).contains(m));
        if text == "sync" {
            return Ok(Channel::Sync);
        }
        text.parse()
            .map(Channel::Input)
            .ok()
            .or_else(|| marker().map(Channel::Marker))
            .ok_or_else(|| {
                format!(
                    "\"{text}\" is not a channel: write the number of an input, \"m1\" to \"m4\" for a marker, \
                     or \"sync\""
                )
            })
    }
}

/// A detection, or a marker.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tag {
    /// Its time in ticks since the recording began.
    pub ticks: u64,
    /// Where it comes from.
    pub channel: Channel,
}

/// How records are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// A PTU file; its header says of which instrument.
    Ptu,
    /// Pairs of little-endian 64-bit numbers, picoseconds and channel.
    Pairs,
}

/// Why a file cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum TagError {
    /// The file itself.
    #[error("{file}: {source}")]
    Io {
        /// Its name.
        file: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// What stands in it.
    #[error("{file}, byte {byte}: {reason}")]
    Malformed {
        /// Its name.
        file: String,
        /// Where it is wrong.
        byte: u64,
        /// What is wrong, and what would be right.
        reason: String,
    },
}

/// Reads a file of time tags block by block.
#[derive(Debug)]
pub struct TagReader<R> {
    input: R,
    file: String,
    format: Records,
    tick_ps: f64,
    /// The byte of the file that is read next.
    byte: u64,
    buffer: Vec<u8>,
    order: RecordOrder,
    records: u64,
    of_other_channels: u64,
    torn_bytes: u64,
    announced: Option<u64>,
}

/// What a record is.
#[derive(Debug)]
enum Records {
    Pairs,
    T2(Unwrap),
}

impl TagReader<BufReader<File>> {
    /// Opens a file: a PTU file by its first bytes, anything else as pairs.
    ///
    /// # Errors
    /// When it cannot be read, or is none that is understood.
    pub fn open(path: &Path) -> Result<TagReader<BufReader<File>>, TagError> {
        let name = path.display().to_string();
        let opened = File::open(path);
        let file = opened.map_err(|source| TagError::Io { file: name.clone(), source })?;
        TagReader::new(BufReader::with_capacity(1 << 20, file), &name, None)
    }
}

impl<R: Read> TagReader<R> {
    /// Reads the beginning of a file that messages call `name`; without a format it is found.
    ///
    /// # Errors
    /// When it cannot be read, or is none that is understood.
    pub fn new(mut input: R, name: &str, format: Option<Format>) -> Result<TagReader<R>, TagError> {
        let io = |source| TagError::Io { file: name.to_owned(), source };
        let mut begun = Vec::new();
        if format != Some(Format::Pairs) {
            input.by_ref().take(header::MAGIC.len() as u64).read_to_end(&mut begun).map_err(io)?;
        }
        let is_ptu = begun == header::MAGIC;
        if format == Some(Format::Ptu) && !is_ptu {
            let reason = "the file does not begin with \"PQTTTR\": it is not a PTU file".to_owned();
            return Err(TagError::Malformed { file: name.to_owned(), byte: 0, reason });
        }
        let mut reader = TagReader {
            input,
            file: name.to_owned(),
            format: Records::Pairs,
            tick_ps: 1.0,
            byte: begun.len() as u64,
            buffer: begun,
            order: RecordOrder::default(),
            records: 0,
            of_other_channels: 0,
            torn_bytes: 0,
            announced: None,
        };
        if is_ptu {
            let (header, bytes) = Header::read(&mut reader.input).map_err(|error| match error {
                header::HeaderError::Io(source) => io(source),
                header::HeaderError::Malformed { byte, reason } => {
                    TagError::Malformed { file: name.to_owned(), byte, reason }
                }
            })?;
            reader.buffer.clear();
            reader.byte = bytes;
            reader.tick_ps = header.resolution_s * 1e12;
            reader.announced = header.records;
            let unwrap = Unwrap::of(header.record_type).map_err(|reason| TagError::Malformed {
                file: name.to_owned(),
                byte: header.record_type_at,
                reason,
            })?;
            reader.format = Records::T2(unwrap);
        }
        Ok(reader)
    }

    /// Picoseconds of a tick.
    pub fn tick_ps(&self) -> f64 {
        self.tick_ps
    }

    /// Records so far, overflows among them.
    pub fn records(&self) -> u64 {
        self.records
    }

    /// Bytes of a record that ends with the file before it is whole.
    pub fn torn_bytes(&self) -> u64 {
        self.torn_bytes
    }

    /// Records so far that are earlier than one before them.
    pub fn disordered(&self) -> u64 {
        self.order.disordered
    }

    /// Records so far that [`TagReader::read_channels`] was not asked for; overflows are none.
    pub fn of_other_channels(&self) -> u64 {
        self.of_other_channels
    }

    /// Records that the header says there are, if it does: fewer come of a recording that was broken off.
    pub fn announced(&self) -> Option<u64> {
        self.announced
    }

    /// What instrument and mode the records are of.
    pub fn kind(&self) -> &'static str {
        match &self.format {
            Records::Pairs => "pairs of picoseconds and channel",
            Records::T2(unwrap) => unwrap.name(),
        }
    }

    /// Puts the next records into `tags`, which it empties first. False at the end of the file.
    ///
    /// # Errors
    /// When the file cannot be read, or a record is none.
    pub fn read(&mut self, tags: &mut Vec<Tag>) -> Result<bool, TagError> {
        tags.clear();
        self.decode(tags)
    }

    /// Appends the times of the next records in ticks, of each channel that is wanted to its list in `ticks`; others are
    /// counted. False at the end of the file. This is quicker than [`TagReader::read`].
    ///
    /// # Errors
    /// When the file cannot be read, or a record is none.
    ///
    /// # Panics
    /// If there is not one list for each channel.
    pub fn read_channels(
        &mut self,
        wanted: &[Channel],
        ticks: &mut [Vec<u64>],
    ) -> Result<bool, TagError> {
        assert_eq!(wanted.len(), ticks.len(), "a list for each channel");
        let mut selected = Selected { wanted, ticks, others: 0 };
        let is_read = self.decode(&mut selected)?;
        self.of_other_channels += selected.others;
        Ok(is_read)
    }

    /// Decodes the next records.
    fn decode(&mut self, sink: &mut impl Sink) -> Result<bool, TagError> {
        let size = match self.format {
            Records::Pairs => 16,
            Records::T2(_) => 4,
        };
        // What looking for the format has read stands at the front.
        let wanted = BLOCK * size;
        let mut buffer = std::mem::take(&mut self.buffer);
        let lacking = (wanted - buffer.len()) as u64;
        let start = self.byte - buffer.len() as u64;
        let got = self.input.by_ref().take(lacking).read_to_end(&mut buffer);
        let got = got.map_err(|source| TagError::Io { file: self.file.clone(), source })?;
        self.byte += got as u64;
        let torn = buffer.len() % size;
        self.torn_bytes += torn as u64;
        let mut sink = Ordered { order: &mut self.order, sink };
        let decoded = match &mut self.format {
            Records::T2(unwrap) => {
                unwrap.decode(&buffer[..buffer.len() - torn], &mut sink);
                Ok(())
            }
            Records::Pairs => pairs(&buffer, &mut sink),
        };
        decoded.map_err(|(at, reason)| TagError::Malformed {
            file: self.file.clone(),
            byte: start + at as u64,
            reason,
        })?;
        self.records += (buffer.len() / size) as u64;
        let is_read = !buffer.is_empty();
        buffer.clear();
        self.buffer = buffer;
        Ok(is_read)
    }
}

/// Decodes pairs; where one is none, its place and why.
fn pairs(bytes: &[u8], sink: &mut impl Sink) -> Result<(), (usize, String)> {
    for (number, pair) in bytes.chunks_exact(16).enumerate() {
        let word = |at: usize| {
            let mut word = [0; 8];
            word.copy_from_slice(&pair[at..at + 8]);
            u64::from_le_bytes(word)
        };
        let channel = u16::try_from(word(8)).map_err(|_| {
            let told = format!(
                "channel {}: pairs are of two little-endian 64-bit numbers, picoseconds and a channel up \
                 to {}",
                word(8),
                u16::MAX
            );
            (number * 16 + 8, told)
        })?;
        sink.tag(word(0), Channel::Input(channel));
    }
    Ok(())
}
