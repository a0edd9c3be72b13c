//! The ports clock by clock, as the reference model has them: WaveJSON and its drawing.

use std::ops::Range;

use serde::Serialize;

use super::prelude::*;
use crate::photons::DetectorModel;
use crate::reference::blocks::{Block, BlockMaker};
use crate::reference::photons::Photons;
use crate::reference::predictor::{ReferenceError, ReferenceModel};
use crate::reference::stimulus::RESET_CLOCKS;
use crate::sensor::layout::{Field, Layout};
use crate::sensor::port::PortRole;

/// Clocks that are drawn.
const COLUMNS: u64 = 16;
/// The first result is not waited for any longer.
const MOST_CLOCKS: u64 = 4_000_000;

const WIDTH: f64 = 480.0;
const NAMES: f64 = 126.0;
const ROW: f64 = 24.0;
const TOP: f64 = 22.0;
const HIGH: f64 = 14.0;
/// Width of a character of a value.
const CHARACTER: f64 = 5.6;

/// A stretch of clocks in WaveJSON, as WaveDrom and others read it: column t has the
/// inputs of clock t, which the edge at its end takes, and the outputs since the edge at
/// its start.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Wave {
    /// The ports.
    pub signal: Vec<TimingSignal>,
    /// Title and number of the first clock.
    pub head: Head,
}

/// A port.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct TimingSignal {
    /// Its name.
    pub name: String,
    /// A character for each clock: 0, 1, `=` for a new value, `.` for the same.
    pub wave: String,
    /// The values of those `=`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub data: Vec<String>,
}

/// Title and number of the first clock.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Head {
    /// What is shown.
    pub text: String,
    /// Number of the first column's clock, from the start of the run.
    pub tick: u64,
}

/// The start of a run, and the first result on the stream where it is soon enough.
///
/// # Errors
/// When there is no reference model of this sensor.
pub fn waves(sensor: &Sensor, seed: u64) -> Result<Vec<Wave>, ReferenceError> {
    let interface = sensor.interface();
    let latency = u64::from(interface.result_latency_clocks);
    let integration = sensor.timing().scan.integration_chips;
    let first_result = (RESET_CLOCKS + interface.lead_clocks())
        .saturating_add(integration)
        .saturating_add(latency);
    let mut wanted = vec![("Start: the lasers begin when reset ends", 0..COLUMNS)];
    if first_result < MOST_CLOCKS {
        let from = (first_result + 5).saturating_sub(COLUMNS).max(1);
        let title = match interface.histogram() {
            Some(_) => "First result: a row of the histogram",
            None => "First result: a phase step's count",
        };
        wanted.push((title, from..from + COLUMNS));
    }
    let last = wanted.last().map_or(0, |(_, clocks)| clocks.end);
    let recorded = record(sensor, seed, last, wanted.iter().map(|w| w.1.clone()))?;
    let drawn = wanted.into_iter().zip(recorded);
    Ok(drawn.map(|((title, clocks), rows)| wave(sensor, title, clocks.start, &rows)).collect())
}

/// One clock: its inputs, and the outputs before its edge.
struct ClockRecord {
    inputs: Vec<u64>,
    outputs: Vec<u64>,
}

fn record(
    sensor: &Sensor,
    seed: u64,
    clocks: u64,
    wanted: impl Iterator<Item = Range<u64>>,
) -> Result<Vec<Vec<ClockRecord>>, ReferenceError> {
    let layout = Layout::of(sensor.interface());
    let detectors = DetectorIndex::of(&sensor.scene().detectors);
    let models: Vec<_> = detectors.map(|d| DetectorModel::new(sensor, d)).collect();
    let mut reference = ReferenceModel::new(sensor.interface().clone())?;
    let mut photons = Photons::new(&models, sensor.interface(), seed);
    let mut maker = BlockMaker::new(&mut reference, &mut photons, &layout, clocks);
    let mut block = Block::default();
    let wanted: Vec<Range<u64>> = wanted.collect();
    let mut found: Vec<Vec<ClockRecord>> = wanted.iter().map(|_| Vec::new()).collect();
    // Nothing is known before the first edge; in reset all outputs are 0.
    let mut before = vec![0; layout.outputs.words];
    while maker.make(&mut block) {
        let inputs = block.records.inputs.chunks_exact(layout.inputs.words);
        let outputs = block.records.expected.chunks_exact(layout.outputs.words);
        for ((clock, inputs), outputs) in block.clocks.clone().zip(inputs).zip(outputs) {
            for (wanted, found) in wanted.iter().zip(&mut found) {
                if wanted.contains(&clock) {
                    found.push(ClockRecord { inputs: inputs.to_vec(), outputs: before.clone() });
                }
            }
            before.copy_from_slice(outputs);
        }
    }
    Ok(found)
}

fn wave(sensor: &Sensor, title: &str, first: u64, rows: &[ClockRecord]) -> Wave {
    let layout = Layout::of(sensor.interface());
    let mut signal = vec![TimingSignal {
        name: Layout::CLOCK.to_owned(),
        wave: ["p"].into_iter().chain((1..rows.len()).map(|_| ".")).collect(),
        data: Vec::new(),
    }];
    let order = sensor.interface().ports();
    for port in order.iter().filter(|port| port.name != Layout::CLOCK) {
        let input = layout.inputs.fields.iter().find(|field| field.port == *port);
        let values: Vec<String> = rows
            .iter()
            .map(|row| match input {
                Some(field) => shown(sensor, field, &row.inputs),
                None => shown(sensor, layout.outputs.field(port.role), &row.outputs),
            })
            .collect();
        signal.push(signal_of(&port.name, port.width, &values));
    }
    Wave { signal, head: Head { text: title.to_owned(), tick: first } }
}

