//! The whole sensor.

use super::code_source::seed_taken;
use super::histogram_channel::about_clamping;
use super::sensor_shell::{about_clock, about_power_up};
use super::{
    DetectorChannel, Groups, PeakDetector, PixelArray, RegisterFile, ResultStream, ScanController,
    ScanSequencer, SensorShell, TargetTracker,
};
use crate::rtl::front::prelude::*;
use crate::scan::Scan;
use crate::sensor::interface::{Correlator, Interface, TotalCount};
use crate::sensor::port::Direction;
use crate::sensor::registers::{CHIPS_AHEAD, RegisterPlan};

#[block(sensor_top)]
/// DS-CDMA indirect time-of-flight sensor, lasers out, SPAD samples in
///
/// {about_clock(interface.lanes(), &format!("{outputs} outputs"))}
///
/// {about_power_up("scan")}
///
/// - Scan: {scan.steps} phase steps from step {scan.first_step}, {scan.integration_chips} chips each
/// - Counts: {counts.count_bits} bits, signed{about_clamping(counts.saturates())}
/// - Latency: m_axis_tvalid {interface.result_latency_clocks} clocks after the one at which a step's last word is on
/// i_samples
/// - Rate: one chip per clock
#[when(counts.total.is_some())]
/// - Totals: {counts.total.map(|total| about_totals(total, interface.tdata_bits)).unwrap_or_default()}
pub struct SensorTop {
    interface: Interface,
    counts: Correlator,
    #[set(interface.timing.scan)]
    scan: Scan,
    #[set(interface.ports().iter().filter(|p| p.direction == Direction::Output).count())]
    outputs: usize,
    #[set(interface.reference_codes.len())]
    detectors: usize,
    /// Of each detector.
    #[set((interface.lanes() * interface.input_cells.edges()) as usize)]
    samples: usize,
    #[set(interface.parallel() as usize)]
    parallel: usize,
    /// Whether a host sets the scan.
    #[set(interface.registers.is_some())]
    is_set: bool,
    /// ports, and what drives the lasers
    #[is(SensorShell::new(interface.clone()))]
    pub io: SensorShell,
    /// Clocks by which a step's end is told before its last hits are in: a row takes its counters
    /// over at a register's word.
    #[set(counts.dumps_early())]
    dumps_early: u32,
    /// Whether a target is followed.
    #[set(interface.track().is_some())]
    tracks: bool,
    /// First bit and bits of the seed that each code takes.
    #[set(io.codes.all.iter().map(|code| seed_taken(&interface, code)).collect())]
    seeds: Vec<(usize, usize)>,
    /// The same of each detector's code.
    #[set(interface.reference_codes.iter().map(|code| seed_taken(&interface, code)).collect())]
    reference_seeds: Vec<(usize, usize)>,
    #[when(!is_set)]
    #[is(ScanController::new(
        interface.timing.scan.integration_chips,
        interface.groups(),
        interface.realigns(),
        counts.clocks_to_dump() - dumps_early,
        counts.count_segments.count,
        counts.clocks_of_counting() + dumps_early,
        detectors * parallel > 1 && dumps_early == 0,
    ))]
    controller: Optional<ScanController>,
    #[each(plan in interface.registers.iter())]
    #[is(ScanSequencer::new(
        (**plan).clone(),
        counts.clocks_to_dump(),
        counts.count_segments.count,
        counts.clocks_of_counting(),
        detectors * parallel > 1,
    ))]
    sequencer: Vec<ScanSequencer>,
    #[each(plan in interface.registers.iter())]
    #[is(RegisterFile::new(
        (**plan).clone(),
        plan.initial_words(&interface.timing, &interface.source_codes),
        counts.saturates(),
        counts.peak.map_or((0, 0), |peak| (peak.step_bits, peak.count_bits)),
    ))]
    registers: Vec<RegisterFile>,
    #[each(plan in interface.registers.iter().filter(|plan| plan.track.is_some()))]
    #[is(target_tracker(plan, &counts))]
    tracker: Vec<TargetTracker>,
    #[each(code in interface.reference_codes.iter().filter(|_| counts.rows.is_none()))]
    #[is(DetectorChannel::new(interface.clone(), counts, code.clone()))]
    channel: Vec<DetectorChannel>,
    #[each(rows in counts.rows.iter())]
    #[is(PixelArray::new(interface.clone(), counts, *rows))]
    array: Vec<PixelArray>,
    #[when(counts.rows.is_none())]
    #[is(ResultStream::new(
        counts.count_bits,
        counts.saturates(),
        counts.total,
        Groups {
            detectors,
            steps: parallel,
            last_steps: interface.last_group_steps() as usize,
            back_to_back: interface.timing.scan.integration_chips == 1,
        },
        is_set,
    ))]
    results: Optional<ResultStream>,
    #[each(peak in counts.peak.iter())]
    #[is(PeakDetector::new(*peak, detectors))]
    peak: Vec<PeakDetector>,
}

