//! A scene on a board: gears, clocks and pins, each checked against what the board can do.

use std::str::FromStr;

use goldtof_wire::Pace;
use serde::Serialize;

use super::error::BoardError;
use super::pll::{Dividers, Frequency};
use super::table::{Board, DeviceFamily, FamilyFolder, Gear, GearPads, Pad, Pin, Side};
use crate::scene::SceneText;
use crate::sensor::Sensor;
use crate::wire::{ScanSums, Sent, SerialLine, check_line};

/// By how much a PLL may miss the chip period that the scene asks for.
const MOST_DEVIATION: f64 = 0.01;
/// By how much a UART may miss its bit rate: a tenth of a bit at the end of a byte's ten.
const MOST_BAUD_DEVIATION: f64 = 0.01;
/// One tap of DELAYG in picoseconds (Lattice FPGA-DS-02012), and the last.
const TAP_PS: f64 = 25.0;
const LAST_TAP: u32 = 127;
/// Fewest clocks of a bit that the bridge takes, and that a clock made for it has: a bit is looked at in
/// its middle to within half of one.
const LEAST_CLOCKS_PER_BIT: u32 = 4;
const CLOCKS_PER_BIT: std::ops::RangeInclusive<u32> = 8..=33;

/// A pin that the user chooses: `i_detector[0]=H4`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PinChoice {
    /// Port of the board's top.
    pub port: String,
    /// Site of the device.
    pub site: String,
}

impl FromStr for PinChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<PinChoice, String> {
        let parts = text.split_once('=').map(|(port, site)| (port.trim(), site.trim()));
        match parts {
            Some((port, site)) if !port.is_empty() && !site.is_empty() => {
                Ok(PinChoice { port: port.to_owned(), site: site.to_owned() })
            }
            _ => Err("write port and pin, for example i_detector[0]=H4".to_owned()),
        }
    }
}

/// A scene on a board.
#[derive(Debug, Clone)]
pub struct BoardPlan {
    /// The board.
    pub board: &'static Board,
    /// How a detector's samples come about.
    pub gear: &'static Gear,
    /// Of the PLL.
    pub dividers: Dividers,
    /// Edge, bit or core clock.
    pub fast: Frequency,
    /// The clock of which one cycle is one chip.
    pub chip: Frequency,
    /// The line's clock.
    pub uart: UartClock,
    /// Taps of the second pin's delay; 0 where there is none.
    pub delay_taps: u32,
    /// The chip period of the scene, in picoseconds.
    pub asked_chip_period_ps: f64,
    /// Share of the line to the host that results take.
    pub line_use_fraction: f64,
    /// All ports of the top.
    pub pins: Vec<Assigned>,
}

/// The clock of the line to the host.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct UartClock {
    /// The divider between the PLL's VCO and it; without one it is the oscillator.
    pub pll_divider: Option<u32>,
    /// Its frequency.
    pub clock: Frequency,
    /// Cycles of it in a bit.
    pub clocks_per_bit: u32,
}

impl UartClock {
    /// Bits per second.
    pub fn baud(self) -> f64 {
        self.clock.hz() / f64::from(self.clocks_per_bit)
    }

    /// Of the line that it makes on a board of so many bits per second.
    pub fn pace(self, baud: u32) -> Pace {
        Pace { baud, clocks_per_bit: self.clocks_per_bit }
    }

    /// Lengths of a host's bits with which each byte is received, wherever its edges fall between the clock's, in bits of a
    /// line of so many bits per second.
    ///
    /// `uart_receiver.v` looks at a byte's ten bits, of which it sees the first edge up to a clock late, half a bit behind
    /// that edge and then once a bit. The last one, the stop bit, ends the range on both sides: a longer one has not begun
    /// where it is looked for, a shorter one is over.
    pub fn host_bits(self, baud: u32) -> std::ops::RangeInclusive<f64> {
        let clocks = f64::from(self.clocks_per_bit);
        let half = f64::from(self.clocks_per_bit / 2);
        // In clocks from the edge.
        let [shortest, longest] = [(half + 1.0 + 9.0 * clocks) / 10.0, (half + 9.0 * clocks) / 9.0];
        let bits = f64::from(baud) / self.clock.hz();
        shortest * bits..=longest * bits
    }

