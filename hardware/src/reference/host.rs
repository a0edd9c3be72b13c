//! A host that reads and writes registers: an AXI4-Lite master that keeps the rules, and takes its time as it likes.

use std::collections::VecDeque;

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::host_ports::{HostInputs, HostOutputs};

/// Longest time that a valid or a ready waits of its own accord, in clocks.
const LONGEST_WAIT: u32 = 6;

/// What a host is to do next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Request {
    /// A word, or some of its bytes.
    Write {
        /// Byte address.
        address: u32,
        /// The word.
        data: u32,
        /// Which bytes of it.
        strobe: u8,
    },
    /// A word.
    Read {
        /// Byte address.
        address: u32,
    },
    /// A word that is written without a pause, and one that is read so many clocks behind it, whether it has been answered or
    /// not.
    Follow {
        /// Byte address that is written to.
        address: u32,
        /// The word.
        data: u32,
        /// Byte address that is read.
        read: u32,
        /// Clocks.
        clocks: u32,
    },
    /// Nothing for so many clocks.
    Wait {
        /// Clocks.
        clocks: u64,
    },
    /// The next transfer of a channel waits for so many clocks.
    Stall {
        /// Where.
        channel: Channel,
        /// Clocks.
        clocks: u32,
    },
    /// A word that is written in the very clock in which the hardware does something, if it does so soon enough.
    Meet {
        /// What the hardware does.
        event: HardwareEvent,
        /// Byte address.
        address: u32,
        /// The word.
        data: u32,
        /// Clocks for which the host waits for that.
        within: u64,
    },
}

/// What of a transfer can be made to wait.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Channel {
    /// An address that is written to, behind its data.
    WriteAddress,
    /// Data that are written, behind their address.
    WriteData,
    /// The response to a write.
    WriteResponse,
    /// A word that was read.
    Read,
}

/// What the hardware does to the registers of state by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HardwareEvent {
    /// The first of the settings is taken over.
    TakeOver,
    /// Settings are refused.
    Refusal,
    /// A group of results is lost.
    Loss,
    /// A count is clamped.
    Clamp,
    /// A target is lost.
    TargetLost,
}

impl Request {
    /// A whole word.
    pub fn write(address: u32, data: u32) -> Request {
        Request::Write { address, data, strobe: 0xf }
    }
}

/// A write under way.
#[derive(Debug, Clone, Copy)]
struct Writing {
    address: u32,
    data: u32,
    strobe: u8,
    /// Clocks until the address is there, and the data.
    address_after: u32,
    data_after: u32,
}

/// The host.
#[derive(Debug, Clone)]
pub struct Host {
    rng: Xoshiro256PlusPlus,
    /// Addresses that it reads beside what it is asked for.
    addresses: Vec<u32>,
    requests: VecDeque<Request>,
    waits: u64,
    write: Option<Writing>,
    /// The address that is read, and clocks until it is there.
    read: Option<(u32, u32)>,
    /// Responses to come, of writes and reads.
    answers: (u32, u32),
    /// Clocks until the next of each is taken.
    takes_after: (u32, u32),
    /// What the next transfer of a channel waits.
    stall: Option<(Channel, u32)>,
    /// A write that waits for the hardware, and for how many clocks it still does.
    meets: Option<(HardwareEvent, Writing, u64)>,
}

impl Host {
    /// One that does nothing until it is asked to; beside that it reads at these addresses.
    pub fn new(seed: u64, addresses: Vec<u32>) -> Host {
        Host {
            rng: Xoshiro256PlusPlus::seed_from_u64(seed),
            addresses,
            requests: VecDeque::new(),
            waits: 0,
            write: None,
            read: None,
            answers: (0, 0),
            takes_after: (0, 0),
            stall: None,
            meets: None,
        }
    }

    /// Asks it for more.
    pub fn ask(&mut self, requests: impl IntoIterator<Item = Request>) {
        self.requests.extend(requests);
    }

    /// Whether it has nothing to do.
    pub fn is_idle(&self) -> bool {
        self.requests.is_empty()
            && self.waits == 0
            && self.meets.is_none()
            && self.write.is_none()
            && self.read.is_none()
            && self.answers == (0, 0)
    }

    /// A reset ends what is under way.
    pub fn reset(&mut self) {
        (self.write, self.read, self.answers) = (None, None, (0, 0));
        (self.stall, self.meets) = (None, None);
    }

