//! The boards: what each has at which pin, and what its device can do. Who adds a board adds a
//! constant here.

use std::ops::RangeInclusive;

use super::error::BoardError;
use super::pll::{Feedback, Pll};
use crate::scene::FpgaTarget;
use crate::sensor::block_ram::{BlockRam, block_ram};

/// A board.
#[derive(Debug)]
pub struct Board {
    /// Name on the command line.
    pub name: &'static str,
    /// Name in prose.
    pub title: &'static str,
    /// Its device's family.
    pub family: &'static DeviceFamily,
    /// The device's name for the tools, as their command lines want it.
    pub device: Device,
    /// Its oscillator.
    pub oscillator_hz: u64,
    /// What it drives.
    pub oscillator: Pin,
    /// From the host.
    pub rx: Pin,
    /// To the host.
    pub tx: Pin,
    /// Bits per second of the line to the host.
    pub baud: u32,
    /// An LED, and the level that lights it.
    pub led: (Pin, bool),
    /// An output that has to have a level for the board to work, if there is one, and why.
    pub held: Option<(Pin, bool, &'static str)>,
    /// Pins at connectors, for detectors and lasers.
    pub pins: &'static [Pin],
    /// Names of those for the detectors, in the order in which they are taken.
    pub detectors: &'static [&'static str],
    /// And for the lasers.
    pub lasers: &'static [&'static str],
    /// The fastest chip clock that was built with timing met, in megahertz.
    pub built_mhz: f64,
}

/// A device, as tools name it.
#[derive(Debug)]
pub struct Device {
    /// The vendor's name.
    pub part: &'static str,
    /// What place and route is told of the device and its package.
    pub place_and_route: &'static str,
    /// What the packer is told.
    pub pack: &'static str,
    /// What openFPGALoader is told of the board.
    pub loader: &'static str,
    /// A text of the device that the PLL's primitive wants, if it wants one.
    pub pll_device: Option<&'static str>,
    /// Blocks of its block RAM.
    pub blocks: u64,
    /// Where the clock divider has to lie for dedicated clock wires, if tools need to be told.
    pub divider_bel: Option<&'static str>,
}

/// What the devices of a family can do.
#[derive(Debug)]
pub struct DeviceFamily {
    /// Name in prose.
    pub name: &'static str,
    /// Folder in hdl/.
    pub folder: FamilyFolder,
    /// Samples per chip, and how a detector's pins make them.
    pub gears: &'static [Gear],
    /// Which pads the gears are at.
    pub gear_pads: GearPads,
    /// Fastest rate of a pin's gear, in megabits per second.
    pub gear_mbps: f64,
    /// Fastest edge, bit or core clock, in megahertz.
    pub fast_mhz: f64,
    /// The vendor's documents that say so.
    pub gear_source: &'static str,
    /// The PLL.
    pub pll: Pll,
}

/// The files of a family.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FamilyFolder {
    /// Lattice ECP5.
    Ecp5,
    /// Gowin.
    Gowin,
    /// Lattice iCE40.
    Ice40,
    /// AMD 7-series.
    Xc7,
}

impl Board {
    /// The device's block RAM: Lattice FPGA-DS-02012 (ECP5), Gowin DS117 and DS226, Lattice FPGA-DS-02008 (iCE40
    /// UltraPlus), AMD DS180 (halves of 36 kbit).
    pub const fn block_ram(&self) -> BlockRam {
        let (like, name) = match self.family.folder {
            FamilyFolder::Ecp5 => (FpgaTarget::Ecp525k6, "DP16KD"),
            // The same shapes as AMD's.
            FamilyFolder::Gowin => (FpgaTarget::Xc7, "BSRAM"),
            FamilyFolder::Ice40 => (FpgaTarget::Ice40Hx8k, "SB_RAM40_4K"),
            FamilyFolder::Xc7 => (FpgaTarget::Xc7, "RAMB18E1"),
        };
        block_ram(like).of_device(name, self.device.blocks)
    }
}