    fn deviation(self, baud: u32) -> f64 {
        (self.baud() / f64::from(baud) - 1.0).abs()
    }

    fn of(clock: Frequency, pll_divider: Option<u32>, baud: u32) -> UartClock {
        let clocks = (clock.hz() / f64::from(baud)).round() as u32;
        UartClock { pll_divider, clock, clocks_per_bit: clocks.max(LEAST_CLOCKS_PER_BIT) }
    }
}

/// A port of the top, and its pin.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Assigned {
    /// The port, without a number.
    pub bus: &'static str,
    /// Number of the bit, of a bus.
    pub bit: Option<u32>,
    /// The pin.
    pub pin: Pin,
    /// What is at it.
    pub role: PinRole,
}

/// What is at a pin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PinRole {
    /// The board's oscillator.
    Oscillator,
    /// Another input.
    Input,
    /// A detector, whose gear the pin needs.
    Detector,
    /// An output.
    Output,
}

impl Assigned {
    /// The port as Verilog names it: `o_laser[0]`.
    pub fn port(&self) -> String {
        match self.bit {
            Some(bit) => format!("{}[{bit}]", self.bus),
            None => self.bus.to_owned(),
        }
    }
}

impl BoardPlan {
    /// The sensor of a scene on a board, with pins that the user chooses.
    ///
    /// # Errors
    /// What the board cannot do, and what it can.
    pub fn of(
        sensor: &Sensor,
        board: &'static Board,
        choices: &[PinChoice],
    ) -> Result<BoardPlan, BoardError> {
        check_cells(sensor, board)?;
        let gear = gear_of(sensor, board)?;
        let asked_chip_period_ps = sensor.clock().chip_period_ps;
        check_speed(asked_chip_period_ps, gear, board)?;
        let dividers = dividers_of(asked_chip_period_ps, gear, board)?;
        let fast = dividers.output(&board.family.pll, board.oscillator_hz);
        let chip = fast.over(gear.fast_clocks);
        let delay_taps = delay_taps(chip.period_ps(), gear)?;
        let pins = pins_of(sensor, gear, board, choices)?;
        let uart = uart_of(board, dividers);
        let line = SerialLine { pace: uart.pace(board.baud), block_ram: board.block_ram() };
        check_sums(sensor, board, &line)?;
        let load = check_line(sensor.interface(), Sent::Results, &line)
            .map_err(|line| BoardError(format!("{}: {line}", board.title)))?
            .ok_or_else(|| {
                BoardError(format!(
                    "a result of this scene, or its scan, is too large for the bridge to {} \
                     (docs/wire.md); use a narrower counter_width, or fewer phase steps",
                    board.title
                ))
            })?;
        Ok(BoardPlan {
            board,
            gear,
            dividers,
            fast,
            chip,
            uart,
            delay_taps,
            asked_chip_period_ps,
            line_use_fraction: load.share(),
            pins,
        })
    }

    /// The scene with the chip period that the PLL makes, to the last digit.
    pub fn achieved(&self, scene: SceneText) -> SceneText {
        let achieved_ps = self.chip.period_ps();
        if achieved_ps == self.asked_chip_period_ps {
            return scene;
        }
        scene.with_chip_period(&format!("{achieved_ps} ps"))
    }
}

/// Whether each detector has one input.
fn check_cells(sensor: &Sensor, board: &'static Board) -> Result<(), BoardError> {
    match sensor.interface().input_cells.count {
        1 => Ok(()),
        cells => Err(BoardError(format!(
            "detector.cell_outputs is \"separate\", and {} has pins for detectors with one output, not for \
             {cells}; leave out the key, and combine the cells before the pins",
            board.title
        ))),
    }
}

