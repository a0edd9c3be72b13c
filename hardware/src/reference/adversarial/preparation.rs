//! What comes before the first aim: a scan's end, large counts, and counts that hardly
//! differ. No cover point asks for any of it, and faults hide there all the same.

use rand::{Rng, RngExt};

use super::Means;
use super::hits::length;
use crate::reference::planned::{Hits, Length, PlannedGroup, Shortening};
use crate::scene::DetectorIndex;
use crate::sensor::interface::{Correlator, Interface};

/// Parts of the counters' range from each of which a large count is to begin.
const PARTS: u64 = 8;
/// Groups of hits of one sign that are as long as chance has it.
const GROUPS_OF_ANY_LENGTH: usize = 64;

/// All of it, in order.
pub(super) fn plans(
    interface: &Interface,
    reach: &Shortening,
    means: &Means,
    rng: &mut impl Rng,
) -> Vec<PlannedGroup> {
    let mut plans = scan_end(interface, reach);
    // Every frame of a histogram begins anew: there is no range of counters to begin all over.
    if let Some(correlator) = interface.correlator() {
        let most_clocks = means.clocks_of_close_counts;
        plans.extend(large_counts(interface, correlator, means.clocks_of_large_counts, rng));
        plans.extend(close_totals(interface, correlator, most_clocks));
        plans.extend(close_peaks(interface, correlator, reach, most_clocks));
    }
    plans
}

/// Groups up to a scan's end, and behind it: as many as the step counter has bits, and
/// more, so that each of them has to be right.
fn scan_end(interface: &Interface, reach: &Shortening) -> Vec<PlannedGroup> {
    let groups = u64::from(interface.groups().ilog2()) + 6;
    if !reach.leaves_out || interface.groups() < 2 * groups {
        return Vec::new();
    }
    let dense = || PlannedGroup::random().with(Hits::EveryOther);
    let mut plans = vec![dense().then_the_last_but(groups)];
    plans.extend((0..2 * groups).map(|_| dense()));
    plans
}

/// Groups with hits of one sign, as many as fit into `most_clocks`: some of any length,
/// then counts beyond every limit, then counts as large as they get that begin all over
/// the range of the counters. Carries and borrows of a step's difference depend on where
/// its total stood before it, and short steps from a reset on do not get there.
fn large_counts(
    interface: &Interface,
    correlator: &Correlator,
    most_clocks: u64,
    rng: &mut impl Rng,
) -> Vec<PlannedGroup> {
    let whole = interface.timing.scan.integration_chips;
    let any_length: Vec<(u64, PlannedGroup)> = (0..GROUPS_OF_ANY_LENGTH)
        .map(|_| {
            let (step, up) = (rng.random_range(0..interface.parallel().into()), rng.random());
            let chips = length(rng, whole).clamp(64.min(whole), whole);
            let plan = PlannedGroup::random().with(Hits::OneSided { step, up });
            (chips, plan.long(Length::AtLeast(chips)))
        })
        .take_while(within(most_clocks / 2))
        .collect();
    let used: u64 = any_length.iter().map(|(chips, _)| chips).sum();
    let others = beyond_limits(interface, correlator).chain(all_over(interface, correlator));
    let others = others.take_while(within(most_clocks - used));
    let plans = any_length.into_iter().chain(others);
    plans.map(|(_, plan)| plan).collect()
}

/// Whether groups still fit into so many clocks.
fn within(most_clocks: u64) -> impl FnMut(&(u64, PlannedGroup)) -> bool {
    let mut clocks = 0u64;
    move |(chips, _)| {
        clocks = clocks.saturating_add(*chips);
        clocks <= most_clocks
    }
}

/// Counts of single bits above what the results hold, up to the most hits of a step:
/// what tells that a count is too large has to look at each of them. With the chips that
/// they may take.
fn beyond_limits(
    interface: &Interface,
    correlator: &Correlator,
) -> impl Iterator<Item = (u64, PlannedGroup)> {
    let whole = interface.timing.scan.integration_chips;
    let most = whole.saturating_mul(u64::from(correlator.pairs));
    let bits = move |from: u32| from..=most.ilog2().min(62);
    let detectors = || DetectorIndex::all().take(interface.reference_codes.len());
    let total = correlator.total.filter(|total| total.saturates());
    let totals = total.into_iter().flat_map(move |total| {
        let all = detectors()
            .flat_map(move |detector| bits(total.bits).map(move |bit| (detector, 1u64 << bit)));
        all.map(|(detector, hits)| Hits::Total { detector, hits })
    });
    let steps = 0..u64::from(interface.parallel());
    let saturates = correlator.saturates();
    let counts = steps.filter(move |_| saturates).flat_map(move |step| {
        let of_detector = move |detector| {
            let counts = bits(correlator.count_bits - 1);
            let both = counts.flat_map(|bit| [1i64 << bit, -(1i64 << bit)]);
            both.map(move |count| Hits::Count { detector, step, count })
        };
        detectors().flat_map(of_detector)
    });
    let plan = move |hits| (whole, PlannedGroup::random().with(hits));
    totals.chain(counts).map(plan)
}