/// How a detector's samples come about.
#[derive(Debug)]
pub struct Gear {
    /// Samples per chip, S.
    pub samples: u32,
    /// Pins that take the detector's signal.
    pub pins: u32,
    /// Cycles of the fast clock in a chip.
    pub fast_clocks: u32,
    /// What it is made of.
    pub cells: &'static str,
}

/// Which pads a family's gears are at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GearPads {
    /// Any.
    Any,
    /// Those of these letters, on the left or the right side, all detectors on one.
    OnOneSide(&'static [char]),
    /// The first of a pair, whose second cannot have a cell of its own then.
    FirstOfPair,
}

/// A pin of the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pin {
    /// Ball or number.
    pub site: &'static str,
    /// What is printed beside it on the board, or what it is.
    pub label: &'static str,
    /// Where it is on the die, of families whose gears are not at every pad.
    pub pad: Option<Pad>,
    /// I/O standard that the bank's supply allows.
    pub standard: &'static str,
}

/// A pad on the die.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pad {
    /// Bank of the I/O.
    pub bank: u32,
    /// Side of the die.
    pub side: Side,
    /// Its letter among its neighbours: A and B are a pair, and so are C and D.
    pub letter: char,
}

/// Side of the die.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Left.
    Left,
    /// Right.
    Right,
    /// Top.
    Top,
    /// Bottom.
    Bottom,
}

use Side::{Bottom, Left, Right, Top};

const fn pin(site: &'static str, label: &'static str, bank: u32, side: Side, letter: char) -> Pin {
    Pin { pad: Some(Pad { bank, side, letter }), ..any_pin(site, label) }
}

/// A pin of a family whose pins are all alike.
const fn any_pin(site: &'static str, label: &'static str) -> Pin {
    Pin { site, label, pad: None, standard: "LVCMOS33" }
}

/// All of them.
pub static BOARDS: [&Board; 7] =
    [&TANG_NANO_20K, &TANG_NANO_9K, &ULX3S_12F, &ULX3S_85F, &COLORLIGHT_I5, &ICEBREAKER, &ARTY_A7];

impl Board {
    /// The board of a name.
    ///
    /// # Errors
    /// If there is none; the message names all.
    pub fn named(name: &str) -> Result<&'static Board, BoardError> {
        BOARDS.into_iter().find(|board| board.name == name).ok_or_else(|| {
            let names = BOARDS.map(|board| board.name).join(", ");
            BoardError(format!("there is no board `{name}`; the boards are {names}"))
        })
    }

    /// The pin of a connector.
    pub fn pin(&self, site: &str) -> Option<Pin> {
        self.pins.iter().find(|pin| pin.site == site).copied()
    }
}

const ONE_TO_128: &[u32] = &{
    let mut all = [0; 128];
    let mut n = 0;
    while n < 128 {
        all[n] = n as u32 + 1;
        n += 1;
    }
    all
};

/// Lattice ECP5, speed grade 6.
pub static ECP5: DeviceFamily = DeviceFamily {
    name: "Lattice ECP5",
    folder: FamilyFolder::Ecp5,
    gears: &[
        Gear { samples: 4, pins: 1, fast_clocks: 2, cells: "IDDRX2F" },
        Gear {
            samples: 8,
            pins: 2,
            fast_clocks: 2,
            cells: "two IDDRX2F, the second behind DELAYG",
        },
    ],
    gear_pads: GearPads::OnOneSide(&['A', 'C']),
    gear_mbps: 624.0,
    fast_mhz: 312.0,
    gear_source: "Lattice FPGA-DS-02012, generic DDRX2 of speed grade 6",
    pll: Pll {
        name: "EHXPLLL",
        feedback: Feedback::Output,
        input_dividers: 1..=128,
        multipliers: 1..=128,
        output_dividers: ONE_TO_128,
        input_mhz: 8.0..=400.0,
        phase_detector_mhz: 10.0..=400.0,
        vco_mhz: 400.0..=800.0,
        output_mhz: 3.125..=400.0,
        source: "Lattice FPGA-DS-02012, sysCLOCK PLL timing",
    },
};

