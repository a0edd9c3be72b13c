//! What a host starts and stops, and what scans tell it.

use crate::rtl::front::prelude::*;
use crate::sensor::registers::{LOST_BITS, SCANS_BITS, state};

#[block(scan_state)]
/// state of the scans: what a host asks for, and what it is told
///
/// After reset scans follow one another.
pub struct ScanState {
    /// Whether counts can be clamped.
    saturates: bool,
    /// Whether a target is followed.
    tracks: bool,
    /// Bits of what is written that nothing follows from.
    #[set(unread(saturates, tracks))]
    unread: Vec<u32>,
    /// a setting is written
    #[under("Writes")]
    pub i_set: Input<bool>,
    /// the control register is
    pub i_control: Input<bool>,
    /// flags are, which 1s clear
    pub i_clear: Input<bool>,
    /// with this
    #[width(written_bits(tracks))]
    pub i_data: Input<Word>,
    /// the first setting is read
    #[under("Scans")]
    pub i_taken_first: Input<bool>,
    /// settings do not fit
    pub i_refused: Input<bool>,
    /// a scan is under way, or prepared
    pub i_busy: Input<bool>,
    /// the count of a scan's last step is there
    pub i_scan_counted: Input<bool>,
    /// a group of results was lost
    pub i_lost: Input<bool>,
    /// a count was clamped
    #[when(saturates)]
    pub i_clamps: Optional<Input<bool>>,
    /// the last window had its light
    #[when(tracks)]
    pub i_locked: Optional<Input<bool>>,
    /// it has just been lost
    #[when(tracks)]
    pub i_target_lost: Optional<Input<bool>>,
    /// scans are wanted
    pub o_go: Output<bool>,
    /// settings were written since the last take-over, or a single scan was asked for
    pub o_changed: Output<bool>,
    /// what the control and status registers read as
    #[width(32)]
    pub o_state: Output<Word>,
    /// scans follow one another
    #[reset(true)]
    runs: Register<bool>,
    /// one scan is asked for
    single: Register<bool>,
    changed: Register<bool>,
    overrun: Register<bool>,
    #[when(saturates)]
    saturated: Optional<Register<bool>>,
    refused: Register<bool>,
    /// a target was lost
    #[when(tracks)]
    target_lost: Optional<Register<bool>>,
    /// groups of results that were lost
    #[width(LOST_BITS)]
    lost: Register<Word>,
    /// scans that have ended
    #[width(SCANS_BITS)]
    scans: Register<Word>,
    was_clamped: Local<bool>,
    /// bits that mean nothing to be written; linters know by the name
    unused: Local<bool>,
}

/// Bits from the lowest up to the last one that something follows from when it is written.
pub(super) fn written_bits(tracks: bool) -> u32 {
    1 + if tracks { state::LOCK_LOST } else { state::REFUSED }
}

fn unread(saturates: bool, tracks: bool) -> Vec<u32> {
    let clamps = (!saturates).then_some(state::SATURATED);
    let locks = tracks.then_some(state::LOCKED);
    [Some(state::BUSY), clamps, locks].into_iter().flatten().collect()
}

#[kernel]
impl Logic for ScanState {
    fn update(&mut self) {
        self.control();
        self.tell();
        self.gather_state();
        self.unused.next =
            gather(self.unread.len(), |b| self.i_data.val().get_bit(self.unread[b] as usize)).any();
    }

    /// Of two things at once the host's write counts, and of an event and the write that clears its flag the event.
    fn control(&mut self) {
        if self.i_refused.val() {
            self.runs.next = false;
            self.single.next = false;
        }
        if self.i_taken_first.val() {
            self.single.next = false;
            self.changed.next = false;
        }
        if self.i_set.val() {
            self.changed.next = true;
        }
        if self.i_control.val() {
            self.runs.next = self.i_data.val().get_bit(state::RUN as usize);
            self.single.next = self.i_data.val().get_bit(state::SINGLE as usize);
            if self.i_data.val().get_bit(state::SINGLE as usize) {
                self.changed.next = true;
            }
        }
        self.o_go.next = self.runs.val() | self.single.val();
        self.o_changed.next = self.changed.val();
    }

    fn tell(&mut self) {
        if self.i_clear.val() {
            if self.i_data.val().get_bit(state::OVERRUN as usize) {
                self.overrun.next = false;
            }
            if self.i_data.val().get_bit(state::REFUSED as usize) {
                self.refused.next = false;
            }
            if self.saturates && self.i_data.val().get_bit(state::SATURATED as usize) {
                self.saturated.next = false;
            }
            if self.tracks && self.i_data.val().get_bit(state::LOCK_LOST as usize) {
                self.target_lost.next = false;
            }
        }
        if self.i_refused.val() {
            self.refused.next = true;
        }
        if self.i_lost.val() {
            self.overrun.next = true;
            self.lost.next = self.lost.val() + 1;
        }
        if self.saturates && self.i_clamps.val() {
            self.saturated.next = true;
        }
        if self.tracks && self.i_target_lost.val() {
            self.target_lost.next = true;
        }
        if self.i_scan_counted.val() {
            self.scans.next = self.scans.val() + 1;
        }
    }

    fn gather_state(&mut self) {
        if self.saturates {
            self.was_clamped.next = self.saturated.val();
        } else {
            self.was_clamped.next = false;
        }
        self.o_state.next = gather(32, |place| {
            if place == state::RUN as usize {
                self.runs.val()
            } else if place == state::SINGLE as usize {
                self.single.val()
            } else if place == state::BUSY as usize {
                self.i_busy.val()
            } else if place == state::OVERRUN as usize {
                self.overrun.val()
            } else if place == state::SATURATED as usize {
                self.was_clamped.val()
            } else if place == state::REFUSED as usize {
                self.refused.val()
            } else if self.tracks && place == state::LOCKED as usize {
                self.i_locked.val()
            } else if self.tracks && place == state::LOCK_LOST as usize {
                self.target_lost.val()
            } else if place < state::LOST as usize {
                false
            } else if place < state::SCANS as usize {
                self.lost.val().get_bit(place - state::LOST as usize)
            } else {
                self.scans.val().get_bit(place - state::SCANS as usize)
            }
        });
    }
}