/// Whether the board can make the sums that the scene asks for, and its device has memory for them.
fn check_sums(sensor: &Sensor, board: &'static Board, line: &SerialLine) -> Result<(), BoardError> {
    let interface = sensor.interface();
    if interface.accumulate == 1 {
        return Ok(());
    }
    let title = board.title;
    let sums = ScanSums::of(interface, line.pace).ok_or_else(|| {
        BoardError(format!(
            "accumulate = {}: {title} adds up scans of 4 to 16384 results of up to 128 bits a sum, and \
             this scene has {} phase steps of {} detector(s); scan fewer steps, or integrate for longer",
            interface.accumulate,
            interface.timing.scan.steps,
            interface.reference_codes.len()
        ))
    })?;
    let (blocks, most) = (sums.blocks(&line.block_ram), line.block_ram.blocks);
    if blocks > most {
        return Err(BoardError(format!(
            "the sums of this scan, and the FIFO behind them, take {blocks} {}, and {title} has {most}; \
             scan fewer steps, or leave out hardware.accumulate and integrate for longer",
            line.block_ram.name
        )));
    }
    Ok(())
}

/// Samples per chip of the scene, by the board's pins.
fn gear_of(sensor: &Sensor, board: &'static Board) -> Result<&'static Gear, BoardError> {
    let samples = sensor.clock().samples_per_chip;
    let gears = board.family.gears;
    let possible = |gear: &Gear| {
        let pins = if gear.pins == 1 { "one pin" } else { "two pins" };
        format!("{} with {pins} for each detector ({})", gear.samples, gear.cells)
    };
    gears.iter().find(|gear| gear.samples == samples).ok_or_else(|| {
        BoardError(format!(
            "clock.samples_per_chip is {samples}, and the pins of {} make {}; write one of these, or take \
             another board",
            board.title,
            gears.iter().map(possible).collect::<Vec<String>>().join(" or ")
        ))
    })
}

/// Holds rates against what the device is specified for, and the fabric was built at.
fn check_speed(chip_period_ps: f64, gear: &Gear, board: &'static Board) -> Result<(), BoardError> {
    let family = board.family;
    let chip_mhz = 1e6 / chip_period_ps;
    let pin_samples = f64::from(gear.samples / gear.pins);
    let fast_clocks = f64::from(gear.fast_clocks);
    let limits = [
        ("a rate at its pin", "Mb/s", pin_samples, family.gear_mbps, family.gear_source),
        ("a clock at its gear", "MHz", fast_clocks, family.fast_mhz, family.gear_source),
        ("a core clock", "MHz", 1.0, board.built_mhz, "as built, docs/bench.md"),
    ];
    let over = |&(_, _, per_chip, most, _): &(_, _, f64, f64, _)| {
        // An achieved period may be a little shorter than the one that was asked for.
        chip_mhz * per_chip > most * (1.0 + MOST_DEVIATION)
    };
    let Some((what, unit, per_chip, most, source_name)) = limits.into_iter().find(over) else {
        return Ok(());
    };
    let lower = family.gears.iter().filter(|other| other.samples < gear.samples).find(|other| {
        chip_mhz * f64::from(other.samples / other.pins) <= family.gear_mbps
            && chip_mhz * f64::from(other.fast_clocks) <= family.fast_mhz
            && chip_mhz <= board.built_mhz
    });
    let fewer =
        lower.map_or_else(String::new, |other| format!(", or {} samples per chip", other.samples));
    Err(BoardError(format!(
        "a chip of {} ns is {what} of {} {unit}, and {} takes at most {} {unit} ({source_name}); use a chip \
         of {} ns or longer{fewer}",
        nanoseconds(chip_period_ps),
        rounded(chip_mhz * per_chip),
        board.title,
        rounded(most),
        nanoseconds((1e5 * per_chip / most).ceil() * 10.0),
    )))
}

/// The PLL's dividers for a chip period.
fn dividers_of(
    chip_period_ps: f64,
    gear: &Gear,
    board: &'static Board,
) -> Result<Dividers, BoardError> {
    let pll = &board.family.pll;
    let fast_hz = 1e12 / chip_period_ps * f64::from(gear.fast_clocks);
    let nearest = pll.nearest(board.oscillator_hz, fast_hz);
    let achieved_ps = nearest.map(|dividers| {
        dividers.output(pll, board.oscillator_hz).over(gear.fast_clocks).period_ps()
    });
    match (nearest, achieved_ps) {
        (Some(dividers), Some(achieved_ps))
            if (achieved_ps / chip_period_ps - 1.0).abs() <= MOST_DEVIATION =>
        {
            Ok(dividers)
        }
        _ => Err(BoardError(format!(
            "the PLL of {} ({}; {}) makes no chip within 1 % of {} ns from {} MHz; {}",
            board.title,
            pll.name,
            pll.source,
            nanoseconds(chip_period_ps),
            board.oscillator_hz as f64 / 1e6,
            achieved_ps.map_or_else(
                || "its ranges leave none".to_owned(),
                |ps| format!("the nearest is {} ns", nanoseconds(ps)),
            ),
        ))),
    }
}

/// A clock for the line: the oscillator, or an output of the PLL.
fn uart_of(board: &Board, dividers: Dividers) -> UartClock {
    let oscillator = UartClock::of(Frequency::new(board.oscillator_hz, 1), None, board.baud);
    let has_second_output = board.family.folder == FamilyFolder::Ecp5;
    if !has_second_output {
        return oscillator;
    }
    let vco = dividers.vco(&board.family.pll, board.oscillator_hz);
    let of_pll = board
        .family
        .pll
        .output_dividers
        .iter()
        .map(|&divider| UartClock::of(vco.over(divider), Some(divider), board.baud));
    let fitting = of_pll.filter(|uart| {
        CLOCKS_PER_BIT.contains(&uart.clocks_per_bit)
            && board.family.pll.output_mhz.contains(&uart.clock.mhz())
            && uart.deviation(board.baud) <= MOST_BAUD_DEVIATION
    });
    // Of those that are as good the slowest: the bridge's logic is not to set the pace.
    fitting
        .min_by(|a, b| {
            let by_rate = a.deviation(board.baud).total_cmp(&b.deviation(board.baud));
            by_rate.then(a.clock.hz().total_cmp(&b.clock.hz()))
        })
        .unwrap_or(oscillator)
}

/// Taps of the delay of a sample period.
fn delay_taps(chip_period_ps: f64, gear: &Gear) -> Result<u32, BoardError> {
    if gear.pins == 1 {
        return Ok(0);
    }
    let sample_ps = chip_period_ps / f64::from(gear.samples);
    let taps = (sample_ps / TAP_PS).round();
    if taps > f64::from(LAST_TAP) {
        return Err(BoardError(format!(
            "the second pin of a detector needs a delay of {} ns, and DELAYG has {LAST_TAP} taps of about 25 ps \
             (Lattice FPGA-DS-02012); use a chip of {} ns or shorter, or {} samples per chip, which one pin \
             makes",
            nanoseconds(sample_ps),
            nanoseconds(f64::from(LAST_TAP) * TAP_PS * f64::from(gear.samples)),
            gear.samples / gear.pins,
        )));
    }
    Ok(taps as u32)
}

/// All ports' pins.
fn pins_of(
    sensor: &Sensor,
    gear: &Gear,
    board: &'static Board,
    choices: &[PinChoice],
) -> Result<Vec<Assigned>, BoardError> {
    let scene = sensor.scene();
    let detectors = bus(
        ("i_detector", "detectors", PinRole::Detector),
        (scene.detectors.len(), gear.pins),
        board.detectors,
        board,
    )?;
    let lasers =
        bus(("o_laser", "lasers", PinRole::Output), (scene.sources.len(), 1), board.lasers, board)?;
    let alone = |bus, pin, role| Assigned { bus, bit: None, pin, role };
    let mut all = vec![
        alone("i_oscillator", board.oscillator, PinRole::Oscillator),
        alone("i_rx", board.rx, PinRole::Input),
        alone("o_tx", board.tx, PinRole::Output),
        alone("o_led", board.led.0, PinRole::Output),
    ];
    if let Some((pin, ..)) = board.held {
        all.push(alone("o_held", pin, PinRole::Output));
    }
    all.extend(detectors);
    all.extend(lasers);
    for choice in choices {
        choose(choice, &mut all, board)?;
    }
    check_pins(&all, board)?;
    Ok(all)
}

/// A bus of so many members with so many pins each, at the first of the sites.
fn bus(
    (bus, what, role): (&'static str, &'static str, PinRole),
    (members, pins_each): (usize, u32),
    sites: &'static [&'static str],
    board: &'static Board,
) -> Result<Vec<Assigned>, BoardError> {
    let needed = members * pins_each as usize;
    if needed > sites.len() {
        return Err(BoardError(format!(
            "the scene has {members} {what}, and {} has pins for {}: {}",
            board.title,
            sites.len() / pins_each as usize,
            sites.join(", "),
        )));
    }
    let pins = sites.iter().filter_map(|site| board.pin(site));
    let numbered = pins.take(needed).zip(0..);
    Ok(numbered.map(|(pin, bit)| Assigned { bus, bit: Some(bit), pin, role }).collect())
}