const fn gowin(
    name: &'static str,
    phase_detector_mhz: RangeInclusive<f64>,
    vco_mhz: RangeInclusive<f64>,
    output_mhz: RangeInclusive<f64>,
    source: &'static str,
) -> DeviceFamily {
    DeviceFamily {
        name,
        folder: FamilyFolder::Gowin,
        gears: &[
            Gear { samples: 4, pins: 1, fast_clocks: 2, cells: "IDES4" },
            Gear { samples: 8, pins: 1, fast_clocks: 4, cells: "IDES8" },
        ],
        gear_pads: GearPads::FirstOfPair,
        gear_mbps: 1200.0,
        fast_mhz: 600.0,
        gear_source: source,
        pll: Pll {
            name: "rPLL",
            feedback: Feedback::Output,
            input_dividers: 1..=64,
            multipliers: 1..=64,
            output_dividers: &[2, 4, 8, 16, 32, 48, 64, 80, 96, 112, 128],
            input_mhz: 3.0..=400.0,
            phase_detector_mhz,
            vco_mhz,
            output_mhz,
            source,
        },
    }
}

/// Gowin GW1NR-9, C6/I5.
pub static GW1NR_9: DeviceFamily =
    gowin("Gowin GW1NR-9", 3.0..=400.0, 400.0..=1200.0, 3.125..=600.0, "Gowin DS117, PLL of C6/I5");

/// Gowin GW2AR-18, C8/I7.
pub static GW2AR_18: DeviceFamily = gowin(
    "Gowin GW2AR-18",
    3.0..=500.0,
    500.0..=1250.0,
    3.906_25..=625.0,
    "Gowin DS226, PLL of C8/I7",
);

/// Lattice iCE40 UltraPlus.
pub static ICE40: DeviceFamily = DeviceFamily {
    name: "Lattice iCE40",
    folder: FamilyFolder::Ice40,
    gears: &[Gear { samples: 2, pins: 1, fast_clocks: 1, cells: "SB_IO, both edges" }],
    gear_pads: GearPads::Any,
    gear_mbps: 370.0,
    fast_mhz: 185.0,
    gear_source: "Lattice FPGA-DS-02008, global buffers",
    pll: Pll {
        name: "SB_PLL40_2_PAD",
        feedback: Feedback::Vco,
        input_dividers: 1..=16,
        multipliers: 1..=128,
        output_dividers: &[2, 4, 8, 16, 32, 64],
        input_mhz: 10.0..=133.0,
        phase_detector_mhz: 10.0..=133.0,
        vco_mhz: 533.0..=1066.0,
        output_mhz: 16.0..=275.0,
        source: "Lattice FPGA-DS-02008, sysCLOCK PLL timing",
    },
};

/// AMD 7-series, speed grade 1.
pub static XC7: DeviceFamily = DeviceFamily {
    name: "AMD 7-series",
    folder: FamilyFolder::Xc7,
    gears: &[
        Gear { samples: 4, pins: 1, fast_clocks: 2, cells: "ISERDESE2" },
        Gear { samples: 8, pins: 1, fast_clocks: 4, cells: "ISERDESE2" },
    ],
    gear_pads: GearPads::Any,
    gear_mbps: 950.0,
    fast_mhz: 600.0,
    gear_source: "AMD DS181, DDR receiver by ISERDESE2 and BUFIO of speed grade -1",
    pll: Pll {
        name: "MMCME2_BASE",
        feedback: Feedback::Vco,
        input_dividers: 1..=106,
        multipliers: 2..=64,
        output_dividers: ONE_TO_128,
        input_mhz: 10.0..=800.0,
        phase_detector_mhz: 10.0..=450.0,
        vco_mhz: 600.0..=1200.0,
        output_mhz: 4.69..=800.0,
        source: "AMD DS181, MMCM of speed grade -1",
    },
};

