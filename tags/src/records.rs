//! Records of 32 bits of the T2 mode, by instrument (PicoQuant, "Unified TTTR file format").

use super::Channel;
use super::sink::{RUN, Sink};

/// How times go on where a record's bits end.
#[derive(Debug, Clone, Copy)]
pub(super) struct Unwrap {
    kind: Kind,
    /// Ticks of all overflows so far.
    base: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// 4 bits of channel, 28 of time.
    PicoHarp,
    /// 1 bit, 6 of channel, 25 of time; one overflow each record.
    HydraHarp1,
    /// The same, with the number of overflows in place of the time.
    HydraHarp2,
}

/// What each kind of record is called, and what becomes of it.
const TYPES: [(u64, &str, Option<Kind>); 12] = [
    (0x0001_0203, "PicoHarp 300 T2", Some(Kind::PicoHarp)),
    (0x0001_0204, "HydraHarp 400 version 1 T2", Some(Kind::HydraHarp1)),
    (0x0101_0204, "HydraHarp 400 version 2 T2", Some(Kind::HydraHarp2)),
    (0x0001_0205, "TimeHarp 260 N T2", Some(Kind::HydraHarp2)),
    (0x0001_0206, "TimeHarp 260 P T2", Some(Kind::HydraHarp2)),
    (0x0001_0207, "MultiHarp 150 T2", Some(Kind::HydraHarp2)),
    (0x0001_0303, "PicoHarp 300 T3", None),
    (0x0001_0304, "HydraHarp 400 version 1 T3", None),
    (0x0101_0304, "HydraHarp 400 version 2 T3", None),
    (0x0001_0305, "TimeHarp 260 N T3", None),
    (0x0001_0306, "TimeHarp 260 P T3", None),
    (0x0001_0307, "MultiHarp 150 T3", None),
];

/// Ticks of an overflow.
const PICOHARP_OVERFLOW: u64 = 210_698_240;
const HYDRAHARP_1_OVERFLOW: u64 = 33_552_000;
const HYDRAHARP_2_OVERFLOW: u64 = 1 << 25;

impl Unwrap {
    /// For records of a type.
    pub fn of(record_type: u64) -> Result<Unwrap, String> {
        match TYPES.iter().find(|(number, ..)| *number == record_type) {
            Some((_, _, Some(kind))) => Ok(Unwrap { kind: *kind, base: 0 }),
            Some((_, name, None)) => Err(format!(
                "the records are {name}, times since a sync pulse; record in T2 mode, with the code's \
                 epoch as a marker or an input"
            )),
            None => Err(format!(
                "records of type {record_type:#010x} are not known; those of T2 mode of PicoHarp 300, \
                 HydraHarp 400, TimeHarp 260 and MultiHarp 150 are"
            )),
        }
    }

    pub fn name(&self) -> &'static str {
        match self.kind {
            Kind::PicoHarp => "PicoHarp 300, T2 mode",
            Kind::HydraHarp1 => "HydraHarp 400 version 1, T2 mode",
            Kind::HydraHarp2 => "HydraHarp 400 version 2, TimeHarp 260 or MultiHarp 150, T2 mode",
        }
    }

    /// Decodes whole records. Most stand among others of one input, so that they are looked at in runs.
    pub fn decode(&mut self, bytes: &[u8], sink: &mut impl Sink) {
        let (time_bits, inputs) = match self.kind {
            Kind::PicoHarp => (28, 15),
            Kind::HydraHarp1 | Kind::HydraHarp2 => (25, 64),
        };
        let time = (1_u32 << time_bits) - 1;
        let record = |four: &[u8]| u32::from_le_bytes([four[0], four[1], four[2], four[3]]);
        let mut runs = bytes.chunks_exact(4 * RUN);
        for run in &mut runs {
            // Plain loops without branches, which a compiler makes vectors of.
            let (mut records, mut ticks) = ([0_u32; RUN], [0_u64; RUN]);
            for (to, four) in records.iter_mut().zip(run.chunks_exact(4)) {
                *to = record(four);
            }
            for (to, record) in ticks.iter_mut().zip(&records) {
                *to = self.base + u64::from(record & time);
            }
            let channel = records[0] >> time_bits;
            let differ =
                records.iter().fold(0, |bits, record| bits | (record ^ records[0])) & !time;
            // Of one channel, so that records rise as their times do.
            let falls = records.windows(2).fold(false, |falls, two| falls | (two[1] < two[0]));
            if differ == 0 && !falls && channel < inputs {
                sink.run(&ticks, Channel::Input(channel as u16 + 1));
            } else {
                records.iter().for_each(|&record| self.one(record, sink));
            }
        }
        runs.remainder().chunks_exact(4).for_each(|four| self.one(record(four), sink));
    }

    fn one(&mut self, record: u32, sink: &mut impl Sink) {
        match self.kind {
            Kind::PicoHarp => self.picoharp(record, sink),
            Kind::HydraHarp1 => self.hydraharp(record, HYDRAHARP_1_OVERFLOW, sink),
            Kind::HydraHarp2 => self.hydraharp(record, HYDRAHARP_2_OVERFLOW, sink),
        }
    }

    fn picoharp(&mut self, record: u32, sink: &mut impl Sink) {
        let (channel, time) = (record >> 28, u64::from(record & 0x0FFF_FFFF));
        if channel != 15 {
            sink.tag(self.base + time, Channel::Input(channel as u16 + 1));
            return;
        }
        match record & 15 {
            0 => self.base += PICOHARP_OVERFLOW,
            // The marker's bits are the lowest of its time, which is no finer than them.
            bits => markers(bits, self.base + time, sink),
        }
    }

    fn hydraharp(&mut self, record: u32, overflow: u64, sink: &mut impl Sink) {
        let (channel, time) = ((record >> 25) & 63, u64::from(record & 0x01FF_FFFF));
        if record >> 31 == 0 {
            sink.tag(self.base + time, Channel::Input(channel as u16 + 1));
            return;
        }
        match channel {
            63 if overflow == HYDRAHARP_2_OVERFLOW => self.base += overflow * time.max(1),
            63 => self.base += overflow,
            0 => sink.tag(self.base + time, Channel::Sync),
            bits => markers(bits & 15, self.base + time, sink),
        }
    }
}

/// A record for each of the four marker inputs that a record has.
fn markers(bits: u32, ticks: u64, sink: &mut impl Sink) {
    for marker in (0..4).filter(|marker| bits >> marker & 1 == 1) {
        sink.tag(ticks, Channel::Marker(marker + 1));
    }
}
