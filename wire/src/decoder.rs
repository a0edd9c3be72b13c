use crate::{
    ANSWER_BYTES, Answer, BLOCK_BYTES, CRC_BYTES, FLAG_GAP, FLAG_LAST, FLAG_OVERRUN,
    FLAG_SATURATED, IDENTITY_FRAME_BYTES, Identity, IdentityError, KIND_ANSWER, KIND_IDENTITY,
    KIND_RESULTS, Layout, REQUEST_HITS, REQUEST_TEXT, RESULTS_HEADER_BYTES, Request, SYNC, crc32,
};

/// A frame of results.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ResultsFrame {
    /// The last result is the last of its scan.
    pub last: bool,
    /// The core has lost a result since its reset.
    pub overrun: bool,
    /// A count of the core was saturated since its reset.
    pub saturated: bool,
    /// Results were lost in the bridge before the first one of this frame.
    pub gap: bool,
    /// Place of the first result in its scan, from 0; modulo 2^24.
    pub index: u32,
    /// Results lost in the bridge before the first one, since reset, modulo 2^16.
    pub lost: u16,
    /// The results, one after another; see [`Layout`].
    pub results: Vec<u128>,
}

/// What a device sends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Frame {
    /// Results.
    Results(ResultsFrame),
    /// The answer to a read or a write.
    Answer(Answer),
    /// What the device is, and the request that it answers.
    Identity(Request, Result<Identity, IdentityError>),
    /// A block of the scene's text, or of hits by sample, and the request that it answers. A device that has
    /// none ([`Identity::text_blocks`], [`Identity::counts_samples`]) answers with its identity's bytes.
    Block(Request, [u8; BLOCK_BYTES]),
}

/// Frames or results that did not come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Loss {
    /// Frames that the line lost, by their sequence numbers. Where a multiple of 256 are missing, 256.
    pub frames: u32,
    /// Results that were in them and in frames lost before, where their places in the scan tell; `None`
    /// where they do not, or not before the next results.
    pub results: Option<u64>,
    /// Results that the bridge dropped and counted, because the line is too slow for them; modulo 2^16.
    pub dropped: u64,
}

/// What came next.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Event {
    /// Something is missing before the next frame.
    Lost(Loss),
    /// A frame whose CRC is right.
    Frame(Frame),
}

/// How much has come, and how much has not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Bytes.
    pub bytes: u64,
    /// Frames, doubled ones not counted.
    pub frames: u64,
    /// Results in them.
    pub results: u64,
    /// Frames that came twice in a row; they count once.
    pub doubled: u64,
    /// What began like a frame and had the wrong CRC, or ended in silence.
    pub torn: u64,
    /// Bytes that belong to no frame.
    pub stray_bytes: u64,
    /// Frames that are missing by their sequence numbers.
    pub lost_frames: u64,
    /// Results that were in them, as far as their places tell.
    pub lost_results: u64,
    /// Losses whose number of results is not known.
    pub uncertain: u64,
    /// Results that the bridge dropped.
    pub dropped: u64,
}

/// Bytes to frames. It never panics, whatever the bytes; a frame that is torn costs itself only, because the
/// search for the next one begins behind its first byte.
#[derive(Debug, Clone)]
pub struct Decoder {
    layout: Option<Layout>,
    bytes: Vec<u8>,
    /// Those before it are done with.
    first: usize,
    /// The frame before, with its CRC, and its sequence number.
    before: Option<(u8, u32)>,
    /// Place in its scan of the result that comes next.
    next_index: Option<u64>,
    lost: u16,
    results_of_scan: Option<u64>,
    /// Frames that are missing since the last results.
    missing: u32,
    /// A frame behind the loss that was told first.
    waiting: Option<Frame>,
    tally: Tally,
}

impl Decoder {
    /// A decoder of results with this layout; without one, of all but results, until
    /// [`Decoder::set_layout`].
    pub fn new(layout: Option<Layout>) -> Decoder {
        Decoder {
            layout: layout.filter(|layout| layout.is_possible()),
            bytes: Vec::new(),
            first: 0,
            before: None,
            next_index: None,
            lost: 0,
            results_of_scan: None,
            missing: 0,
            waiting: None,
            tally: Tally::default(),
        }
    }