static TANG_NANO_20K: Board = Board {
    name: "tang-nano-20k",
    title: "Sipeed Tang Nano 20K",
    family: &GW2AR_18,
    device: Device {
        part: "GW2AR-LV18QN88C8/I7",
        place_and_route: "--device GW2AR-LV18QN88C8/I7 --vopt family=GW2A-18C",
        pack: "-d GW2A-18C",
        loader: "-b tangnano20k",
        pll_device: Some("GW2AR-18C"),
        blocks: 46,
        divider_bel: Some("X27Y0/CLKDIV_HCLK0_SECT0"),
    },
    oscillator_hz: 27_000_000,
    oscillator: pin("4", "27 MHz", 7, Left, 'A'),
    rx: pin("70", "UART of the USB controller", 1, Top, 'B'),
    tx: pin("69", "UART of the USB controller", 1, Top, 'A'),
    baud: 3_000_000,
    led: (pin("15", "LED 0", 6, Left, 'A'), false),
    held: None,
    pins: &[
        pin("73", "73", 1, Top, 'A'),
        pin("74", "74", 1, Top, 'B'),
        pin("75", "75", 1, Top, 'A'),
        pin("77", "77", 1, Top, 'A'),
        pin("76", "76", 1, Top, 'B'),
        pin("71", "71", 1, Top, 'A'),
        pin("72", "72", 1, Top, 'B'),
        pin("86", "86", 0, Top, 'A'),
        pin("25", "25", 5, Bottom, 'A'),
        pin("26", "26", 5, Bottom, 'B'),
        pin("27", "27", 5, Bottom, 'A'),
        pin("28", "28", 5, Bottom, 'B'),
        pin("29", "29", 5, Bottom, 'A'),
        pin("30", "30", 5, Bottom, 'B'),
        pin("31", "31", 5, Bottom, 'A'),
    ],
    detectors: &["73", "75", "71", "77"],
    lasers: &["27", "29", "31", "25"],
    built_mhz: 150.0,
};

static TANG_NANO_9K: Board = Board {
    name: "tang-nano-9k",
    title: "Sipeed Tang Nano 9K",
    family: &GW1NR_9,
    device: Device {
        part: "GW1NR-LV9QN88PC6/I5",
        place_and_route: "--device GW1NR-LV9QN88PC6/I5 --vopt family=GW1N-9C",
        pack: "-d GW1N-9C",
        loader: "-b tangnano9k",
        pll_device: Some("GW1NR-9C"),
        blocks: 26,
        divider_bel: Some("X0Y28/CLKDIV_HCLK0_SECT0"),
    },
    oscillator_hz: 27_000_000,
    oscillator: pin("52", "27 MHz", 1, Right, 'A'),
    rx: pin("18", "UART of the USB controller", 2, Bottom, 'B'),
    tx: pin("17", "UART of the USB controller", 2, Bottom, 'A'),
    baud: 3_000_000,
    led: (Pin { standard: "LVCMOS18", ..pin("10", "LED 0", 3, Left, 'A') }, false),
    held: None,
    pins: &[
        pin("25", "25", 2, Bottom, 'A'),
        pin("26", "26", 2, Bottom, 'B'),
        pin("27", "27", 2, Bottom, 'A'),
        pin("28", "28", 2, Bottom, 'B'),
        pin("29", "29", 2, Bottom, 'A'),
        pin("30", "30", 2, Bottom, 'B'),
        pin("33", "33", 2, Bottom, 'A'),
        pin("34", "34", 2, Bottom, 'B'),
        pin("37", "37", 2, Bottom, 'A'),
        pin("38", "38", 2, Bottom, 'B'),
        pin("39", "39", 2, Bottom, 'A'),
        pin("40", "40", 2, Bottom, 'B'),
        pin("41", "41", 2, Bottom, 'A'),
        pin("42", "42", 2, Bottom, 'B'),
    ],
    detectors: &["25", "27", "29", "33"],
    lasers: &["37", "39", "41"],
    built_mhz: 130.0,
};

