//! Where decoded records go.

use super::{Channel, Tag};

/// Records that are decoded together where they are of one input and in order.
pub(super) const RUN: usize = 8;

/// Takes records in the order of the file.
pub(super) trait Sink {
    /// One of them.
    fn tag(&mut self, ticks: u64, channel: Channel);

    /// Several of one channel, none of them earlier than the one before.
    fn run(&mut self, ticks: &[u64; RUN], channel: Channel) {
        ticks.iter().for_each(|&ticks| self.tag(ticks, channel));
    }
}

impl Sink for Vec<Tag> {
    fn tag(&mut self, ticks: u64, channel: Channel) {
        self.push(Tag { ticks, channel });
    }
}

/// Times of some channels, each in a list of its own.
pub(super) struct Selected<'a> {
    pub wanted: &'a [Channel],
    pub ticks: &'a mut [Vec<u64>],
    /// Records of other channels.
    pub others: u64,
}

impl Selected<'_> {
    fn list(&mut self, channel: Channel) -> Option<&mut Vec<u64>> {
        let place = self.wanted.iter().position(|wanted| *wanted == channel)?;
        self.ticks.get_mut(place)
    }
}

impl Sink for Selected<'_> {
    fn tag(&mut self, ticks: u64, channel: Channel) {
        match self.list(channel) {
            Some(list) => list.push(ticks),
            None => self.others += 1,
        }
    }

    fn run(&mut self, ticks: &[u64; RUN], channel: Channel) {
        match self.list(channel) {
            Some(list) => list.extend_from_slice(ticks),
            None => self.others += RUN as u64,
        }
    }
}

/// How records follow one another.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct RecordOrder {
    /// The latest time so far.
    latest: u64,
    /// Records that are earlier than one before them.
    pub disordered: u64,
}

/// A sink whose records' order is looked at on their way.
pub(super) struct Ordered<'a, S> {
    pub order: &'a mut RecordOrder,
    pub sink: &'a mut S,
}

impl<S: Sink> Sink for Ordered<'_, S> {
    fn tag(&mut self, ticks: u64, channel: Channel) {
        self.order.disordered += u64::from(ticks < self.order.latest);
        self.order.latest = self.order.latest.max(ticks);
        self.sink.tag(ticks, channel);
    }

    fn run(&mut self, ticks: &[u64; RUN], channel: Channel) {
        if ticks[0] < self.order.latest {
            ticks.iter().for_each(|&ticks| self.tag(ticks, channel));
        } else {
            self.order.latest = ticks[RUN - 1];
            self.sink.run(ticks, channel);
        }
    }
}