/// Moves a port to the pin that the user chooses.
fn choose(
    choice: &PinChoice,
    all: &mut [Assigned],
    board: &'static Board,
) -> Result<(), BoardError> {
    let movable = |assigned: &Assigned| assigned.bit.is_some();
    let ports: Vec<String> =
        all.iter().filter(|assigned| movable(assigned)).map(Assigned::port).collect();
    let error =
        |problem, possible| refused_pin(board, (&choice.port, &choice.site), problem, possible);
    let found = all.iter_mut().find(|assigned| movable(assigned) && assigned.port() == choice.port);
    let Some(assigned) = found else {
        return Err(error("the top has no such port to move", ports.join(", ")));
    };
    let Some(pin) = board.pin(&choice.site) else {
        let sites: Vec<&str> = board.pins.iter().map(|pin| pin.site).collect();
        return Err(error("no such pin at a connector", sites.join(", ")));
    };
    assigned.pin = pin;
    Ok(())
}

/// A port that cannot be at a site, and what would do.
fn refused_pin(
    board: &Board,
    (port, site): (&str, &str),
    problem: &str,
    possible: String,
) -> BoardError {
    BoardError(format!("--pin {port}={site}: {problem}; {} has {possible}", board.title))
}

/// Whether each pin can do what it is for, and is used once.
fn check_pins(all: &[Assigned], board: &'static Board) -> Result<(), BoardError> {
    let error = |assigned: &Assigned, problem: String, possible: String| {
        refused_pin(board, (&assigned.port(), assigned.pin.site), &problem, possible)
    };
    let with_gear = |side: Option<Side>| -> String {
        let sites: Vec<&str> = board
            .pins
            .iter()
            .filter(|pin| has_gear(board.family, pin.pad, side))
            .map(|pin| pin.site)
            .collect();
        format!("{} for detectors", sites.join(", "))
    };
    let detectors: Vec<&Assigned> =
        all.iter().filter(|assigned| assigned.role == PinRole::Detector).collect();
    for (nth, assigned) in all.iter().enumerate() {
        if let Some(other) = all[..nth].iter().find(|other| other.pin.site == assigned.pin.site) {
            return Err(error(
                assigned,
                format!("{} is there", other.port()),
                board.pins.iter().map(|pin| pin.site).collect::<Vec<&str>>().join(", "),
            ));
        }
    }
    for assigned in &detectors {
        if !has_gear(board.family, assigned.pin.pad, None) {
            let problem = format!(
                "there is no {} at it ({})",
                board.family.gears[0].cells,
                where_is(assigned.pin.pad)
            );
            return Err(error(assigned, problem, with_gear(None)));
        }
    }
    let side = detectors.first().and_then(|first| first.pin.pad).map(|pad| pad.side);
    for assigned in &detectors {
        if !has_gear(board.family, assigned.pin.pad, side) {
            return Err(error(
                assigned,
                "one edge clock reaches one side of the device, and another detector is at the \
                 other"
                    .to_owned(),
                with_gear(side),
            ));
        }
    }
    check_pairs(all, board, error)
}

