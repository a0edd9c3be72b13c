//! The whole sensor, with a histogram of arrival times in place of up/down counts.
//!
//! The host correlates: no reference is made here.

use super::histogram_channel::about_clamping;
use super::sensor_shell::{about_clock, about_power_up};
use super::{HistogramChannel, HistogramControl, SensorShell};
use crate::rtl::front::prelude::*;
use crate::sensor::histogram::HistogramPlan;
use crate::sensor::interface::Interface;

#[block(sensor_top)]
/// DS-CDMA indirect time-of-flight sensor, lasers out, SPAD samples in, histograms out
///
/// {about_clock(histogram.row_bins, "outputs")}
///
/// Every rising edge of a detector's level counts in the bin of its sample of the code period: a row for each chip, from
/// the one that o_epoch marks, a bin for each sample. The up/down count of phase step k is the sum of all bins, those
/// negative whose chip of the reference, delayed by k samples, is 0.
///
/// {about_power_up("frame")}
#[when(detectors == 1)]
/// - Frame: {histogram.periods} code periods, {histogram.rows} rows of {histogram.row_bins} bins
#[when(detectors > 1)]
/// - Frame: {histogram.periods} code periods, {histogram.rows} rows of {histogram.row_bins} bins, for {detectors}
/// detectors in turn
///
/// - Bins: {histogram.bin_bits} bits, unsigned{about_clamping(histogram.saturates())}
#[when(histogram.takes_turns())]
/// - Memory: {histogram.memory_bits(detectors)} bits: one histogram counts while the other is read
#[when(!histogram.takes_turns())]
/// - Memory: {histogram.memory_bits(detectors)} bits: a frame's rows leave while the next frame's first code period is
/// counted
///
/// - Latency: m_axis_tvalid {interface.result_latency_clocks} clocks after the one at which a frame's last word is on
/// i_samples
/// - Rate: one chip per clock, and at most one row
pub struct HistogramTop {
    interface: Interface,
    histogram: HistogramPlan,
    #[set(interface.reference_codes.len())]
    detectors: usize,
    /// ports, and what drives the lasers
    #[is(SensorShell::new(interface.clone()))]
    pub io: SensorShell,
    #[is(HistogramControl::new(histogram, detectors))]
    control: HistogramControl,
    #[each(_detector in 0..detectors)]
    #[is(HistogramChannel::new(histogram))]
    channel: Vec<HistogramChannel>,
    #[each(detector in 0..if detectors > 1 { detectors } else { 0 })]
    #[about(match detector {
        0 => "row of detector 0, if it is its turn".to_owned(),
        _ => format!("and of detector {detector}"),
    })]
    #[width(histogram.row_data_bits())]
    choice: Vec<Local<Word>>,
    /// row on the stream
    #[width(histogram.row_data_bits())]
    row: Register<Word>,
    #[when(histogram.saturates())]
    #[width(detectors)]
    clamped: Optional<Local<Word>>,
    #[when(histogram.saturates())]
    saturated: Optional<Register<bool>>,
}

#[kernel]
impl Logic for HistogramTop {
    fn update(&mut self) {
        self.io.transmit();
        self.control.i_ready.next = self.io.m_axis_tready.val();
        self.run_channels();
        self.offer_rows();
        if self.io.o_saturated.is_present() {
            self.flag_clamped();
        }
    }

    fn run_channels(&mut self) {
        let lanes = self.histogram.row_bins as usize;
        for d in 0..self.channel.len() {
            self.channel[d].i_samples.next = if self.io.combiner.is_empty() {
                self.io.pulses.val().slice(lanes * d, lanes)
            } else {
                self.io.combiner[d].o_level.val()
            };
            connect! {
                self.channel[d] from self.control: i_run, i_row, i_half, i_read_row, i_go,
                    i_come_first, i_come_half, i_held_first, i_held_half, i_added_first,
                    i_write_row, i_write_half
            }
        }
    }

    fn offer_rows(&mut self) {
        let detectors = self.detectors;
        if detectors > 1 {
            self.choice[0].next = self.channel[0].o_bins.val()
                & signed_cast(self.control.o_read_detector.val().get_bit(0));
            for d in 1..detectors {
                self.choice[d].next = self.choice[d - 1].val()
                    | (self.channel[d].o_bins.val()
                        & signed_cast(self.control.o_read_detector.val().get_bit(d)));
            }
            if self.control.o_shows.val() {
                self.row.next = self.choice[detectors - 1].val();
            }
        } else if self.control.o_shows.val() {
            self.row.next = self.channel[0].o_bins.val();
        }
        self.io.m_axis_tdata.next = self.row.val();
        self.io.m_axis_tvalid.next = self.control.o_valid.val();
        self.io.m_axis_tlast.next = self.control.o_last.val();
        self.io.o_overrun.next = self.control.o_overrun.val();
    }

    fn flag_clamped(&mut self) {
        self.clamped.next = gather(self.detectors, |d| self.channel[d].o_clamped.val());
        if self.clamped.val().any() {
            self.saturated.next = true;
        }
        self.io.o_saturated.next = self.saturated.val();
    }
}
