//! The serial line between the bridge of `hdl/bridge/` and a host (docs/wire.md): frames of results and
//! answers from the device, requests to it. No port is opened here: bytes go in and out.
//!
//! ```
//! use goldtof_wire::{Decoder, Event, Frame, Layout, ResultsFrame, encode};
//!
//! // Counts of 18 bits; the frame that a device sends first, with three of them.
//! let layout = Layout { count_bits: 18, counts: 1, more_bits: 0 };
//! let results = ResultsFrame { index: 0, lost: 0, results: vec![17, 3, (1 << 18) - 5], ..ResultsFrame::default() };
//! let bytes = encode::results(&results, 0, layout);
//! assert_eq!(bytes.len(), 10 + 7 + 4);
//!
//! let mut decoder = Decoder::new(Some(layout));
//! decoder.push(&bytes);
//! let Some(Event::Frame(Frame::Results(decoded))) = decoder.next_event() else { panic!() };
//! assert_eq!(layout.count(decoded.results[2], 0), -5);
//! assert_eq!(decoder.next_event(), None);
//! ```

mod crc;
mod decoder;
pub mod encode;
mod identity;
mod layout;
mod rate;

pub use crc::crc32;
pub use decoder::{Decoder, Event, Frame, Loss, ResultsFrame, Tally};
pub use identity::{Content, Identity, IdentityError};
pub use layout::Layout;
pub use rate::{LineError, Load, MOST_RESULTS_OF_A_FRAME, Pace, Scans, rest_bits};

/// First byte of each frame from the device.
pub const SYNC: u8 = 0xa5;
/// First byte of each request to the device.
pub const REQUEST_SYNC: u8 = 0x5a;
/// Kind of a frame with results: `C`.
pub const KIND_RESULTS: u8 = b'C';
/// Kind of a frame that answers a read or a write: `A`.
pub const KIND_ANSWER: u8 = b'A';
/// Kind of a frame in which the device says what it is: `I`.
pub const KIND_IDENTITY: u8 = b'I';
/// Kind of a request to say so: `I`.
pub const REQUEST_IDENTITY: u8 = b'I';
/// Kind of a request for a block of the scene's text: `T`; its address is that of the block's first byte.
pub const REQUEST_TEXT: u8 = b'T';
/// Kind of a request for hits by sample: `H`; its address is four times the number of the first sample, counted through
/// all detectors, a multiple of 32.
pub const REQUEST_HITS: u8 = b'H';
/// Kind of a request to read a register: `R`.
pub const REQUEST_READ: u8 = b'R';
/// Kind of a request to write a register: `W`.
pub const REQUEST_WRITE: u8 = b'W';

/// Bytes of a results frame's header.
pub const RESULTS_HEADER_BYTES: usize = 10;
/// Bytes of the CRC at the end of each frame and request.
pub const CRC_BYTES: usize = 4;
/// Bytes of an answer.
pub const ANSWER_BYTES: usize = 12 + CRC_BYTES;
/// Bytes of a frame with the device's identity.
pub const IDENTITY_FRAME_BYTES: usize = 40 + CRC_BYTES;
/// Bytes of the scene's text, or of hits by sample, in an answer.
pub const BLOCK_BYTES: usize = 32;
/// Most bytes of a scene's text that a device holds.
pub const MOST_TEXT_BYTES: usize = 127 * BLOCK_BYTES;
/// Bytes of a request.
pub const REQUEST_BYTES: usize = 13;

/// A flag of a frame: its last result is the last of a scan.
pub const FLAG_LAST: u8 = 1;
/// A flag of a frame: the core has lost a result since its reset (`o_overrun`).
pub const FLAG_OVERRUN: u8 = 1 << 1;
/// A flag of a frame: a count of the core was saturated since its reset (`o_saturated`).
pub const FLAG_SATURATED: u8 = 1 << 2;
/// A flag of a frame: results were lost in the bridge before its first one.
pub const FLAG_GAP: u8 = 1 << 3;

/// A request, as an answer repeats it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Request {
    /// [`REQUEST_IDENTITY`], [`REQUEST_TEXT`], [`REQUEST_HITS`], [`REQUEST_READ`] or [`REQUEST_WRITE`].
    pub kind: u8,
    /// The host's number for it.
    pub tag: u8,
    /// Byte address of a register, 12 bits.
    pub address: u16,
}

/// What a device answers to a read or a write.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Answer {
    /// What was asked.
    pub request: Request,
    /// AXI's response: 0 OKAY, 2 SLVERR, 3 DECERR.
    pub status: u8,
    /// What was read; after a write it means nothing.
    pub data: u32,
}
