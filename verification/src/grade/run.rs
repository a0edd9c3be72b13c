//! The stimulus, and all variants under it.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::variant_set::VariantSet;
use super::{GradeOptions, GradeStimulus};
use crate::cosim::build::build_with;
use crate::cosim::error::CosimError;
use crate::cosim::lanes::LaneRefusal;
use crate::cosim::lanes::netlist::{CHOICE, GateNetlist};
use crate::cosim::lanes::variants::{Counters, Flips, Variants, build_variants};
use crate::cosim::lanes::verilog::LANES;
use crate::cosim::lockstep::Lockstep;
use crate::cosim::source::Verilog;
use crate::cosim::verilated::Verilated;
use crate::cosim::window::Window;
use crate::deliver::flow::testbench_adversary;
use crate::photons::DetectorModel;
use crate::reference::adversarial::{Adversarial, LONGEST_DEFAULT, Means};
use crate::reference::blocks::{Block, BlockMaker};
use crate::reference::photons::Photons;
use crate::reference::predictor::{ReferenceModel, Skip};
use crate::reference::stimulus::{RESET_CLOCKS, Stimulus, clocks_for_scans};
use crate::rtl::blocks::ScanRegisters;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;
use crate::sensor::interface::Interface;
use crate::sensor::layout::Layout;

/// Seed of the registers at power-up.
const POWER_UP_SEED: u64 = 1;
/// Most clocks of photons that are taken where no number is given.
const MOST_PHOTON_CLOCKS: u64 = 4_000_000;

/// A stimulus of so many clocks.
pub(super) struct Stream<'a> {
    pub(super) clocks: u64,
    sensor: &'a Sensor,
    verilog: &'a Verilog,
    options: &'a GradeOptions,
    models: Vec<DetectorModel>,
    /// The adversary, if it is the one that drives.
    adversary: Option<Adversarial>,
    /// The scan's counters, if they can be moved on.
    registers: Option<ScanRegisters>,
}

/// When each variant was caught.
pub(super) struct Caught {
    /// The clock, if any.
    pub(super) at: Vec<Option<u64>>,
    /// The good design's registers after reset.
    pub(super) after_reset_good: Vec<bool>,
    /// Each variant's registers after reset.
    pub(super) after_reset: Vec<Vec<bool>>,
}

impl Caught {
    /// Those of some that were not caught.
    pub(super) fn missed(&self, some: &[usize]) -> Vec<usize> {
        let missed = some.iter().filter(|&&number| self.at[number].is_none());
        missed.copied().collect()
    }
}

