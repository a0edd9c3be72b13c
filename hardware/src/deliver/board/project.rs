//! The files of a scene's board, in a folder of their own beside the design.

use std::fmt::Write as _;

use goldtof_wire::{Identity, MOST_TEXT_BYTES, encode};

use super::error::BoardError;
use super::made::{Bench, BoardPin, BoardProject};
use super::plan::{Assigned, BoardPlan, PinRole};
use super::table::FamilyFolder;
use crate::deliver::design::EmittedFile;
use crate::deliver::emission::{Emission, made_by};
use crate::deliver::template::filled;
use crate::scene::{Polarity, SceneText};
use crate::sensor::Sensor;
use crate::sensor::port::PortRole;
use crate::wire::{self, ScanSums, Sent};

macro_rules! bridge {
    ($($name:literal)*) => {
        [$(($name, include_str!(concat!("../../../../hdl/bridge/", $name)))),*]
    };
}

/// Sources that every board takes: the top, and the bridge's files, which hdl/bridge/bridge.f lists.
const TOP: (&str, &str) = ("board_top.v", include_str!("../../../../hdl/board/board_top.v"));
const BRIDGE: [(&str, &str); 13] = bridge![
    "async_fifo.v"
    "axil_master.v"
    "bridge_core.v"
    "bridge_reset.v"
    "bridge_sync.v"
    "crc32.v"
    "framer.v"
    "request_receiver.v"
    "result_writer.v"
    "uart_bridge.v"
    "uart_bridge_axil.v"
    "uart_receiver.v"
    "uart_transmitter.v"
];

/// Between core and bridge, if scans are added up.
const ACCUMULATOR: (&str, &str) =
    ("result_accumulator.v", include_str!("../../../../hdl/bridge/result_accumulator.v"));

/// In the bridge, if the scene's text is.
const TEXT: (&str, &str) = ("scene_text.v", include_str!("../../../../hdl/bridge/scene_text.v"));

/// Beside the core, if hits are counted by sample.
const COUNTER: (&str, &str) =
    ("sample_counter.v", include_str!("../../../../hdl/bridge/sample_counter.v"));

/// Sources of a family.
fn sources(folder: FamilyFolder) -> [(&'static str, &'static str); 4] {
    macro_rules! of {
        ($folder:literal, $memory:literal) => {
            [
                (
                    "bridge_memory.v",
                    include_str!(concat!("../../../../hdl/bridge/", $memory, "/bridge_memory.v")),
                ),
                (
                    "board_clock.v",
                    include_str!(concat!("../../../../hdl/", $folder, "/board_clock.v")),
                ),
                (
                    "board_sampler.v",
                    include_str!(concat!("../../../../hdl/", $folder, "/board_sampler.v")),
                ),
                (
                    "board_laser.v",
                    include_str!(concat!("../../../../hdl/", $folder, "/board_laser.v")),
                ),
            ]
        };
    }
    match folder {
        FamilyFolder::Ecp5 => of!("ecp5", "ecp5"),
        FamilyFolder::Gowin => of!("gowin", "inferred"),
        FamilyFolder::Ice40 => of!("ice40", "inferred"),
        FamilyFolder::Xc7 => of!("xc7", "inferred"),
    }
}