    /// From here on results are read.
    pub fn set_layout(&mut self, layout: Layout) {
        self.layout = Some(layout).filter(|layout| layout.is_possible());
    }

    /// How many results a scan has. Scans that come to their end tell it, too.
    pub fn set_results_of_scan(&mut self, results: u64) {
        self.results_of_scan = Some(results).filter(|results| *results > 0);
    }

    /// How much has come.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    /// Takes bytes of the line.
    pub fn push(&mut self, bytes: &[u8]) {
        if self.first > 0 {
            self.bytes.drain(..self.first);
            self.first = 0;
        }
        self.bytes.extend(bytes);
        self.tally.bytes += bytes.len() as u64;
    }

    /// Nothing has come for longer than any frame takes: one that has begun is torn. What is in it may show
    /// with the next calls of [`Decoder::next_event`].
    pub fn silence(&mut self) {
        if self.first < self.bytes.len() {
            self.tally.torn += 1;
            self.skip();
        }
    }

    /// What came next; `None` until there are more bytes.
    pub fn next_event(&mut self) -> Option<Event> {
        if let Some(frame) = self.waiting.take() {
            return Some(Event::Frame(frame));
        }
        loop {
            let bytes = &self.bytes[self.first..];
            if bytes.is_empty() {
                return None;
            }
            let length = match frame_bytes(bytes, self.layout) {
                Length::None => {
                    self.skip();
                    continue;
                }
                Length::Unknown => return None,
                Length::Bytes(length) => length,
            };
            let frame = bytes.get(..length)?;
            let (body, crc) = frame.split_at(length - CRC_BYTES);
            let crc = u32::from_le_bytes([crc[0], crc[1], crc[2], crc[3]]);
            if crc32(&body[1..]) != crc {
                self.tally.torn += 1;
                self.skip();
                continue;
            }
            let sequence = body[2];
            if self.before == Some((sequence, crc)) {
                self.tally.doubled += 1;
                self.first += length;
                continue;
            }
            let decoded = self.decoded(length - CRC_BYTES);
            self.first += length;
            return Some(self.follow(decoded, sequence, crc));
        }
    }

    /// Goes on by a byte that begins no frame.
    fn skip(&mut self) {
        self.first += 1;
        self.tally.stray_bytes += 1;
    }

    /// The frame whose header and body are the next `length` bytes.
    fn decoded(&self, length: usize) -> Frame {
        let body = &self.bytes[self.first..self.first + length];
        let request = || Request {
            kind: body[4],
            tag: body[5],
            address: u16::from_le_bytes([body[6], body[7]]),
        };
        match (body[1], self.layout) {
            (KIND_RESULTS, Some(layout)) => Frame::Results(results(body, layout)),
            (KIND_ANSWER, _) => Frame::Answer(Answer {
                request: request(),
                status: body[3] >> 4 & 3,
                data: u32::from_le_bytes([body[8], body[9], body[10], body[11]]),
            }),
            _ => {
                let bytes = std::array::from_fn(|k| body[8 + k]);
                match request() {
                    request if [REQUEST_TEXT, REQUEST_HITS].contains(&request.kind) => {
                        Frame::Block(request, bytes)
                    }
                    request => Frame::Identity(request, Identity::from_bytes(&bytes)),
                }
            }
        }
    }

    /// What a frame is that follows the one before: itself, or first that something is missing.
    fn follow(&mut self, frame: Frame, sequence: u8, crc: u32) -> Event {
        let missing = self.before.map_or(0, |(before, _)| {
            match sequence.wrapping_sub(before) {
                // Another frame with the same number.
                0 => 256,
                ahead => u32::from(ahead) - 1,
            }
        });
        self.before = Some((sequence, crc));
        self.tally.frames += 1;
        self.missing += missing;
        self.tally.lost_frames += u64::from(missing);
        let (results, dropped) = match &frame {
            Frame::Results(results) => self.lost_before(results),
            // What was in them shows with the next results.
            Frame::Answer(_) | Frame::Identity(..) | Frame::Block(..) => {
                ((missing == 0).then_some(0), 0)
            }
        };
        if (missing, results, dropped) == (0, Some(0), 0) {
            return Event::Frame(frame);
        }
        self.waiting = Some(frame);
        Event::Lost(Loss { frames: missing, results, dropped })
    }