/// Counts as large as they get, up and down, from each part of the counters' range. With
/// their chips.
fn all_over(
    interface: &Interface,
    correlator: &Correlator,
) -> impl Iterator<Item = (u64, PlannedGroup)> {
    let whole = interface.timing.scan.integration_chips;
    // Of a code's chips half have the sign.
    let pairs = u64::from(correlator.pairs);
    let chips_to_count = |counts: u64| counts.saturating_mul(2).div_ceil(pairs);
    let part_bits = correlator.count_segments.bits().saturating_sub(PARTS.ilog2());
    let stride = chips_to_count(1u64 << part_bits.min(62));
    // Groups of the same sign go on, or go back, to the next part.
    let (back, on) = (whole.saturating_sub(stride), stride.saturating_sub(whole));
    let steps = 0..u64::from(interface.parallel());
    steps.flat_map(move |step| {
        let side = move |up| PlannedGroup::random().with(Hits::OneSided { step, up });
        let part = move |up| {
            let on = (0..on.div_ceil(whole)).map(move |_| (whole, side(up).long(Length::Whole)));
            let back = (back > 0).then(|| (back, side(!up).long(Length::AtLeast(back))));
            std::iter::once((whole, side(up).long(Length::Whole))).chain(back).chain(on)
        };
        [true, false].into_iter().flat_map(move |up| (0..PARTS).flat_map(move |_| part(up)))
    })
}

/// Scans whose largest count is by one or two more, or less, than the one before it: a peak's
/// comparison has to look at each bit, and at the lowest of two that hardly differ. As many
/// as fit into `most_clocks`.
fn close_peaks(
    interface: &Interface,
    correlator: &Correlator,
    reach: &Shortening,
    most_clocks: u64,
) -> Vec<PlannedGroup> {
    if correlator.peak.is_none() || !reach.leaves_out {
        return Vec::new();
    }
    let whole = interface.timing.scan.integration_chips;
    let limit = 1i64 << (correlator.count_bits - 1).min(62);
    let near_powers = (4..62).flat_map(|bit| [1i64 << bit, (1i64 << bit) + 1]);
    // Of a code's chips half have the sign, and hits are at most on every other sample.
    let chips = |count: i64| 64 + 4 * count.unsigned_abs();
    let counts = (1..16).chain(near_powers);
    let counts = counts.take_while(|&count| count < limit && chips(count) < whole);
    let pairs = counts.flat_map(|count| {
        let others = [[count - 1, count], [count, count - 1], [count - 2, count]];
        others.into_iter().filter(|pair| pair[0] >= 0)
    });
    let scans = pairs.flat_map(|pair| {
        let detectors = DetectorIndex::all().take(interface.reference_codes.len());
        detectors.flat_map(move |detector| {
            let [first, last] = pair.map(|count| {
                let chips = chips(count);
                let step = 0;
                let hits = Hits::Count { detector, step, count };
                let length = Length::AtLeast(chips);
                (chips, PlannedGroup::random().with(hits).long(length))
            });
            [(first.0, first.1.then_the_last()), last]
        })
    });
    // From the first group of a scan on.
    let begin = PlannedGroup::fresh(interface).with(Hits::None).then_the_last();
    let end = PlannedGroup::random().with(Hits::None);
    let whole_scan = [(2 * reach.shortest, begin), (0, end)];
    let plans = whole_scan.into_iter().chain(scans);
    plans.take_while(within(most_clocks)).map(|(_, plan)| plan).collect()
}

/// Totals round each bit beyond what the results hold, from wherever the running total stands:
/// the carries of its difference depend on both.
fn close_totals(
    interface: &Interface,
    correlator: &Correlator,
    most_clocks: u64,
) -> Vec<PlannedGroup> {
    const ROUNDS: u64 = 4;
    let Some(total) = correlator.total.filter(|total| total.saturates()) else {
        return Vec::new();
    };
    let whole = interface.timing.scan.integration_chips;
    let most = whole.saturating_mul(u64::from(correlator.pairs));
    let bits = total.bits..=most.ilog2().min(62);
    let hits = bits.flat_map(|bit| {
        let near = (0..ROUNDS).flat_map(move |_| (1u64 << bit) - 2..=(1u64 << bit) + 3);
        near.filter(move |&hits| hits <= most)
    });
    let plans = hits.flat_map(|hits| {
        let detectors = DetectorIndex::all().take(interface.reference_codes.len());
        detectors.map(move |detector| {
            let hits = Hits::Total { detector, hits };
            (whole, PlannedGroup::random().with(hits))
        })
    });
    plans.take_while(within(most_clocks)).map(|(_, plan)| plan).collect()
}
