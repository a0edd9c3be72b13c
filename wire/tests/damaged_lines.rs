//! Lines that tear, double, drop and flip: every loss is told, and no count is wrong.

mod noise;

use goldtof_wire::{
    Answer, Decoder, Event, Frame, Layout, REQUEST_READ, Request, ResultsFrame, encode,
};
use noise::Noise;
use proptest::prelude::*;

/// Results of a scan.
const SCAN: usize = 1000;

/// A device that measures scan after scan, and drops the rest of one now and then.
struct Device {
    noise: Noise,
    layout: Layout,
    sequence: u8,
    index: usize,
    lost: u16,
    /// Results dropped since the last frame.
    dropped: u64,
}

impl Device {
    /// The next frame, its bytes, and the results that were dropped before it.
    fn frame(&mut self) -> (Frame, Vec<u8>, u64) {
        let sequence = self.sequence;
        self.sequence = self.sequence.wrapping_add(1);
        if self.noise.below(20) == 0 {
            let request = Request { kind: REQUEST_READ, tag: sequence, address: 0x10 };
            let answer = Answer { request, status: 0, data: self.noise.next() as u32 };
            return (Frame::Answer(answer), encode::answer(answer, sequence), 0);
        }
        let gap = self.index > 0 && self.noise.below(30) == 0;
        if gap {
            let rest = (SCAN - self.index) as u64 + SCAN as u64 * self.noise.below(3);
            self.lost = self.lost.wrapping_add(rest as u16);
            self.dropped = rest;
            self.index = 0;
        }
        let count = (1 + self.noise.below(255) as usize).min(SCAN - self.index);
        let mask = (1 << self.layout.result_bits()) - 1;
        // Bytes like the first ones of a frame are common in them.
        let results = (0..count).map(|_| match self.noise.below(3) {
            0 => 0xa543_a543_a543_u128 & mask,
            _ => u128::from(self.noise.next()) & mask,
        });
        let results = results.collect();
        let last = self.index + count == SCAN;
        let frame = ResultsFrame {
            last,
            gap,
            index: self.index as u32,
            lost: self.lost,
            results,
            ..ResultsFrame::default()
        };
        self.index = if last { 0 } else { self.index + count };
        let bytes = encode::results(&frame, sequence, self.layout);
        (Frame::Results(frame), bytes, std::mem::take(&mut self.dropped))
    }
}

/// What has to be told before a frame that came through, and the frame.
struct Expected {
    frame: Frame,
    lost_frames: u32,
    lost_results: u64,
    dropped: u64,
}

/// How a line treats a frame.
enum Fate {
    Whole,
    Doubled,
    Dropped,
    Torn,
    Flipped,
}

fn fate(noise: &mut Noise) -> Fate {
    match noise.below(12) {
        0 => Fate::Doubled,
        1 | 2 => Fate::Dropped,
        3..=5 => Fate::Torn,
        6 | 7 => Fate::Flipped,
        _ => Fate::Whole,
    }
}

/// Bytes of so many frames on a bad line, what has to come of them, and how many were doubled and damaged.
fn bad_line(frames: usize, layout: Layout, seed: u64) -> (Vec<u8>, Vec<Expected>, u64, u64) {
    let mut noise = Noise(seed);
    let mut device = Device {
        noise: Noise(seed + 1),
        layout,
        sequence: 250,
        index: 0,
        lost: 65_000,
        dropped: 0,
    };
    let (mut line, mut expected) = (Vec::new(), Vec::<Expected>::new());
    let (mut doubled, mut damaged) = (0, 0);
    let (mut lost_frames, mut lost_results, mut dropped) = (0, 0, 0);
    for _ in 0..frames {
        let (frame, mut bytes, before) = device.frame();
        dropped += before;
        // What comes first has nothing before it that could be missed.
        let fate = if expected.is_empty() { Fate::Whole } else { fate(&mut noise) };
        let results = match &frame {
            Frame::Results(results) => results.results.len() as u64,
            _ => 0,
        };
        match fate {
            Fate::Whole | Fate::Doubled => {
                line.extend(&bytes);
                if matches!(fate, Fate::Doubled) {
                    doubled += 1;
                    line.extend(&bytes);
                }
                // An answer does not tell what the bridge has dropped; the next results do.
                let told = |number: &mut u64| if results > 0 { std::mem::take(number) } else { 0 };
                expected.push(Expected {
                    frame,
                    lost_frames: std::mem::take(&mut lost_frames),
                    lost_results: told(&mut lost_results),
                    dropped: told(&mut dropped),
                });
                continue;
            }
            Fate::Dropped => {}
            Fate::Torn => {
                let from = noise.below(bytes.len() as u64) as usize;
                let to = from + 1 + noise.below((bytes.len() - from) as u64) as usize;
                bytes.drain(from..to);
                line.extend(&bytes);
            }
            Fate::Flipped => {
                let whole = bytes.clone();
                for _ in 0..1 + noise.below(4) {
                    let bit = noise.below(8 * bytes.len() as u64) as usize;
                    bytes[bit / 8] ^= 1 << (bit % 8);
                }
                // Twice the same bit leaves it whole.
                bytes[0] ^= u8::from(bytes == whole);
                line.extend(&bytes);
            }
        }
        damaged += 1;
        lost_frames += 1;
        lost_results += results;
    }
    (line, expected, doubled, damaged)
}