    /// Results that are missing before a frame, on the line and in the bridge; and where the next ones are.
    fn lost_before(&mut self, frame: &ResultsFrame) -> (Option<u64>, u64) {
        let missing = std::mem::take(&mut self.missing);
        let index = u64::from(frame.index);
        let count = frame.results.len() as u64;
        let dropped = match self.next_index {
            Some(_) => u64::from(frame.lost.wrapping_sub(self.lost)),
            None => 0,
        };
        self.lost = frame.lost;
        let results = match (self.next_index, self.results_of_scan) {
            (None, _) => Some(0),
            (Some(next), _) if missing == 0 && next == index && dropped == 0 => Some(0),
            // next + missing + dropped = index, but for whole scans.
            (Some(next), Some(scan)) => {
                let to = index as i128 - next as i128 - dropped as i128;
                let fewest = to.rem_euclid(i128::from(scan)) as u64;
                let most = u64::from(missing) * crate::MOST_RESULTS_OF_A_FRAME;
                (fewest <= most && fewest + scan > most).then_some(fewest)
            }
            // No frame is missing, so the bridge dropped all that is.
            (Some(_), None) => (missing == 0 && dropped > 0).then_some(0),
        };
        if frame.last {
            self.results_of_scan = Some(index + count);
        }
        self.next_index = Some(if frame.last { 0 } else { index + count });
        self.tally.results += count;
        self.tally.dropped += dropped;
        match results {
            Some(results) => self.tally.lost_results += results,
            None => self.tally.uncertain += 1,
        }
        (results, dropped)
    }
}

/// How long the frame is that begins with these bytes.
enum Length {
    /// None begins here.
    None,
    /// Its header is not there yet.
    Unknown,
    Bytes(usize),
}

fn frame_bytes(bytes: &[u8], layout: Option<Layout>) -> Length {
    if bytes[0] != SYNC {
        return Length::None;
    }
    let results_flags = FLAG_LAST | FLAG_OVERRUN | FLAG_SATURATED | FLAG_GAP;
    // The others have AXI's response in place of marks of results.
    let answer_flags = FLAG_OVERRUN | FLAG_SATURATED | 3 << 4;
    let flags = |possible: u8| bytes.get(3).is_none_or(|flags| flags & !possible == 0);
    match (bytes.get(1), bytes.get(4), layout) {
        (None, ..) => Length::Unknown,
        (Some(&KIND_ANSWER), ..) if flags(answer_flags) => Length::Bytes(ANSWER_BYTES),
        (Some(&KIND_IDENTITY), ..) if flags(answer_flags) => Length::Bytes(IDENTITY_FRAME_BYTES),
        (Some(&KIND_RESULTS), None, Some(_)) if flags(results_flags) => Length::Unknown,
        (Some(&KIND_RESULTS), Some(&count), Some(layout)) if flags(results_flags) && count > 0 => {
            let payload = layout.payload_bytes(usize::from(count));
            Length::Bytes(RESULTS_HEADER_BYTES + payload + CRC_BYTES)
        }
        _ => Length::None,
    }
}

/// The results of a frame without its CRC.
fn results(body: &[u8], layout: Layout) -> ResultsFrame {
    let flags = body[3];
    let payload = &body[RESULTS_HEADER_BYTES..];
    let bits = layout.result_bits();
    ResultsFrame {
        last: flags & FLAG_LAST != 0,
        overrun: flags & FLAG_OVERRUN != 0,
        saturated: flags & FLAG_SATURATED != 0,
        gap: flags & FLAG_GAP != 0,
        index: u32::from_le_bytes([body[5], body[6], body[7], 0]),
        lost: u16::from_le_bytes([body[8], body[9]]),
        results: (0..usize::from(body[4])).map(|k| packed(payload, k * bits, bits)).collect(),
    }
}

/// `bits` bits from bit `first` on, least significant first; 128 at most.
fn packed(payload: &[u8], first: usize, bits: usize) -> u128 {
    let mut result = 0;
    let mut have = 0;
    while have < bits {
        let place = first + have;
        let taken = (8 - place % 8).min(bits - have);
        let piece = payload[place / 8] >> (place % 8) & (0xff >> (8 - taken));
        result |= u128::from(piece) << have;
        have += taken;
    }
    result
}
