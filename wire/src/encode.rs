//! Frames and requests as bytes: the host's requests, and what a device would send.

use crate::{
    Answer, BLOCK_BYTES, CRC_BYTES, FLAG_GAP, FLAG_LAST, FLAG_OVERRUN, FLAG_SATURATED, Identity,
    KIND_ANSWER, KIND_IDENTITY, KIND_RESULTS, Layout, MOST_TEXT_BYTES, REQUEST_BYTES, REQUEST_SYNC,
    Request, ResultsFrame, SYNC, crc32,
};

/// A request; `data` is what is to be written, and of no meaning to a read.
pub fn request(request: Request, data: u32) -> [u8; REQUEST_BYTES] {
    let mut bytes = [0; REQUEST_BYTES];
    bytes[0] = REQUEST_SYNC;
    bytes[1..5].copy_from_slice(&echo(request));
    bytes[5..9].copy_from_slice(&data.to_le_bytes());
    let crc = crc32(&bytes[1..9]);
    bytes[9..].copy_from_slice(&crc.to_le_bytes());
    bytes
}

/// A frame of results, as the device's frame `sequence`.
pub fn results(frame: &ResultsFrame, sequence: u8, layout: Layout) -> Vec<u8> {
    let flag = |is_set: bool, flag: u8| if is_set { flag } else { 0 };
    let flags = flag(frame.last, FLAG_LAST)
        | flag(frame.overrun, FLAG_OVERRUN)
        | flag(frame.saturated, FLAG_SATURATED)
        | flag(frame.gap, FLAG_GAP);
    let mut bytes = vec![SYNC, KIND_RESULTS, sequence, flags, frame.results.len() as u8];
    bytes.extend(&frame.index.to_le_bytes()[..3]);
    bytes.extend(frame.lost.to_le_bytes());
    let first = bytes.len();
    bytes.resize(first + layout.payload_bytes(frame.results.len()), 0);
    let bits = layout.result_bits();
    for (number, result) in frame.results.iter().enumerate() {
        for bit in (0..bits).filter(|bit| result >> bit & 1 == 1) {
            let place = number * bits + bit;
            bytes[first + place / 8] |= 1 << (place % 8);
        }
    }
    closed(bytes)
}

/// An answer to a read or a write.
pub fn answer(answer: Answer, sequence: u8) -> Vec<u8> {
    let mut bytes = vec![SYNC, KIND_ANSWER, sequence, (answer.status & 3) << 4];
    bytes.extend(echo(answer.request));
    bytes.extend(answer.data.to_le_bytes());
    closed(bytes)
}

/// An answer in which the device says what it is.
pub fn identity(request: Request, identity: &Identity, sequence: u8) -> Vec<u8> {
    let mut bytes = vec![SYNC, KIND_IDENTITY, sequence, 0];
    bytes.extend(echo(request));
    bytes.extend(identity.to_bytes());
    closed(bytes)
}

/// An answer with a block of the scene's text, or of hits by sample.
pub fn block(request: Request, block: &[u8; BLOCK_BYTES], sequence: u8) -> Vec<u8> {
    let mut bytes = vec![SYNC, KIND_IDENTITY, sequence, 0];
    bytes.extend(echo(request));
    bytes.extend(block);
    closed(bytes)
}

/// A scene's text in Verilog, as the bridge's parameter `TEXT` has it: words of a block, the last one first;
/// and its blocks. `None` if it is empty or longer than [`crate::MOST_TEXT_BYTES`].
pub fn text_parameter(text: &str) -> Option<(u8, Vec<String>)> {
    let blocks = text.len().div_ceil(BLOCK_BYTES);
    let words = text.as_bytes().chunks(BLOCK_BYTES).rev().map(|block| {
        let digits = block.iter().rev().map(|byte| format!("{byte:02x}"));
        format!("256'h{}", digits.collect::<String>())
    });
    (1..=MOST_TEXT_BYTES / BLOCK_BYTES).contains(&blocks).then(|| (blocks as u8, words.collect()))
}

/// A request as an answer repeats it.
fn echo(request: Request) -> [u8; 4] {
    let [low, high] = request.address.to_le_bytes();
    [request.kind, request.tag, low, high]
}

/// A frame with its CRC, which does not cover the first byte.
fn closed(mut bytes: Vec<u8>) -> Vec<u8> {
    let crc: [u8; CRC_BYTES] = crc32(&bytes[1..]).to_le_bytes();
    bytes.extend(crc);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_those_of_the_examples_in_the_documentation() {
        // docs/wire.md; their CRCs are Python's zlib.crc32 of the bytes after the first.
        let read = Request { kind: crate::REQUEST_READ, tag: 7, address: 0x010 };
        assert_eq!(
            request(read, 0),
            [0x5a, 0x52, 0x07, 0x10, 0x00, 0, 0, 0, 0, 0xc7, 0x17, 0x50, 0xb4]
        );
        let layout = Layout { count_bits: 18, counts: 1, more_bits: 0 };
        let frame = ResultsFrame {
            last: true,
            index: 16_374,
            results: vec![0x3_fff0, 0x0_0011],
            ..ResultsFrame::default()
        };
        assert_eq!(
            results(&frame, 3, layout),
            [
                0xa5, 0x43, 0x03, 0x01, 0x02, 0xf6, 0x3f, 0x00, 0x00, 0x00, 0xf0, 0xff, 0x47, 0x00,
                0x00, 0xb9, 0x0c, 0x5e, 0x9d
            ]
        );
    }
}