/// What follows a target.
fn target_tracker(plan: &RegisterPlan, counts: &Correlator) -> TargetTracker {
    let (Some(track), Some(peak)) = (plan.track, counts.peak) else {
        unreachable!("scenes that follow targets have a peak detector")
    };
    TargetTracker::new(
        track,
        plan.settings(),
        plan.setting_bits() as usize,
        plan.scan_setting_bits() as usize,
        peak.step_bits as usize,
    )
}

/// What is said of the totals in a word of so many bits.
fn about_totals(total: TotalCount, data_bits: u32) -> String {
    format!(
        "{} bits, unsigned, in m_axis_tdata[{}:{}]{}",
        total.bits,
        data_bits - 1,
        total.first_bit,
        if total.saturates() { ", clamped" } else { "" }
    )
}

#[kernel]
impl Logic for SensorTop {
    fn update(&mut self) {
        self.io.transmit();
        if self.results.is_present() {
            self.run_channels();
            self.hand_counts();
        }
        if self.is_set {
            self.run_ahead();
            self.set_scans();
            self.serve_host();
        } else if self.interface.realigns() {
            self.realign();
        }
        if self.results.is_present() {
            self.stream_results();
        } else {
            self.read_rows();
        }
        if self.io.o_peak_valid.is_present() {
            self.find_peaks();
        }
    }

    /// The generators run ahead of the lasers, which are dark while no scan is wanted.
    fn run_ahead(&mut self) {
        for g in 0..self.io.transmit.len() {
            self.io.transmit[g].i_load.next = !self.sequencer[0].o_on.val();
            if self.io.transmit[g].i_seed.is_present() {
                self.io.transmit[g].i_seed.next =
                    self.sequencer[0].o_seed.val().slice(self.seeds[g].0, self.seeds[g].1);
            }
        }
        let sources = self.io.codes.of_sources.len();
        let last = CHIPS_AHEAD as usize - 1;
        self.io.ahead.next = (self.io.ahead.val() << sources)
            | bit_cast(
                self.io.chips.val() & signed_cast(self.sequencer[0].o_on.val()),
                sources * (last + 1),
            );
        self.io.laser.next = self.io.ahead.val().slice(sources * last, sources);
        self.io.epoch_ahead.next = self
            .io
            .epoch_ahead
            .val()
            .shifted_in(self.io.transmit[0].o_epoch.val() & self.sequencer[0].o_on.val());
        self.io.epoch.next = self.io.epoch_ahead.val().get_bit(last);
    }

    /// Steps and scans as the host's settings say.
    fn set_scans(&mut self) {
        let last = CHIPS_AHEAD as usize - 1;
        self.sequencer[0].i_epoch.next = self.io.transmit[0].o_epoch.val();
        self.sequencer[0].i_laser_epoch.next = self.io.epoch_ahead.val().get_bit(last);
        if self.tracks {
            self.track_target();
        } else {
            connect! { self.sequencer[0] from self.registers[0]: i_go, i_word }
        }
        connect! { self.sequencer[0] from self.registers[0]: i_changed }
        for d in 0..self.channel.len() {
            self.channel[d].i_start.next = self.sequencer[0].o_load.val();
            connect! { self.channel[d] from self.sequencer[0]: i_delayed }
            if self.channel[d].i_seed.is_present() {
                self.channel[d].i_seed.next = self.sequencer[0]
                    .o_seed
                    .val()
                    .slice(self.reference_seeds[d].0, self.reference_seeds[d].1);
            }
        }
    }

    /// Between the registers and the sequencer a window has its own settings.
    fn track_target(&mut self) {
        connect! { self.tracker[0] from self.registers[0]: i_go, i_word }
        connect! { self.tracker[0] from self.sequencer[0]: i_taken_first, i_refused, i_run, i_counted }
        connect! { self.sequencer[0] from self.tracker[0]: i_go, i_word }
        self.tracker[0].i_last.next = self.sequencer[0].o_scan_counted.val();
        self.tracker[0].i_count.next = self.channel[0].o_count[0].val();
        self.tracker[0].i_peak_step.next = self.peak[0].o_step.val();
        self.tracker[0].i_peak_count.next = self.peak[0].o_count.val();
        self.tracker[0].i_peak_valid.next = self.peak[0].o_valid.val();
        connect! { self.registers[0] from self.tracker[0]: i_position, i_locked }
        self.registers[0].i_target_lost.next = self.tracker[0].o_lost.val();
    }

