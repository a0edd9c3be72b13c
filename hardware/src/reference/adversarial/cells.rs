//! Pulses of single cells that make a level.

use std::ops::Range;

use rand::seq::IndexedRandom as _;
use rand::{Rng, RngExt};

use super::hits::length;
use crate::photons::Pulse;
use crate::reference::planned::Hits;
use crate::scan::Sample;
use crate::sensor::cells::Cells;

/// Pulses of each cell that make the level high in these samples where one of `level` is, which are in
/// order, and low elsewhere. Whatever cells can do meanwhile they do: as many of them as the level
/// allows, others at any sample, all or one that change.
pub(super) fn spread(
    level: &[Pulse],
    samples: Range<Sample>,
    cells: &Cells,
    rng: &mut impl Rng,
) -> Vec<Vec<Pulse>> {
    let numbers = |is_high| (0..=cells.count).filter(move |&n| cells.level(n) == is_high);
    let allowed: [Vec<u32>; 2] = [false, true].map(|is_high| numbers(is_high).collect());
    let longest = length(rng, 64);
    let mut pulses: Vec<Vec<Pulse>> = vec![Vec::new(); cells.count as usize];
    let mut level = level.iter().peekable();
    let mut high_until = samples.start;
    let mut high = 0_u64;
    let mut at = samples.start;
    while at < samples.end {
        while let Some(pulse) = level.next_if(|pulse| pulse.first <= at) {
            high_until = high_until.max(pulse.end);
        }
        let is_high = high_until > at;
        let border = match is_high {
            true => high_until,
            false => level.peek().map_or(samples.end, |pulse| pulse.first),
        };
        let end = border.min(samples.end).min(at + rng.random_range(1..=longest));
        let one_changed = high ^ 1 << rng.random_range(0..cells.count);
        let is_allowed = cells.level(one_changed.count_ones()) == is_high;
        high = match is_allowed && rng.random() {
            true => one_changed,
            false => {
                let number = allowed[usize::from(is_high)].choose(rng);
                some(number.copied().unwrap_or_default(), cells.count, rng)
            }
        };
        for (cell, pulses) in pulses.iter_mut().enumerate() {
            match pulses.last_mut() {
                _ if high >> cell & 1 == 0 => {}
                Some(last) if last.end == at => last.end = end,
                _ => pulses.push(Pulse { first: at, end }),
            }
        }
        at = end;
    }
    pulses
}

/// Pulses of each cell where all their edges count. What aims at single hits has each pulse at one cell,
/// and pulses at the same sample at as many; what wants many has them at all cells. Otherwise some cells
/// have them, at the same samples or each at its own.
pub(super) fn share(
    level: &[Pulse],
    samples: Range<Sample>,
    cells: u32,
    hits: Hits,
    rng: &mut impl Rng,
) -> Vec<Vec<Pulse>> {
    let mut pulses: Vec<Vec<Pulse>> = vec![Vec::new(); cells as usize];
    let is_random = hits == Hits::Random;
    if is_random && rng.random() {
        let end = level.iter().map(|pulse| pulse.end).max().unwrap_or(samples.end).min(samples.end);
        for pulses in &mut pulses {
            let late = rng.random_range(0..16);
            let of_cell = level
                .iter()
                .map(|pulse| Pulse { first: pulse.first + late, end: end.min(pulse.end + late) });
            pulses.extend(of_cell.filter(|pulse| pulse.first < pulse.end));
        }
        return pulses;
    }
    for same in level.chunk_by(|a, b| a.first == b.first) {
        let number = match is_random {
            true => *[1, rng.random_range(1..=cells), cells].choose(rng).unwrap_or(&1),
            false if hits.is_single() => same.len() as u32,
            false => cells,
        };
        let chosen = some(number, cells, rng);
        let of_chosen = pulses.iter_mut().enumerate().filter(|(cell, _)| chosen >> cell & 1 == 1);
        of_chosen.for_each(|(_, pulses)| pulses.push(same[0]));
    }
    pulses
}

/// So many of all cells, any as likely as others.
fn some(number: u32, all: u32, rng: &mut impl Rng) -> u64 {
    let mut left = number;
    (0..all).fold(0, |chosen, cell| {
        let is_chosen = rng.random_range(0..all - cell) < left;
        left -= u32::from(is_chosen);
        chosen | u64::from(is_chosen) << cell
    })
}