/// A port's value: bits as they are, counts as signed numbers, the rest hexadecimal.
fn shown(sensor: &Sensor, field: &Field, record: &[u64]) -> String {
    let interface = sensor.interface();
    if field.port.width == 1 {
        return field.low_word(record).to_string();
    }
    if field.port.role == PortRole::Data && interface.total().is_none() && field.port.width <= 64 {
        let unused = u64::BITS - field.port.width;
        return ((field.low_word(record) << unused).cast_signed() >> unused).to_string();
    }
    let words = field.read(record);
    let digits = words.iter().rev().map(|word| format!("{word:016x}")).collect::<String>();
    let kept = field.port.width.div_ceil(4) as usize;
    digits[digits.len().saturating_sub(kept)..].to_owned()
}

fn signal_of(name: &str, width: u32, values: &[String]) -> TimingSignal {
    let mut signal = TimingSignal {
        name: match width {
            1 => name.to_owned(),
            width => format!("{name}[{}:0]", width - 1),
        },
        wave: String::new(),
        data: Vec::new(),
    };
    for (index, value) in values.iter().enumerate() {
        if index > 0 && values[index - 1] == *value {
            signal.wave.push('.');
        } else if width == 1 {
            signal.wave += value;
        } else {
            signal.wave.push('=');
            signal.data.push(value.clone());
        }
    }
    signal
}

impl Wave {
    /// Draws it.
    pub(super) fn figure(&self, id: &str) -> SvgFigure {
        let columns = self.signal.iter().map(|signal| signal.wave.len()).max();
        let columns = columns.unwrap_or(1).max(1);
        let column = (WIDTH - NAMES - 6.0) / columns as f64;
        let height = TOP + ROW * self.signal.len() as f64 + 4.0;
        let names: Vec<&str> = self.signal.iter().map(|signal| signal.name.as_str()).collect();
        SvgFigure {
            id: id.to_owned(),
            title: self.head.text.clone(),
            description: format!(
                "Timing diagram of {columns} clocks from clock {} on: {}. Inputs are taken at the edge \
                 that ends a column, outputs change at the one that begins it.",
                self.head.tick,
                names.join(", ")
            ),
            size: (WIDTH, height),
            wide: false,
            content: html! {
                @for number in (0..columns).step_by(4) {
                    @let x = NAMES + column * number as f64;
                    line class="grid" x1=(coordinate(x)) x2=(coordinate(x)) y1=(coordinate(TOP - 6.0))
                        y2=(coordinate(height)) {}
                    (label(x, TOP - 10.0, "start tiny", &(self.head.tick + number as u64).to_string()))
                }
                @for (row, signal) in self.signal.iter().enumerate() {
                    @let y = TOP + ROW * row as f64;
                    (label(NAMES - 6.0, y + 12.0, "end tiny", &signal.name))
                    (signal.drawn(y, column))
                }
            },
        }
    }
}

impl TimingSignal {
    fn drawn(&self, y: f64, column: f64) -> Markup {
        match self.wave.chars().next() {
            Some('p') => clock(y, column, self.wave.len()),
            Some('=') => self.bus(y, column),
            _ => self.bit(y, column),
        }
    }

    fn bit(&self, y: f64, column: f64) -> Markup {
        let mut level = y + HIGH;
        let mut line = Vec::new();
        for (index, value) in self.wave.chars().enumerate() {
            level = match value {
                '0' => y + HIGH,
                '1' => y + 2.0,
                _ => level,
            };
            let x = NAMES + column * index as f64;
            line.extend([(x, level), (x + column, level)]);
        }
        html! { polyline class="wave" points=(points(line)) {} }
    }

    fn bus(&self, y: f64, column: f64) -> Markup {
        let starts: Vec<usize> =
            self.wave.char_indices().filter(|(_, c)| *c == '=').map(|(index, _)| index).collect();
        let ends = starts.iter().skip(1).copied().chain([self.wave.len()]);
        let runs = starts.iter().copied().zip(ends).zip(&self.data);
        html! {
            @for ((start, end), value) in runs {
                @let (x0, x1) = (NAMES + column * start as f64, NAMES + column * end as f64);
                polygon class="bus" points=(points([
                    (x0, y + 8.0), (x0 + 3.0, y + 1.0), (x1 - 3.0, y + 1.0), (x1, y + 8.0),
                    (x1 - 3.0, y + 15.0), (x0 + 3.0, y + 15.0),
                ])) {}
                @if value.chars().count() as f64 * CHARACTER < x1 - x0 - 2.0 {
                    (label((x0 + x1) / 2.0, y + 11.5, "middle tiny", value))
                }
            }
        }
    }
}

fn clock(y: f64, column: f64, columns: usize) -> Markup {
    let edges = (0..columns).flat_map(|index| {
        let x = NAMES + column * index as f64;
        let (high, low, middle) = (y + 2.0, y + HIGH, x + column / 2.0);
        [(x, low), (x, high), (middle, high), (middle, low), (x + column, low)]
    });
    html! { polyline class="wave" points=(points(edges)) {} }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeated_values_are_dots_and_values_of_buses_stand_apart() {
        let values = |texts: &[&str]| texts.iter().map(|&t| t.to_owned()).collect::<Vec<_>>();
        let bit = signal_of("o_laser", 1, &values(&["0", "0", "1", "0"]));
        assert_eq!((bit.name.as_str(), bit.wave.as_str()), ("o_laser", "0.10"));
        let bus = signal_of("i_samples", 8, &values(&["00", "0f", "0f", "00"]));
        assert_eq!((bus.name.as_str(), bus.wave.as_str()), ("i_samples[7:0]", "==.="));
        assert_eq!(bus.data, ["00", "0f", "00"]);
    }
}