impl BoardPlan {
    /// The project of a design on the board. `sensor` and `scene` have the chip period that the PLL
    /// makes.
    ///
    /// # Errors
    /// When the scene's text is to be in the device, and cannot be.
    pub fn project(
        &self,
        sensor: &Sensor,
        emission: &Emission,
        scene: &SceneText,
    ) -> Result<BoardProject, BoardError> {
        let board = self.board;
        let sums = ScanSums::of(sensor.interface(), self.uart.pace(board.baud));
        let text = sensor.scene().hardware.scene_text.then(|| text_of(scene)).transpose()?;
        let verilog: Vec<(&str, &str)> = std::iter::once(TOP)
            .chain(sums.map(|_| ACCUMULATOR))
            .chain(BRIDGE)
            .chain(text.as_ref().map(|_| self::TEXT))
            .chain(sensor.scene().hardware.sample_counts.then_some(COUNTER))
            .chain(sources(board.family.folder))
            .collect();
        let project = Project { plan: self, sensor, emission, sums, text, verilog };
        let mut files = vec![project.header()];
        files.extend(project.verilog.iter().map(|(name, text)| file(name, (*text).to_owned())));
        files.extend(project.tool_files());
        files.extend(project.simulation());
        files.push(file("scene.toml", scene.text.clone()));
        let bench = Bench {
            numbers: project.numbers(),
            identity: project.identity(),
            text: if project.text.is_some() { scene.text.clone() } else { String::new() },
            sums,
        };
        Ok(BoardProject {
            name: board.name.to_owned(),
            part: board.device.part.to_owned(),
            files,
            asked_chip_period_ps: self.asked_chip_period_ps,
            chip_period_ps: self.chip.period_ps(),
            chip_clock: self.chip,
            fast_clock: self.fast,
            oscillator_hz: board.oscillator_hz,
            pll: board.family.pll.name.to_owned(),
            pll_dividers: self.dividers,
            uart: self.uart,
            baud_hz: board.baud,
            line_use_fraction: self.line_use_fraction,
            pins_per_detector: self.gear.pins,
            delay_taps: self.delay_taps,
            bench,
            pins: self
                .pins
                .iter()
                .map(|assigned| BoardPin {
                    port: assigned.port(),
                    site: assigned.pin.site.to_owned(),
                    label: assigned.pin.label.to_owned(),
                    io_standard: assigned.pin.standard.to_owned(),
                })
                .collect(),
        })
    }
}

/// The scene's text as a device holds it: its blocks, and their words.
fn text_of(scene: &SceneText) -> Result<(u8, Vec<String>), BoardError> {
    const KEY: &str = "hardware.scene_text";
    let settings = scene.settings.iter().map(|setting| setting.key_and_value().0);
    let others: Vec<&str> = settings.filter(|&key| key != KEY).collect();
    if !others.is_empty() {
        return Err(BoardError(format!(
            "{KEY}: the file's text alone is not the scene, which has {} from elsewhere; write them into the \
             file",
            others.join(", ")
        )));
    }
    encode::text_parameter(&scene.text).ok_or_else(|| {
        BoardError(format!(
            "{KEY}: the scene's text has {} bytes, and a device holds 1 to {MOST_TEXT_BYTES}; leave out \
             comments, or this key",
            scene.text.len()
        ))
    })
}

fn file(name: &str, text: String) -> EmittedFile {
    EmittedFile { name: name.to_owned(), text }
}

/// What the files are made of.
struct Project<'a> {
    plan: &'a BoardPlan,
    sensor: &'a Sensor,
    emission: &'a Emission,
    /// Scans that are added up.
    sums: Option<ScanSums>,
    /// The scene's text in the device: blocks and words.
    text: Option<(u8, Vec<String>)>,
    /// Names and texts of the Verilog.
    verilog: Vec<(&'a str, &'a str)>,
}