/// Pins of the ULX3S' headers at the left and right sides, where there are gears.
const ULX3S_PINS: &[Pin] = &[
    pin("A4", "J1 25+ (gp8)", 7, Left, 'A'),
    pin("A5", "J1 25- (gn8)", 7, Left, 'B'),
    pin("A2", "J1 27+ (gp9)", 7, Left, 'A'),
    pin("B1", "J1 27- (gn9)", 7, Left, 'B'),
    pin("C4", "J1 29+ (gp10)", 7, Left, 'A'),
    pin("B4", "J1 29- (gn10)", 7, Left, 'B'),
    pin("F4", "J1 31+ (gp11)", 7, Left, 'A'),
    pin("E3", "J1 31- (gn11)", 7, Left, 'B'),
    pin("G3", "J1 33+ (gp12)", 7, Left, 'A'),
    pin("F3", "J1 33- (gn12)", 7, Left, 'B'),
    pin("H4", "J1 35+ (gp13)", 7, Left, 'A'),
    pin("G5", "J1 35- (gn13)", 7, Left, 'B'),
    pin("U18", "J2 5+ (gp14)", 3, Right, 'A'),
    pin("U17", "J2 5- (gn14)", 3, Right, 'B'),
    pin("N17", "J2 7+ (gp15)", 3, Right, 'A'),
    pin("P16", "J2 7- (gn15)", 3, Right, 'B'),
    pin("N16", "J2 9+ (gp16)", 3, Right, 'A'),
    pin("M17", "J2 9- (gn16)", 3, Right, 'B'),
    pin("L16", "J2 11+ (gp17)", 3, Right, 'A'),
    pin("L17", "J2 11- (gn17)", 3, Right, 'B'),
];

const fn ulx3s(name: &'static str, title: &'static str, device: Device) -> Board {
    Board {
        name,
        title,
        family: &ECP5,
        device,
        oscillator_hz: 25_000_000,
        oscillator: pin("G2", "25 MHz", 6, Left, 'A'),
        rx: pin("M1", "FT231X", 6, Left, 'B'),
        tx: pin("L4", "FT231X", 6, Left, 'C'),
        baud: 3_000_000,
        led: (pin("B2", "LED 0", 7, Left, 'C'), true),
        held: Some((
            pin("L2", "WiFi GPIO0", 6, Left, 'D'),
            true,
            "low makes the ESP32 restart the board",
        )),
        pins: ULX3S_PINS,
        detectors: &["A4", "A2", "C4", "F4", "G3", "H4"],
        // Beside them: a path across the die of an 85F takes longer than a chip.
        lasers: &["G5", "F3", "E3", "B4"],
        built_mhz: 150.0,
    }
}

static ULX3S_12F: Board = ulx3s(
    "ulx3s-12f",
    "Radiona ULX3S with LFE5U-12F",
    Device {
        part: "LFE5U-12F-6BG381C",
        place_and_route: "--12k --package CABGA381 --speed 6",
        pack: "--idcode 0x21111043",
        loader: "-b ulx3s",
        pll_device: None,
        blocks: 32,
        divider_bel: None,
    },
);

static ULX3S_85F: Board = ulx3s(
    "ulx3s-85f",
    "Radiona ULX3S with LFE5U-85F",
    Device {
        part: "LFE5U-85F-6BG381C",
        place_and_route: "--85k --package CABGA381 --speed 6",
        pack: "",
        loader: "-b ulx3s",
        pll_device: None,
        blocks: 208,
        divider_bel: None,
    },
);