/// A gear of Gowin takes both pads of a pair: no other port's cell can be at the second.
fn check_pairs(
    all: &[Assigned],
    board: &'static Board,
    error: impl Fn(&Assigned, String, String) -> BoardError,
) -> Result<(), BoardError> {
    let GearPads::FirstOfPair = board.family.gear_pads else {
        return Ok(());
    };
    let detectors = all.iter().filter(|assigned| assigned.role == PinRole::Detector);
    for detector in detectors {
        let second = board
            .pins
            .iter()
            .skip_while(|pin| pin.site != detector.pin.site)
            .nth(1)
            .filter(|pin| pin.pad.is_some_and(|pad| pad.letter == 'B'));
        let taken = second.and_then(|second| all.iter().find(|other| other.pin == *second));
        if let Some(other) = taken {
            let problem = format!("the gear of {} takes this pad, too", detector.port());
            let free: Vec<&str> =
                board.lasers.iter().copied().filter(|site| *site != other.pin.site).collect();
            return Err(error(other, problem, free.join(", ")));
        }
    }
    Ok(())
}

/// Whether a pad has a gear, and is on that side.
fn has_gear(family: &DeviceFamily, pad: Option<Pad>, side: Option<Side>) -> bool {
    match (family.gear_pads, pad) {
        (GearPads::Any, _) => true,
        (_, None) => false,
        (GearPads::FirstOfPair, Some(pad)) => pad.letter == 'A',
        (GearPads::OnOneSide(letters), Some(pad)) => {
            letters.contains(&pad.letter)
                && side
                    .map_or(matches!(pad.side, Side::Left | Side::Right), |side| side == pad.side)
        }
    }
}