    /// The registers, and what they tell.
    fn serve_host(&mut self) {
        connect! {
            self.registers[0] from self.sequencer[0]: i_takes, i_taken_first, i_address, i_refused,
                i_busy, i_scan_counted
        }
        self.registers[0].i_lost.next = self.results.o_lost.val();
        if self.io.o_saturated.is_present() {
            self.registers[0].i_clamps.next = self.results.o_clamps.val();
        }
        if self.io.o_peak_valid.is_present() {
            self.registers[0].i_peak_step.next = self.peak[0].o_step.val();
            self.registers[0].i_peak_count.next = self.peak[0].o_count.val();
        }
        connect! {
            self.registers[0] from self.io.registers: s_axil_awaddr, s_axil_awvalid, s_axil_wdata,
                s_axil_wstrb, s_axil_wvalid, s_axil_bready, s_axil_araddr, s_axil_arvalid,
                s_axil_rready
        }
        connect! {
            self.io.registers from self.registers[0]: s_axil_awready, s_axil_wready, s_axil_bresp,
                s_axil_bvalid, s_axil_arready, s_axil_rdata, s_axil_rresp, s_axil_rvalid
        }
    }

    fn run_channels(&mut self) {
        let samples = self.samples;
        for d in 0..self.channel.len() {
            self.channel[d].i_samples.next = if self.io.combiner.is_empty() {
                self.io.pulses.val().slice(samples * d, samples)
            } else {
                self.io.combiner[d].o_level.val()
            };
            if self.is_set {
                connect! {
                    self.channel[d] from self.sequencer[0]: i_run, i_pre_last_chip, i_last_chip,
                        i_dump
                }
            } else {
                connect! {
                    self.channel[d] from self.controller: i_run, i_pre_last_chip, i_last_chip,
                        i_dump
                }
            }
        }
    }

    fn hand_counts(&mut self) {
        let parallel = self.parallel;
        for d in 0..self.channel.len() {
            for p in 0..parallel {
                self.results.i_count[d * parallel + p].next = self.channel[d].o_count[p].val();
                if self.io.o_saturated.is_present() {
                    self.results.i_clamped[d * parallel + p].next =
                        self.channel[d].o_clamped[p].val();
                }
                if self.io.o_peak_valid.is_present() {
                    self.peak[0].i_count[d * parallel + p].next = self.channel[d].o_count[p].val();
                }
            }
        }
        for d in 0..self.results.i_total.len() {
            self.results.i_total[d].next = self.channel[d].o_total.val();
        }
    }

    /// Scans wait for the code's epoch; the transmitted codes run on.
    fn realign(&mut self) {
        for g in 0..self.io.transmit.len() {
            self.io.transmit[g].i_load.next = false;
        }
        self.controller.i_epoch.next = self.io.transmit[0].o_epoch.val();
        for d in 0..self.channel.len() {
            self.channel[d].i_start.next = self.controller.o_start.val();
        }
        for a in 0..self.array.len() {
            connect! { self.array[a] from self.controller: i_start }
        }
    }

    /// Detectors that share the sums of their counts.
    fn read_rows(&mut self) {
        let samples = self.samples;
        for a in 0..self.array.len() {
            for d in 0..self.detectors {
                self.array[a].i_samples[d].next = if self.io.combiner.is_empty() {
                    self.io.pulses.val().slice(samples * d, samples)
                } else {
                    self.io.combiner[d].o_level.val()
                };
            }
            connect! {
                self.array[a] from self.controller: i_run, i_pre_last_chip, i_last_chip, i_counted
            }
            self.array[a].i_dump.next = self.controller.o_dump.val().get_bit(0);
            self.array[a].i_last.next = self.controller.o_scan_counted.val();
            self.array[a].i_ready.next = self.io.m_axis_tready.val();
            self.io.m_axis_tdata.next = self.array[a].o_data.val();
            self.io.m_axis_tvalid.next = self.array[a].o_valid.val();
            self.io.m_axis_tlast.next = self.array[a].o_last.val();
            connect! { self.io from self.array[a]: o_overrun }
        }
    }

    fn stream_results(&mut self) {
        if self.is_set {
            connect! { self.results from self.sequencer[0]: i_pre_counted, i_counted }
            self.results.i_last.next = self.sequencer[0].o_scan_counted.val();
        } else {
            connect! { self.results from self.controller: i_pre_counted, i_counted }
            self.results.i_last.next = self.controller.o_scan_counted.val();
        }
        self.results.i_ready.next = self.io.m_axis_tready.val();
        self.io.m_axis_tdata.next = self.results.o_data.val();
        self.io.m_axis_tvalid.next = self.results.o_valid.val();
        self.io.m_axis_tlast.next = self.results.o_last.val();
        connect! { self.io from self.results: o_overrun, o_saturated }
    }

    fn find_peaks(&mut self) {
        if self.is_set {
            self.peak[0].i_counted.next = self.sequencer[0].o_counted.val();
            self.peak[0].i_last.next = self.sequencer[0].o_scan_counted.val();
        } else {
            self.peak[0].i_counted.next = self.controller.o_counted.val();
            self.peak[0].i_last.next = self.controller.o_scan_counted.val();
        }
        self.io.o_peak_step.next = self.peak[0].o_step.val();
        self.io.o_peak_count.next = self.peak[0].o_count.val();
        self.io.o_peak_valid.next = self.peak[0].o_valid.val();
    }
}