static COLORLIGHT_I5: Board = Board {
    name: "colorlight-i5",
    title: "Colorlight i5 on its extension board",
    family: &ECP5,
    device: Device {
        part: "LFE5U-25F-6BG381C",
        place_and_route: "--25k --package CABGA381 --speed 6",
        pack: "",
        loader: "-b colorlight-i5",
        pll_device: None,
        blocks: 56,
        divider_bel: None,
    },
    oscillator_hz: 25_000_000,
    oscillator: pin("P3", "25 MHz", 6, Left, 'C'),
    rx: pin("H18", "UART of the USB controller", 2, Right, 'A'),
    tx: pin("J17", "UART of the USB controller", 2, Right, 'C'),
    baud: 1_000_000,
    led: (pin("U16", "LED", 3, Right, 'C'), false),
    held: None,
    pins: &[
        pin("D1", "PMOD F 1", 7, Left, 'B'),
        pin("C1", "PMOD F 2", 7, Left, 'A'),
        pin("C2", "PMOD F 3", 7, Left, 'D'),
        pin("E3", "PMOD F 4", 7, Left, 'B'),
        pin("E2", "PMOD F 5", 7, Left, 'D'),
        pin("D2", "PMOD F 6", 7, Left, 'C'),
        pin("B1", "PMOD F 7", 7, Left, 'B'),
        pin("A3", "PMOD F 8", 7, Left, 'C'),
        pin("F20", "PMOD E 4", 2, Right, 'C'),
        pin("D20", "PMOD E 8", 2, Right, 'C'),
        pin("A18", "PMOD E 5", 1, Top, 'A'),
        pin("A19", "PMOD E 6", 1, Top, 'A'),
    ],
    detectors: &["C1", "D2", "A3"],
    lasers: &["F20", "D20", "A18", "A19"],
    built_mhz: 150.0,
};

static ICEBREAKER: Board = Board {
    name: "icebreaker",
    title: "1BitSquared iCEBreaker",
    family: &ICE40,
    device: Device {
        part: "iCE40UP5K-SG48",
        place_and_route: "--up5k --package sg48",
        pack: "",
        loader: "-b ice40_generic",
        pll_device: None,
        blocks: 30,
        divider_bel: None,
    },
    oscillator_hz: 12_000_000,
    oscillator: any_pin("35", "12 MHz"),
    rx: any_pin("6", "FT2232H"),
    tx: any_pin("9", "FT2232H"),
    baud: 3_000_000,
    led: (any_pin("37", "green LED"), false),
    held: None,
    pins: &[
        any_pin("4", "PMOD 1A 1"),
        any_pin("2", "PMOD 1A 2"),
        any_pin("47", "PMOD 1A 3"),
        any_pin("45", "PMOD 1A 4"),
        any_pin("43", "PMOD 1B 1"),
        any_pin("38", "PMOD 1B 2"),
        any_pin("34", "PMOD 1B 3"),
        any_pin("31", "PMOD 1B 4"),
    ],
    detectors: &["4", "2", "47", "45"],
    lasers: &["43", "38", "34", "31"],
    built_mhz: 48.0,
};

static ARTY_A7: Board = Board {
    name: "arty-a7",
    title: "Digilent Arty A7-35T",
    family: &XC7,
    device: Device {
        part: "xc7a35ticsg324-1L",
        place_and_route: "xc7a35ticsg324-1L",
        pack: "",
        loader: "-b arty_a7_35t",
        pll_device: None,
        blocks: 100,
        divider_bel: None,
    },
    oscillator_hz: 100_000_000,
    oscillator: any_pin("E3", "100 MHz"),
    rx: any_pin("A9", "FT2232HQ"),
    tx: any_pin("D10", "FT2232HQ"),
    baud: 2_000_000,
    led: (any_pin("H5", "LED 4"), true),
    held: None,
    pins: &[
        any_pin("D4", "PMOD JD 1"),
        any_pin("D3", "PMOD JD 2"),
        any_pin("F4", "PMOD JD 3"),
        any_pin("F3", "PMOD JD 4"),
        any_pin("E2", "PMOD JD 7"),
        any_pin("D2", "PMOD JD 8"),
        any_pin("H2", "PMOD JD 9"),
        any_pin("G2", "PMOD JD 10"),
    ],
    detectors: &["D4", "D3", "F4", "F3"],
    lasers: &["E2", "D2", "H2", "G2"],
    built_mhz: 150.0,
};