impl Project<'_> {
    fn made_by(&self) -> String {
        format!("Made by  {}", made_by(&self.emission.command))
    }

    /// `board.vh`: every number of the board's Verilog.
    fn header(&self) -> EmittedFile {
        let plan = self.plan;
        let board = plan.board;
        let scene = self.sensor.scene();
        let mut text = format!(
            "// Numbers of {} for this scene\n// {}\n\n`ifndef BOARD_VH\n`define BOARD_VH\n\n",
            board.title,
            self.made_by()
        );
        let mut define = |name: &str, value: &dyn std::fmt::Display| {
            let _ = writeln!(text, "`define BOARD_{name} {value}");
        };
        let oscillator_mhz = board.oscillator_hz as f64 / 1e6;
        define("DETECTORS", &scene.detectors.len());
        define("LASERS", &scene.sources.len());
        define("SAMPLES_PER_CHIP", &plan.gear.samples);
        define("PINS_PER_DETECTOR", &plan.gear.pins);
        define("OSCILLATOR_MHZ", &format!("\"{oscillator_mhz}\""));
        define("OSCILLATOR_NS", &format!("{:.3}", 1e3 / oscillator_mhz));
        define("PLL_INPUT_DIVIDER", &plan.dividers.input_divider);
        define("PLL_FEEDBACK", &plan.dividers.multiplier);
        define("PLL_OUTPUT_DIVIDER", &plan.dividers.output_divider);
        if let Some(device) = board.device.pll_device {
            define("PLL_DEVICE", &format!("\"{device}\""));
        }
        if board.family.folder == FamilyFolder::Ice40 {
            let phase_detector_mhz = oscillator_mhz / f64::from(plan.dividers.input_divider);
            define("PLL_FILTER", &ice40_filter(phase_detector_mhz));
        }
        if let Some(bel) = board.device.divider_bel {
            define("DIVIDER_BEL", &format!("\"{bel}\""));
        }
        define("FAST_CLOCKS", &format!("\"{}\"", plan.gear.fast_clocks));
        if let Some(divider) = plan.uart.pll_divider {
            define("UART_PLL_DIVIDER", &divider);
        }
        define("UART_CLOCKS_PER_BIT", &plan.uart.clocks_per_bit);
        define("DELAY_TAPS", &plan.delay_taps);
        define("LED_ON", &format!("1'b{}", u8::from(board.led.1)));
        if let Some((_, level, _)) = board.held {
            define("HELD", &format!("1'b{}", u8::from(level)));
        }
        let ports = &self.emission.ports;
        let port = |role: PortRole| ports.iter().find(|port| port.role == role);
        for (name, value) in self.bridge() {
            define(name, &value);
        }
        if let Some(sums) = &self.sums {
            let interface = self.sensor.interface();
            define("ACCUMULATE_TDATA_BITS", &interface.tdata_bits);
            define(
                "ACCUMULATE_MORE_FIRST_BIT",
                &interface.total().map_or(0, |total| total.first_bit),
            );
            for (name, value) in sums.parameters() {
                define(name, &value);
            }
        }
        if let Some((blocks, words)) = &self.text {
            define("TEXT_BLOCKS", blocks);
            define("TEXT", &format!("{{ \\\n    {}}}", words.join(", \\\n    ")));
        }
        if scene.hardware.sample_counts {
            let places = scene.detectors.len() as u32 * plan.gear.samples;
            define("SAMPLE_COUNTS", &1);
            define("SAMPLE_INVERT", &u8::from(scene.hardware.polarity == Polarity::Low));
            define("SAMPLE_PLACE_BITS", &places.next_power_of_two().trailing_zeros());
        }
        let has_registers = port(PortRole::WriteAddress).is_some();
        define("BRIDGE", if has_registers { &"uart_bridge_axil" } else { &"uart_bridge" });
        if has_registers {
            define("HAS_REGISTERS", &"");
        }
        if port(PortRole::Saturated).is_some() {
            define("HAS_SATURATED", &"");
        }
        if port(PortRole::PeakValid).is_some() {
            define("HAS_PEAK", &"");
        }
        text += "\n`endif\n";
        // A macro without a value has no blank behind it.
        file("board.vh", text.replace(" \n", "\n"))
    }

    /// What the device says of itself. The plan has checked that it is something.
    fn identity(&self) -> Option<Identity> {
        let chip_period_fs = (self.plan.chip.period_ps() * 1e3).round() as u32;
        // A scene that was made in a program has no text, and so no digest.
        let digest = Some(self.sensor.scene().reference().origin.sha256.clone());
        let digest = digest.filter(|digest| !digest.is_empty()).unwrap_or_else(|| "0".repeat(64));
        let identity =
            wire::identity(self.sensor.interface(), Sent::Results, chip_period_fs, &digest);
        let text_blocks = self.text.as_ref().map_or(0, |(blocks, _)| *blocks);
        let counts_samples = self.sensor.scene().hardware.sample_counts;
        identity.map(|identity| Identity { text_blocks, counts_samples, ..identity })
    }

    /// Parameters of the bridge.
    fn bridge(&self) -> Vec<(&'static str, String)> {
        let interface = self.sensor.interface();
        let identity = self.identity();
        identity
            .and_then(|identity| wire::bridge_parameters(interface, Sent::Results, &identity))
            .unwrap_or_default()
    }

    /// Constraints and what runs the tools.
    fn tool_files(&self) -> Vec<EmittedFile> {
        let makefile = |text: &str| file("Makefile", self.filled(text));
        match self.plan.board.family.folder {
            FamilyFolder::Ecp5 => {
                vec![file("board.lpf", self.lpf()), makefile(include_str!("projects/ecp5.mk"))]
            }
            FamilyFolder::Gowin => vec![
                file("board.cst", self.cst()),
                file("board.sdc", self.sdc()),
                makefile(include_str!("projects/gowin.mk")),
            ],
            FamilyFolder::Ice40 => {
                vec![file("board.pcf", self.pcf()), makefile(include_str!("projects/ice40.mk"))]
            }
            FamilyFolder::Xc7 => vec![
                file("board.xdc", self.xdc()),
                file("board.tcl", self.filled(include_str!("projects/xc7.tcl"))),
                makefile(include_str!("projects/xc7.mk")),
            ],
        }
    }

    fn filled(&self, text: &str) -> String {
        let device = &self.plan.board.device;
        let core: Vec<String> =
            self.emission.files.iter().map(|file| format!("../{}", file.name)).collect();
        let own: Vec<&str> = self.verilog.iter().map(|(name, _)| *name).collect();
        let delay_bits = match self.plan.delay_taps {
            0 => String::new(),
            taps => format!("{taps:07b}"),
        };
        let pack = if device.pack.is_empty() { String::new() } else { format!(" {}", device.pack) };
        let flags = format!("-O3 -std=c++17 {}", self.numbers().join(" "));
        let simulation = filled(include_str!("projects/simulation.mk"), &[("CFLAGS", &flags)]);
        filled(
            text,
            &[
                ("TITLE", self.plan.board.title),
                ("MADE_BY", &self.made_by()),
                ("CORE", &core.join(" ")),
                ("SOURCES", &own.join(" ")),
                ("DELAY_BITS", &delay_bits),
                ("DETECTORS", &self.sensor.scene().detectors.len().to_string()),
                ("PLACE_AND_ROUTE", device.place_and_route),
                ("PACK", &pack),
                ("SIMULATION", &simulation),
                ("PART", device.part),
                ("LOADER", device.loader),
            ],
        )
    }

    /// The board in simulation.
    fn simulation(&self) -> Vec<EmittedFile> {
        let models = match self.plan.board.family.folder {
            FamilyFolder::Ecp5 => concat!(
                include_str!("../../../../hdl/models/ecp5.v"),
                "\n",
                include_str!("../../../../hdl/models/DP16KD.v")
            ),
            FamilyFolder::Gowin => include_str!("../../../../hdl/models/gowin.v"),
            FamilyFolder::Ice40 => include_str!("../../../../hdl/models/ice40.v"),
            FamilyFolder::Xc7 => include_str!("../../../../hdl/models/xc7.v"),
        };
        let top = include_str!("../../../../hdl/models/simulated_board.v");
        let header = include_str!("../../../../hdl/models/simulated_board.h");
        let program = include_str!("../../../../hdl/models/simulated_board.cpp");
        vec![
            file("cells.v", models.to_owned()),
            file("simulated_board.v", top.to_owned()),
            file("simulated_board.h", header.to_owned()),
            file("simulated_board.cpp", program.to_owned()),
        ]
    }

    /// The scene's and the board's numbers, for the simulation's program.
    fn numbers(&self) -> Vec<String> {
        let scene = self.sensor.scene();
        let plan = self.plan;
        let numbers = [
            ("OSCILLATOR_HZ", plan.board.oscillator_hz),
            ("BAUD", u64::from(plan.board.baud)),
            ("DETECTORS", scene.detectors.len() as u64),
            ("PINS", u64::from(plan.gear.pins)),
            ("SAMPLES_PER_CHIP", u64::from(plan.gear.samples)),
            ("FAST_CLOCKS", u64::from(plan.gear.fast_clocks)),
            ("REST", u64::from(scene.hardware.polarity == Polarity::Low)),
            ("LASERS", scene.sources.len() as u64),
            ("LED_ON", plan.board.led.1.into()),
            ("HELD", plan.board.held.is_some_and(|(_, level, _)| level).into()),
        ];
        numbers.map(|(name, value)| format!("-D{name}={value}")).into()
    }

    /// Each port with its pin, as a tool names it: a bus of one bit has no number in a netlist of
    /// Yosys.
    fn located(&self) -> impl Iterator<Item = (String, &Assigned)> {
        let widths = |bus: &str| self.plan.pins.iter().filter(|pin| pin.bus == bus).count();
        self.plan.pins.iter().map(move |assigned| {
            let is_one = widths(assigned.bus) == 1;
            (if is_one { assigned.bus.to_owned() } else { assigned.port() }, assigned)
        })
    }

    fn lpf(&self) -> String {
        let mut text = self.constraints_header();
        for (port, Assigned { pin, role, .. }) in self.located() {
            let more = match role {
                PinRole::Detector => "PULLMODE=DOWN",
                PinRole::Input => "PULLMODE=UP",
                PinRole::Oscillator => "PULLMODE=NONE",
                PinRole::Output => "DRIVE=8 SLEWRATE=FAST",
            };
            let (site, label, standard) = (pin.site, pin.label, pin.standard);
            let _ = writeln!(text, "LOCATE COMP \"{port}\" SITE \"{site}\"; # {label}");
            let _ = writeln!(text, "IOBUF PORT \"{port}\" IO_TYPE={standard} {more};");
        }
        let mhz = self.plan.board.oscillator_hz as f64 / 1e6;
        text += &format!(
            "\n# The PLL's outputs, edge and chip clock follow from it.\n\
             FREQUENCY PORT \"i_oscillator\" {mhz} MHZ;\n"
        );
        text
    }

    fn cst(&self) -> String {
        let mut text = self.constraints_header().replace("# ", "// ");
        for (port, Assigned { pin, role, .. }) in self.located() {
            let more = match role {
                PinRole::Detector => "PULL_MODE=DOWN",
                PinRole::Input => "PULL_MODE=UP",
                PinRole::Oscillator => "PULL_MODE=NONE",
                PinRole::Output => "PULL_MODE=NONE DRIVE=8",
            };
            let (site, label, standard) = (pin.site, pin.label, pin.standard);
            let _ = writeln!(text, "IO_LOC \"{port}\" {site}; // {label}");
            let _ = writeln!(text, "IO_PORT \"{port}\" IO_TYPE={standard} {more};");
        }
        text
    }

    fn sdc(&self) -> String {
        let oscillator_ns = 1e9 / self.plan.board.oscillator_hz as f64;
        format!(
            "{}create_clock -name clk -period {:.6} [get_nets clk]\n\
             create_clock -name uart_clk -period {oscillator_ns:.6} [get_nets uart_clk]\n",
            self.constraints_header(),
            self.plan.chip.period_ps() / 1e3,
        )
    }

    fn pcf(&self) -> String {
        let mut text = self.constraints_header();
        for (port, Assigned { pin, .. }) in self.located() {
            let _ = writeln!(text, "set_io {port} {} # {}", pin.site, pin.label);
        }
        let mhz = self.plan.board.oscillator_hz as f64 / 1e6;
        text +=
            &format!("\n# The PLL's output follows from it.\nset_frequency i_oscillator {mhz}\n");
        text
    }

    fn xdc(&self) -> String {
        let mut text = self.constraints_header();
        for assigned in &self.plan.pins {
            let (port, pin) = (assigned.port(), assigned.pin);
            let _ = writeln!(
                text,
                "set_property -dict {{PACKAGE_PIN {} IOSTANDARD {}}} [get_ports {{{port}}}]",
                pin.site, pin.standard
            );
        }
        let oscillator_ns = 1e9 / self.plan.board.oscillator_hz as f64;
        text += &format!(
            "\n# Vivado follows the clocks from it through the MMCM and BUFR. That of the UART and that of\n\
             # the chips cross in the bridge's FIFO alone.\n\
             create_clock -name oscillator -period {oscillator_ns:.3} [get_ports i_oscillator]\n\
             set_clock_groups -asynchronous -group [get_clocks oscillator] \
             -group [get_clocks -of_objects [get_pins clocks/chip_clock/O]]\n\
             set_false_path -from [get_ports i_rx]\n\
             set_false_path -to [get_ports {{o_tx o_led}}]\n"
        );
        text
    }

    fn constraints_header(&self) -> String {
        format!(
            "# Pins and clocks of {} ({})\n# {}\n\n",
            self.plan.board.title,
            self.plan.board.device.part,
            self.made_by()
        )
    }
}

/// The filter of iCE40's PLL by the phase detector's rate (Project IceStorm's icepll).
fn ice40_filter(phase_detector_mhz: f64) -> usize {
    let borders = [17.0, 26.0, 44.0, 66.0, 101.0];
    1 + borders.iter().filter(|&&border| phase_detector_mhz >= border).count()
}