impl<'a> Stream<'a> {
    /// The stimulus that is asked for; `good` is the design.
    ///
    /// # Errors
    /// When the hardware is not modelled, or the testbench has no way through the
    /// design.
    pub(super) fn of(
        sensor: &'a Sensor,
        verilog: &'a Verilog,
        options: &'a GradeOptions,
        good: &GateNetlist,
    ) -> Result<Stream<'a>, LaneRefusal> {
        let interface = sensor.interface();
        let registers = verilog.registers.clone();
        let registers = registers.filter(|found| Counters::find(good, found).is_some());
        let (adversary, clocks) = match options.stimulus {
            GradeStimulus::Photons => {
                let scan = clocks_for_scans(interface, 1);
                (None, scan.min(MOST_PHOTON_CLOCKS))
            }
            GradeStimulus::Adversarial => {
                let adversary = hostile(interface, options.seed, registers.as_ref())?;
                let clocks = match options.clocks {
                    Some(clocks) => clocks,
                    None => adversary.clone().clocks_to_cover(LONGEST_DEFAULT),
                };
                (Some(adversary), clocks)
            }
            GradeStimulus::Testbench => {
                if registers.is_none() {
                    return Err(LaneRefusal::unfit(
                        "the testbench moves the scan's counters on, and this design has not the \
                         registers that goldtof emits",
                    ));
                }
                let (adversary, clocks) =
                    testbench_adversary(interface).map_err(CosimError::from)?;
                (Some(adversary), clocks)
            }
        };
        Ok(Stream {
            clocks: options.clocks.unwrap_or(clocks),
            models: DetectorIndex::of(&sensor.scene().detectors)
                .map(|detector| DetectorModel::new(sensor, detector))
                .collect(),
            sensor,
            verilog,
            options,
            adversary,
            registers,
        })
    }

    fn stimulus(&self) -> Box<dyn Stimulus + '_> {
        match &self.adversary {
            Some(adversary) => Box::new(adversary.clone()),
            None => {
                Box::new(Photons::new(&self.models, self.sensor.interface(), self.options.seed))
            }
        }
    }

    /// Whether the design itself is as the reference model has it: else its outputs are
    /// no measure.
    ///
    /// # Errors
    /// When it is not; or a tool fails.
    pub(super) fn check(&self) -> Result<(), LaneRefusal> {
        let interface = self.sensor.interface();
        let layout = Layout::of(interface);
        let registers = self.registers.as_ref();
        let Verilog { top, sources, cache, .. } = self.verilog;
        let built = build_with(top, sources, interface, registers, cache)?;
        let outcome = Lockstep {
            model: &mut Verilated::load(&built, &layout)?,
            reference: &mut ReferenceModel::new(interface.clone()).map_err(CosimError::from)?,
            stimulus: &mut *self.stimulus(),
            layout: &layout,
            window: Window::Found,
        }
        .run(self.clocks, |_| (), |_| ())?;
        match outcome.first {
            None => Ok(()),
            Some(first) => Err(CosimError::Differs { clock: first.clock }.into()),
        }
    }

    /// The adversary that looks at what another stimulus has not caught.
    ///
    /// # Errors
    /// When the hardware is not modelled.
    pub(super) fn witness(&self) -> Result<Option<Stream<'a>>, LaneRefusal> {
        if self.options.stimulus == GradeStimulus::Adversarial {
            return Ok(None);
        }
        let interface = self.sensor.interface();
        let adversary = hostile(interface, self.options.seed, self.registers.as_ref())?;
        let clocks = adversary.clone().clocks_to_cover(LONGEST_DEFAULT);
        Ok(Some(Stream {
            clocks,
            sensor: self.sensor,
            verilog: self.verilog,
            options: self.options,
            models: Vec::new(),
            adversary: Some(adversary),
            registers: self.registers.clone(),
        }))
    }

    /// The variants, ready to run.
    ///
    /// # Errors
    /// What of the design has no place in lanes; or a tool fails.
    pub(super) fn machines(&self, set: &VariantSet) -> Result<Machines, LaneRefusal> {
        let interface = self.sensor.interface();
        let counters = match &self.registers {
            Some(registers) => Counters::find(&set.good, registers).ok_or_else(|| {
                LaneRefusal::unfit("the scan's counters are not found among the variants")
            })?,
            None => Counters::default(),
        };
        let built = build_variants(
            &set.all,
            &counters,
            interface,
            self.verilog.is_users(),
            &self.verilog.cache,
        )?;
        Ok(Machines {
            model: Variants::load(&built, &set.all, interface)?,
            choice_bits: set.all.input(CHOICE).map_or(0, <[_]>::len),
            power_up: power_up(&set.all),
            states: vec![Vec::new(); set.count() + 1],
            alive: Vec::new(),
            at: Vec::new(),
        })
    }

    /// Runs some of the variants from power-up. Those that are caught make room for
    /// others.
    ///
    /// # Errors
    /// When the model has ended.
    pub(super) fn run(
        &self,
        machines: &mut Machines,
        chosen: &[usize],
    ) -> Result<Caught, LaneRefusal> {
        let interface = self.sensor.interface();
        machines.start(chosen);
        let layout = Layout::of(interface);
        let mut reference = ReferenceModel::new(interface.clone()).map_err(CosimError::from)?;
        let mut stimulus = self.stimulus();
        let mut maker = BlockMaker::new(&mut reference, &mut *stimulus, &layout, self.clocks);
        let mut registers = self.registers.clone();
        let mut block = Block::default();
        let mut after_reset = None;
        while !machines.alive.is_empty() && maker.make(&mut block) {
            let mut inputs = &block.records.inputs[..];
            let mut clock = block.clocks.start;
            if after_reset.is_none() {
                // Those that reset does not bring to where it should are caught later.
                let words = RESET_CLOCKS as usize * layout.inputs.words;
                machines.run(&inputs[..words], clock, &[])?;
                after_reset = Some(machines.states.clone());
                inputs = &inputs[words..];
                clock += RESET_CLOCKS;
            }
            let flips = flips(registers.as_mut(), &block.skips, clock);
            machines.run(inputs, clock, &flips)?;
        }
        let mut after_reset = after_reset.unwrap_or_default();
        let after_reset_good = after_reset.pop().unwrap_or_default();
        Ok(Caught { at: std::mem::take(&mut machines.at), after_reset_good, after_reset })
    }
}