#[test]
fn of_ten_thousand_damaged_frames_every_loss_is_told_and_no_count_is_wrong() {
    for (seed, layout) in [
        (1, Layout { count_bits: 17, counts: 1, more_bits: 0 }),
        (2, Layout { count_bits: 17, counts: 1, more_bits: 16 }),
        (3, Layout { count_bits: 8, counts: 8, more_bits: 0 }),
        (4, Layout { count_bits: 5, counts: 1, more_bits: 0 }),
    ] {
        let (line, expected, doubled, damaged) = bad_line(18_000, layout, seed);
        assert!(doubled + damaged > 10_000, "{doubled} {damaged}");
        let mut decoder = Decoder::new(Some(layout));
        decoder.set_results_of_scan(SCAN as u64);
        let mut noise = Noise(seed + 2);
        let mut events = Vec::new();
        let mut rest = line.as_slice();
        while !rest.is_empty() {
            let (piece, others) = rest.split_at((1 + noise.below(2000) as usize).min(rest.len()));
            decoder.push(piece);
            rest = others;
            events.extend(std::iter::from_fn(|| decoder.next_event()));
        }
        for _ in 0..10_000 {
            decoder.silence();
            events.extend(std::iter::from_fn(|| decoder.next_event()));
        }
        let mut events = events.into_iter().peekable();
        let mut unknown = 0;
        for (number, expected) in expected.iter().enumerate() {
            let loss = match events.peek() {
                Some(Event::Lost(loss)) => Some(*loss),
                _ => None,
            };
            if loss.is_some() {
                events.next();
            }
            let told =
                loss.map_or((0, Some(0), 0), |loss| (loss.frames, loss.results, loss.dropped));
            assert_eq!(
                (told.0, told.2),
                (expected.lost_frames, expected.dropped),
                "frame {number}"
            );
            match (told.1, &expected.frame) {
                (Some(results), Frame::Results(_)) => {
                    assert_eq!(results, expected.lost_results, "frame {number}")
                }
                (None, Frame::Results(_)) => unknown += 1,
                _ => {}
            }
            assert_eq!(events.next(), Some(Event::Frame(expected.frame.clone())), "frame {number}");
        }
        assert_eq!(events.next(), None);
        let tally = decoder.tally();
        assert_eq!(tally.doubled, doubled);
        assert_eq!(tally.uncertain, unknown);
        assert_eq!(tally.frames, expected.len() as u64);
        // Where four frames or more are missing in a row a whole scan might be.
        assert!(
            unknown < 1500,
            "{unknown} of {} losses have no number of results",
            tally.lost_frames
        );
    }
}

proptest! {
    #[test]
    fn any_bytes_are_decoded_without_a_panic(
        bytes in proptest::collection::vec(prop_oneof![Just(0xa5_u8), Just(0x43), Just(0x41), Just(0x49), any::<u8>()], 0..2000),
        count_bits: u8, counts: u8, more_bits: u8,
    ) {
        let layout = Layout { count_bits, counts, more_bits };
        let mut decoder = Decoder::new(layout.is_possible().then_some(layout));
        for piece in bytes.chunks(7) {
            decoder.push(piece);
            while decoder.next_event().is_some() {}
        }
        for _ in 0..bytes.len() {
            decoder.silence();
            while decoder.next_event().is_some() {}
        }
        let tally = decoder.tally();
        prop_assert_eq!(tally.bytes, bytes.len() as u64);
        prop_assert!(tally.stray_bytes <= tally.bytes);
    }
}