fn where_is(pad: Option<Pad>) -> String {
    pad.map_or_else(String::new, |pad| format!("pad {} on the {:?} side", pad.letter, pad.side))
}

/// Picoseconds as nanoseconds, to the femtosecond.
fn nanoseconds(ps: f64) -> f64 {
    (ps * 1e3).round() / 1e6
}

fn rounded(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}

#[cfg(test)]
mod tests {
    use super::{CLOCKS_PER_BIT, Frequency, LEAST_CLOCKS_PER_BIT, UartClock};

    /// With the worst of both: a stop bit behind a low bit, and a start bit right behind it.
    const BYTES: [u8; 4] = [0x00, 0xff, 0x55, 0x2a];

    /// What `uart_receiver.v` with so many clocks in a bit makes of the bytes, register by register: none without a stop
    /// bit. Bits take `bit` clocks, and the first one begins `early` clocks before an edge.
    fn received(clocks_per_bit: u32, bit: f64, early: f64) -> Vec<Option<u8>> {
        let level = |clock: u32| {
            let at = (f64::from(clock) + early - 40.0) / bit;
            let slot = at.rem_euclid(10.0) as usize;
            match BYTES.get((at / 10.0) as usize) {
                Some(byte) if at >= 0.0 && slot < 9 => slot > 0 && byte >> (slot - 1) & 1 == 1,
                _ => true,
            }
        };
        let (mut meta, mut rx, mut busy, mut timer, mut slot) = (true, true, false, 0, 15_u8);
        let (mut bytes, mut byte) = (Vec::new(), 0);
        for clock in 0..60 * clocks_per_bit {
            let (tick, start) = (timer == 0, !busy && !rx);
            if busy && tick && slot < 8 {
                byte |= u8::from(rx) << slot;
            }
            if busy && tick && slot == 8 {
                bytes.push(rx.then_some(std::mem::take(&mut byte)));
            }
            timer = match (start, tick) {
                (true, _) => clocks_per_bit / 2 - 1,
                (_, true) => clocks_per_bit - 1,
                _ => timer - 1,
            };
            let next_slot = if !busy { 15 } else { (slot + u8::from(tick)) % 16 };
            busy = start || if tick && slot >= 8 { slot == 15 && !rx } else { busy };
            (slot, rx, meta) = (next_slot, meta, level(clock));
        }
        bytes
    }

    #[test]
    fn a_host_at_the_limits_is_received_and_none_beyond_them() {
        let sent = BYTES.map(Some);
        for clocks_per_bit in [LEAST_CLOCKS_PER_BIT, 5, 8, 9, 16, *CLOCKS_PER_BIT.end(), 50] {
            let clock = Frequency::new(3_000_000 * u64::from(clocks_per_bit), 1);
            let uart = UartClock { pll_divider: None, clock, clocks_per_bit };
            let is_received = |bit: f64| {
                let clocks = bit * f64::from(clocks_per_bit);
                (0..100)
                    .all(|early| received(clocks_per_bit, clocks, f64::from(early) / 100.0) == sent)
            };
            let limits = uart.host_bits(3_000_000);
            for (limit, out) in [(*limits.start(), -0.002), (*limits.end(), 0.002)] {
                assert!(is_received(limit - out), "{clocks_per_bit}: {limit}");
                assert!(!is_received(limit + out), "{clocks_per_bit}: {limit}");
            }
        }
    }
}