/// The adversary of a co-simulation.
fn hostile(
    interface: &Interface,
    seed: u64,
    registers: Option<&ScanRegisters>,
) -> Result<Adversarial, CosimError> {
    let means = Means::cosim(registers.is_some());
    Ok(Adversarial::with_means(interface, seed, means)?)
}

/// What moves the counters on in clocks from `first_clock` on.
fn flips(registers: Option<&mut ScanRegisters>, skips: &[Skip], first_clock: u64) -> Vec<Flips> {
    let Some(registers) = registers else {
        return Vec::new();
    };
    let mut flip = |skip: &Skip| {
        let chips = registers.chips.as_mut();
        let groups = registers.groups.as_mut();
        Flips {
            clock: skip.clock - first_clock,
            chips: chips.map_or(0, |register| register.difference(skip.chip, skip.chips)),
            groups: groups.map_or(0, |register| register.difference(skip.group.0, skip.groups)),
        }
    };
    skips.iter().map(&mut flip).collect()
}

/// Values of the registers at power-up, the same for all variants.
fn power_up(netlist: &GateNetlist) -> Vec<bool> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(POWER_UP_SEED);
    let registers = netlist.registers.iter();
    registers
        .map(|register| {
            let random = rng.random();
            register.initial.unwrap_or(random)
        })
        .collect()
}

/// All variants of a [`VariantSet`].
pub(super) struct Machines {
    model: Variants,
    choice_bits: usize,
    power_up: Vec<bool>,
    /// Registers of every variant, and behind them those of the good design.
    states: Vec<Vec<bool>>,
    alive: Vec<usize>,
    at: Vec<Option<u64>>,
}

impl Machines {
    /// Puts some variants, and the good design, to where they are at power-up.
    fn start(&mut self, chosen: &[usize]) {
        let good = self.states.len() - 1;
        self.at = vec![None; good];
        self.alive = chosen.to_vec();
        for &variant in chosen.iter().chain([&good]) {
            self.states[variant].clone_from(&self.power_up);
        }
    }

    /// Runs all that have not been caught, 63 at once.
    fn run(
        &mut self,
        records: &[u64],
        first_clock: u64,
        flips: &[Flips],
    ) -> Result<(), CosimError> {
        let alive = std::mem::take(&mut self.alive);
        let good = self.states.len() - 1;
        let mut good_after = self.states[good].clone();
        for part in alive.chunks(LANES - 1) {
            let lanes: Vec<usize> = std::iter::once(good).chain(part.iter().copied()).collect();
            self.model.choose(&self.choice(part))?;
            self.model.set_registers(&self.planes(&lanes))?;
            let found = self.model.run(records, flips)?;
            let planes = self.model.registers()?;
            let state = |lane: usize| planes.iter().map(move |plane| plane >> lane & 1 == 1);
            good_after.clear();
            good_after.extend(state(0));
            for (lane, &variant) in lanes.iter().enumerate().skip(1) {
                if found.lanes >> lane & 1 == 1 {
                    self.at[variant] = Some(first_clock + found.first_clocks[lane]);
                } else {
                    self.states[variant].clear();
                    self.states[variant].extend(state(lane));
                    self.alive.push(variant);
                }
            }
        }
        self.states[good] = good_after;
        Ok(())
    }

    /// One plane for each register.
    fn planes(&self, lanes: &[usize]) -> Vec<u64> {
        let registers = self.power_up.len();
        let plane = |register: usize| {
            let lanes = lanes.iter().enumerate();
            lanes.fold(0, |plane, (lane, &variant)| {
                plane | u64::from(self.states[variant][register]) << lane
            })
        };
        (0..registers).map(plane).collect()
    }

    /// One plane for each bit of the choice.
    fn choice(&self, variants: &[usize]) -> Vec<u64> {
        let mut planes = vec![0u64; self.choice_bits];
        for (variant, lane) in variants.iter().zip(1u32..) {
            planes[*variant] |= 1 << lane;
        }
        planes
    }
}
