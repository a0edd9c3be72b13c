//! The header of a PTU file: tags of a name, an index, a type and a value, up to `Header_End`
//! (PicoQuant, "Unified TTTR file format", demo code `PTU_*`).

use std::io::Read;

pub(super) const MAGIC: &[u8] = b"PQTTTR\0\0";

/// Types of values.
const INTEGER: u32 = 0x1000_0008;
const FLOAT: u32 = 0x2000_0008;
/// Those that are followed by as many bytes as the value says.
const WITH_BYTES: [u32; 4] = [0x4001_FFFF, 0x4002_FFFF, 0xFFFF_FFFF, 0x2001_FFFF];

/// Most tags, and most bytes behind one: a header that has more is none.
const MOST_TAGS: usize = 10_000;
const MOST_BYTES: u64 = 1 << 26;

/// What of a header is needed.
#[derive(Debug)]
pub(super) struct Header {
    pub record_type: u64,
    /// The byte at which it says so.
    pub record_type_at: u64,
    /// Seconds of a tick.
    pub resolution_s: f64,
    pub records: Option<u64>,
}

pub(super) enum HeaderError {
    Io(std::io::Error),
    Malformed { byte: u64, reason: String },
}

impl From<std::io::Error> for HeaderError {
    fn from(error: std::io::Error) -> HeaderError {
        HeaderError::Io(error)
    }
}

fn malformed<T>(byte: u64, reason: impl Into<String>) -> Result<T, HeaderError> {
    Err(HeaderError::Malformed { byte, reason: reason.into() })
}

/// Bytes that have to be there.
fn exactly<const N: usize>(input: &mut impl Read, byte: &mut u64) -> Result<[u8; N], HeaderError> {
    let mut bytes = [0; N];
    let mut done = 0;
    while done < N {
        match input.read(&mut bytes[done..]) {
            Ok(0) => return malformed(*byte + done as u64, "the file ends within its header"),
            Ok(more) => done += more,
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error.into()),
        }
    }
    *byte += N as u64;
    Ok(bytes)
}

impl Header {
    /// Reads it behind the magic bytes; with the byte at which the records begin.
    pub fn read(input: &mut impl Read) -> Result<(Header, u64), HeaderError> {
        let mut byte = MAGIC.len() as u64;
        // The version of the format, a text.
        exactly::<8>(input, &mut byte)?;
        let (mut record_type, mut resolution, mut records) = (None, None, None);
        for _ in 0..MOST_TAGS {
            let at = byte;
            let name = exactly::<32>(input, &mut byte)?;
            let end = name.iter().position(|&letter| letter == 0).unwrap_or(name.len());
            let name = String::from_utf8_lossy(&name[..end]).into_owned();
            exactly::<4>(input, &mut byte)?;
            let kind = u32::from_le_bytes(exactly(input, &mut byte)?);
            let value_at = byte;
            let value = exactly::<8>(input, &mut byte)?;
            let number = u64::from_le_bytes(value);
            if WITH_BYTES.contains(&kind) {
                if number > MOST_BYTES {
                    return malformed(value_at, format!("{name} has {number} bytes of its own"));
                }
                let skipped = std::io::copy(&mut input.take(number), &mut std::io::sink())?;
                byte += skipped;
                if skipped < number {
                    return malformed(byte, "the file ends within its header");
                }
            }
            let is_of = |wanted: u32| match kind == wanted {
                true => Ok(()),
                false => {
                    malformed(at, format!("{name} is of type {kind:#010x}, not {wanted:#010x}"))
                }
            };
            match name.as_str() {
                "TTResultFormat_TTTRRecType" => {
                    is_of(INTEGER)?;
                    record_type = Some((number, value_at));
                }
                "TTResult_NumberOfRecords" => {
                    is_of(INTEGER)?;
                    records = Some(number);
                }
                "MeasDesc_GlobalResolution" => {
                    is_of(FLOAT)?;
                    let seconds = f64::from_le_bytes(value);
                    if !(1e-15..1e-3).contains(&seconds) {
                        return malformed(value_at, format!("{name} is {seconds:e} s"));
                    }
                    resolution = Some(seconds);
                }
                "Header_End" => {
                    let Some((record_type, record_type_at)) = record_type else {
                        return malformed(at, "the header has no TTResultFormat_TTTRRecType");
                    };
                    let Some(resolution_s) = resolution else {
                        return malformed(at, "the header has no MeasDesc_GlobalResolution");
                    };
                    let header = Header { record_type, record_type_at, resolution_s, records };
                    return Ok((header, byte));
                }
                _ => {}
            }
        }
        malformed(byte, format!("the header has no end within {MOST_TAGS} tags"))
    }
}