    /// What it drives at a clock at which the slave shows this, and in the clock behind which the hardware does what
    /// `comes` holds of: a write whose address and data are there now takes place then.
    pub fn next(
        &mut self,
        shown: &HostOutputs,
        comes: impl Fn(HardwareEvent) -> bool,
    ) -> HostInputs {
        match self.meets.take() {
            None => self.begin(),
            Some((event, writing, _)) if !shown.write_response_valid && comes(event) => {
                self.write = Some(writing);
            }
            Some((event, writing, clocks)) => {
                self.meets = (clocks > 0).then(|| (event, writing, clocks - 1));
            }
        }
        // What is there while nothing is valid means nothing.
        let mut inputs = HostInputs {
            write_address: self.rng.random_range(0..1 << 12),
            write_data: self.rng.random(),
            write_strobe: self.rng.random_range(0..16),
            read_address: self.rng.random_range(0..1 << 12),
            ..HostInputs::default()
        };
        if let Some(write) = &mut self.write {
            inputs.write_address_valid = write.address_after == 0;
            inputs.write_valid = write.data_after == 0;
            write.address_after = write.address_after.saturating_sub(1);
            write.data_after = write.data_after.saturating_sub(1);
            if inputs.write_address_valid {
                inputs.write_address = write.address as u16;
            }
            if inputs.write_valid {
                (inputs.write_data, inputs.write_strobe) = (write.data, write.strobe);
            }
            if inputs.write_address_valid && inputs.write_valid && shown.write_ready {
                self.write = None;
                self.answers.0 += 1;
                self.takes_after.0 = self.wait_of(Channel::WriteResponse);
            }
        }
        if let Some((address, after)) = &mut self.read {
            inputs.read_address_valid = *after == 0;
            *after = after.saturating_sub(1);
            if inputs.read_address_valid {
                inputs.read_address = *address as u16;
                if shown.read_address_ready {
                    self.read = None;
                    self.answers.1 += 1;
                    self.takes_after.1 = self.wait_of(Channel::Read);
                }
            }
        }
        inputs.write_response_ready =
            ready(shown.write_response_valid, &mut self.answers.0, &mut self.takes_after.0);
        inputs.read_ready = ready(shown.read_valid, &mut self.answers.1, &mut self.takes_after.1);
        inputs
    }

    /// Begins what comes next.
    fn begin(&mut self) {
        if self.waits > 0 {
            self.waits -= 1;
        } else if self.write.is_none() && self.read.is_none() {
            match self.requests.pop_front() {
                Some(Request::Write { address, data, strobe }) => {
                    let (address_after, data_after) =
                        match (self.stall, self.rng.random_range(0..3)) {
                            (Some((Channel::WriteData, _)), _) => {
                                (0, self.wait_of(Channel::WriteData))
                            }
                            (Some((Channel::WriteAddress, _)), _) => {
                                (self.wait_of(Channel::WriteAddress), 0)
                            }
                            (_, 0) => (0, 0),
                            (_, 1) => (0, self.wait()),
                            _ => (self.wait(), 0),
                        };
                    self.write = Some(Writing { address, data, strobe, address_after, data_after });
                }
                Some(Request::Read { address }) => self.read = Some((address, self.wait())),
                Some(Request::Follow { address, data, read, clocks }) => {
                    let (strobe, address_after, data_after) = (0xf, 0, 0);
                    self.write = Some(Writing { address, data, strobe, address_after, data_after });
                    self.read = Some((read, clocks));
                }
                Some(Request::Wait { clocks }) => self.waits = clocks,
                Some(Request::Stall { channel, clocks }) => self.stall = Some((channel, clocks)),
                Some(Request::Meet { event, address, data, within }) => {
                    let (strobe, address_after, data_after) = (0xf, 0, 0);
                    let writing = Writing { address, data, strobe, address_after, data_after };
                    self.meets = Some((event, writing, within));
                }
                None => {}
            }
        }
        // Both channels at once.
        if self.read.is_none() && self.write.is_some() && self.rng.random_bool(0.3) {
            let at = self.rng.random_range(0..self.addresses.len());
            self.read = Some((self.addresses[at], 0));
        }
    }

    /// Clocks for which a transfer of a channel waits.
    fn wait_of(&mut self, channel: Channel) -> u32 {
        match self.stall.take_if(|(stalled, _)| *stalled == channel) {
            Some((_, clocks)) => clocks,
            None => self.wait(),
        }
    }

    fn wait(&mut self) -> u32 {
        match self.rng.random_bool(0.5) {
            true => 0,
            false => self.rng.random_range(0..LONGEST_WAIT),
        }
    }
}

/// Whether a response is taken at a clock.
fn ready(is_there: bool, answers: &mut u32, after: &mut u32) -> bool {
    if *answers == 0 {
        return false;
    }
    if *after > 0 {
        *after -= u32::from(is_there);
        return false;
    }
    *answers -= u32::from(is_there);
    true
}
