//! A clock as a testbench tells it: the bits of all its ports one behind the other,
//! lowest first, in whole words of 64 bits.

use super::BatchError;
use crate::reference::host_ports::HostInputs;
use crate::sensor::Sensor;
use crate::sensor::interface::Interface;
use crate::sensor::layout::{Layout, mask};
use crate::sensor::port::{Port, PortRole, Use};

/// A port of the testbench, whose bits stand behind those of the port before it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TestbenchPort {
    /// Its name in the interface.
    pub name: String,
    /// Bits that it has in the testbench's record. Of an output that this scene's sensor
    /// does not have they mean nothing.
    pub width: u32,
}

/// Takes the testbench's records apart.
#[derive(Debug, Clone)]
pub(super) struct RecordReader {
    /// Words of a clock.
    pub(super) words: usize,
    reset_at: u32,
    ready_at: u32,
    samples_at: u32,
    /// Bits of one input's samples.
    samples: u32,
    inputs: u32,
    /// Ports that a host drives: where they are, and their bits.
    host: Vec<(PortRole, u32, u32)>,
    outputs: Vec<Piece>,
    output_words: usize,
}

/// Bits that lie one behind the other in both records.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Piece {
    from: u32,
    to: u32,
    width: u32,
}

impl RecordReader {
    /// Of a testbench with these ports.
    ///
    /// # Errors
    /// When they are not those of the sensor.
    pub(super) fn new(
        sensor: &Sensor,
        layout: &Layout,
        ports: &[TestbenchPort],
    ) -> Result<RecordReader, BatchError> {
        let interface = sensor.interface();
        check(sensor, ports)?;
        let place_of = |role: PortRole| {
            let before = ports.iter().take_while(|port| port.name != role.name());
            before.map(|port| port.width).sum()
        };
        let mut outputs: Vec<Piece> = Vec::new();
        for field in &layout.outputs.fields {
            let from: u32 = place_of(field.port.role);
            let to = field.word as u32 * 64 + field.shift;
            for at in (0..field.port.width).step_by(64) {
                let piece =
                    Piece { from: from + at, to: to + at, width: (field.port.width - at).min(64) };
                match outputs.last_mut() {
                    Some(last) if last.is_continued_by(piece) => last.width += piece.width,
                    _ => outputs.push(piece),
                }
            }
        }
        let bits: u32 = ports.iter().map(|port| port.width).sum();
        Ok(RecordReader {
            words: bits.div_ceil(64) as usize,
            reset_at: place_of(PortRole::Reset),
            ready_at: place_of(PortRole::Ready),
            samples_at: place_of(PortRole::Samples),
            samples: interface.lanes(),
            inputs: interface.inputs() as u32,
            host: needed(interface)
                .filter(|port| port.role.usage() == Use::Host)
                .map(|port| (port.role, place_of(port.role), port.width))
                .collect(),
            outputs,
            output_words: layout.outputs.words,
        })
    }

    /// Adds a clock's inputs, and its outputs' record, to those of the clocks before.
    #[inline]
    pub fn read(&self, record: &[u64], clocks: &mut Clocks) {
        clocks.reset.push(bits(record, self.reset_at, 1) as u8);
        clocks.ready.push(bits(record, self.ready_at, 1) as u8);
        for input in 0..self.inputs {
            let at = self.samples_at + input * self.samples;
            clocks.samples.push(bits(record, at, self.samples));
        }
        if !self.host.is_empty() {
            let mut driven = HostInputs::default();
            for &(role, at, width) in &self.host {
                driven.set(role, bits(record, at, width));
            }
            clocks.host.push(driven);
        }
        let start = clocks.got.len();
        clocks.got.resize(start + self.output_words, 0);
        let got = &mut clocks.got[start..];
        for piece in &self.outputs {
            let (word, shift) = ((piece.to / 64) as usize, piece.to % 64);
            got[word] |= bits(record, piece.from, piece.width) << shift;
        }
    }
}

impl Piece {
    /// Whether bits follow these in both records, within the same word of the outputs.
    fn is_continued_by(self, next: Piece) -> bool {
        self.from + self.width == next.from
            && self.to + self.width == next.to
            && self.to / 64 == (next.to + next.width - 1) / 64
    }
}

/// Clocks that have not been compared yet.
#[derive(Debug, Clone, Default)]
pub(super) struct Clocks {
    pub(super) samples: Vec<u64>,
    pub(super) reset: Vec<u8>,
    pub(super) ready: Vec<u8>,
    pub(super) host: Vec<HostInputs>,
    pub(super) got: Vec<u64>,
}

impl Clocks {
    /// Takes all clocks of others behind its own.
    pub(super) fn append(&mut self, others: &mut Clocks) {
        self.samples.append(&mut others.samples);
        self.reset.append(&mut others.reset);
        self.ready.append(&mut others.ready);
        self.host.append(&mut others.host);
        self.got.append(&mut others.got);
    }

    pub(super) fn clear(&mut self) {
        self.samples.clear();
        self.reset.clear();
        self.ready.clear();
        self.host.clear();
        self.got.clear();
    }
}

/// `width` bits of a record, 1 to 64, from bit `at` on.
#[inline]
fn bits(record: &[u64], at: u32, width: u32) -> u64 {
    let (word, shift) = ((at / 64) as usize, at % 64);
    let mut value = record[word] >> shift;
    if shift + width > 64 {
        value |= record[word + 1] << (64 - shift);
    }
    value & mask(width)
}

/// The ports that a testbench has to have: all but the clock.
fn needed(interface: &Interface) -> impl Iterator<Item = Port> {
    let ports = interface.ports().into_iter();
    ports.filter(|port| port.role != PortRole::Clock)
}

fn check(sensor: &Sensor, ports: &[TestbenchPort]) -> Result<(), BatchError> {
    let scene = || sensor.scene().name.clone();
    for (number, port) in ports.iter().enumerate() {
        if ports[..number].iter().any(|other| other.name == port.name) {
            return Err(BatchError::PortTwice(port.name.clone()));
        }
        let mut known = needed(sensor.interface());
        match known.find(|known| known.name == port.name) {
            Some(known) if known.width != port.width => {
                return Err(BatchError::Width {
                    port: port.name.clone(),
                    found: port.width,
                    expected: known.width,
                    scene: scene(),
                });
            }
            // Other scenes' sensors may have it.
            None if PortRole::of(&port.name).is_none_or(|role| role == PortRole::Clock) => {
                let names: Vec<String> = needed(sensor.interface()).map(|p| p.name).collect();
                return Err(BatchError::UnknownPort {
                    port: port.name.clone(),
                    known: names.join(", "),
                });
            }
            _ => {}
        }
    }
    let is_there = |port: &Port| ports.iter().any(|other| other.name == port.name);
    match needed(sensor.interface()).find(|port| !is_there(port)) {
        None => Ok(()),
        Some(port) => Err(BatchError::MissingPort { port: port.name, scene: scene() }),
    }
}
