//! What is done to a board: results at every rate, requests whole and torn, resets, light.

use goldtof_wire::{
    MOST_RESULTS_OF_A_FRAME, REQUEST_BYTES, REQUEST_HITS, REQUEST_IDENTITY, REQUEST_READ,
    REQUEST_WRITE, encode,
};
use rand::RngExt as _;

use super::maker::{Maker, SILENCE};
use super::model::{Facts, HALF_ROUND, MOST_PLACES};
use super::own_core::whole;
use super::script::{BoardScript, ExpectedAnswer, HITS_OF_BLOCK, Moment};
use crate::cosim::error::CosimError;
use crate::sensor::Sensor;
use crate::wire::ScanSums;

/// A run of the board.
pub(super) struct PlannedRun {
    pub name: &'static str,
    /// Whether it says anything of the board.
    pub is_meant: fn(&Facts) -> bool,
    pub script: fn(&Sensor, &Facts, u64) -> Result<BoardScript, CosimError>,
}

/// All of them, those of the board's own core last.
pub(super) const RUNS: [PlannedRun; 9] = [
    PlannedRun {
        name: "requests, whole and torn, of a host that sends as fast as a board may take, and reads slower",
        is_meant: |_| true,
        script: |_, facts, seed| Ok(torn_requests(facts, seed)),
    },
    PlannedRun {
        name: "requests, whole and broken, of a host that sends as slowly as a board may take, and reads faster",
        is_meant: |_| true,
        script: |_, facts, seed| Ok(broken_requests(facts, seed)),
    },
    PlannedRun {
        name: "results as fast as the line, and faster",
        is_meant: |facts| facts.loses() && facts.sums.is_none(),
        script: |_, facts, seed| Ok(too_fast(facts, seed)),
    },
    PlannedRun {
        name: "sums of scans that come faster than the line",
        is_meant: |facts| facts.sums.is_some_and(|sums| facts.loses_sums(&sums)),
        script: |_, facts, seed| Ok(sums_too_fast(facts, seed)),
    },
    PlannedRun {
        name: "results of a core that waits for the line",
        is_meant: |facts| facts.packing.waits,
        script: |_, facts, seed| Ok(waiting(facts, seed)),
    },
    PlannedRun {
        name: "resets by the PLL's lock",
        is_meant: |_| true,
        script: |_, facts, seed| Ok(resets(facts, seed)),
    },
    PlannedRun {
        name: "resets among losses",
        is_meant: |facts| facts.loses() && facts.sums.is_none(),
        script: |_, facts, seed| Ok(resets_among_losses(facts, seed)),
    },
    PlannedRun {
        name: "hits by sample",
        is_meant: |facts| facts.identity.counts_samples,
        script: |_, facts, seed| Ok(hits(facts, seed)),
    },
    PlannedRun { name: "the board's own core", is_meant: |_| true, script: whole },
];

/// What a host does in a round.
enum Round {
    /// A request is cut before a byte.
    Cut(usize),
    /// A bit of a byte is wrong.
    WrongBit(usize),
    /// The byte before this one has no stop bit.
    Broken(usize),
    /// A kind that there is not.
    Unknown(u8),
    /// A request with a pause in it.
    Paused,
    /// A request, and another one while it is answered.
    Together,
    /// A request.
    Whole,
}

/// Kinds that differ in a bit from one that there is.
fn unknown_kinds(kind: u8) -> impl Iterator<Item = Round> {
    (0..8).map(move |bit| Round::Unknown(kind ^ 1 << bit))
}

/// How a host's rate is off.
enum Pace {
    Fast,
    Slow,
}

/// Length of the bits of a host whose rate is off by nearly all that the board takes.
fn sent_bit(facts: &Facts, pace: Pace) -> f64 {
    let (shortest, longest) = (facts.host_bits.start(), facts.host_bits.end());
    let margin = (longest - shortest) / 100.0;
    match pace {
        Pace::Fast => shortest + margin,
        Pace::Slow => longest - margin,
    }
}

fn torn_requests(facts: &Facts, seed: u64) -> BoardScript {
    let mut maker = Maker::new(facts, seed);
    maker.script.rates = (sent_bit(facts, Pace::Fast), 1.02);
    let mut rounds: Vec<Round> = (1..REQUEST_BYTES).map(Round::Cut).collect();
    rounds.extend((0..REQUEST_BYTES).map(Round::WrongBit));
    rounds.extend(unknown_kinds(REQUEST_READ));
    ask_in_rounds(&mut maker, rounds);
    match &facts.sums {
        // As many frames as make the sequence number go round.
        None => maker.offer_singly(320),
        Some(sums) => {
            // Sums are seldom: answers bring the sequence number to its top bit.
            for _ in 0..100 {
                let asked = maker.request(REQUEST_READ, 0);
                maker.ask(asked, MOST_RESULTS_OF_A_FRAME);
            }
            offer_sums(&mut maker, sums, 0);
        }
    }
    maker.made()
}

fn broken_requests(facts: &Facts, seed: u64) -> BoardScript {
    let mut maker = Maker::new(facts, seed.wrapping_add(1));
    maker.script.rates = (sent_bit(facts, Pace::Slow), 0.98);
    let mut rounds: Vec<Round> = (1..REQUEST_BYTES).map(Round::Broken).collect();
    rounds.extend(unknown_kinds(REQUEST_WRITE));
    ask_in_rounds(&mut maker, rounds);
    match &facts.sums {
        None => maker.offer_over_script(500),
        // Whole frames wait while the first one is sent; some of the sum before may wait, too.
        Some(sums) => offer_sums(&mut maker, sums, 1 << (facts.fifo_address_bits - 1)),
    }
    maker.made()
}

/// As many sums as there are bits for, two at least if they are short. Of the last one so many results come `at_once`.
fn offer_sums(maker: &mut Maker, sums: &ScanSums, at_once: usize) {
    let bits = maker.facts.bits_of_results(sums.results);
    let least = if bits < 30_000.0 { 2 } else { 1 };
    let count = (maker.script.bits / (1.3 * bits)) as usize;
    let count = count.clamp(least, 8);
    (1..=count).for_each(|sum| maker.offer_sum(sums, if sum == count { at_once } else { 0 }));
}

/// These rounds and some with whole requests, in any order, and the core's flags one after another. Behind each torn
/// request there is one that is answered.
fn ask_in_rounds(maker: &mut Maker, mut rounds: Vec<Round>) {
    const RESULTS: u64 = 8;
    rounds.extend((0..12).map(|number| match number % 3 {
        0 => Round::Paused,
        1 => Round::Together,
        _ => Round::Whole,
    }));
    let (count, mut flags) = (rounds.len(), vec![0, 1, 3, 2, 0].into_iter());
    for number in 0..count {
        if number % (count / 5) == 0
            && let Some(next) = flags.next()
        {
            maker.command(&format!("flags {next}"));
            maker.script.flags.push(next);
        }
        let round = rounds.swap_remove(maker.rng.random_range(0..rounds.len()));
        let asked = maker.any_request();
        let mut bytes = encode::request(asked.0, asked.1);
        let point = match round {
            Round::Cut(byte) => {
                maker.say(&bytes[..byte]);
                format!("a request that is torn before byte {byte}")
            }
            Round::WrongBit(byte) => {
                bytes[byte] ^= 1 << maker.rng.random_range(0..8_u32);
                maker.say(&bytes);
                format!("a request with a wrong bit in byte {byte}")
            }
            Round::Broken(byte) => {
                maker.say(&bytes[..byte]);
                maker.command("low 12");
                maker.pause(3);
                // The rest is of no request, or of another one that is whole.
                if byte % 2 == 0 {
                    maker.say(&bytes[byte..]);
                } else {
                    // What follows the break may look like a byte.
                    maker.pause(12);
                    let whole = maker.any_request();
                    maker.ask(whole, RESULTS);
                }
                format!("a byte without its stop bit before byte {byte}")
            }
            Round::Unknown(kind) => {
                let other = maker.request(kind, 0x104);
                maker.ask(other, RESULTS);
                maker.script.points.push("a request of an unknown kind".to_owned());
                continue;
            }
            Round::Paused => {
                let pause = maker.rng.random_range(1..REQUEST_BYTES);
                maker.say(&bytes[..pause]);
                maker.pause(200);
                maker.say(&bytes[pause..]);
                maker.expect(asked.0, asked.1);
                maker.await_answer(asked.0, RESULTS);
                maker.script.points.push("a pause within a request".to_owned());
                continue;
            }
            Round::Together => {
                maker.say(&bytes);
                maker.expect(asked.0, asked.1);
                // The device does not listen until the answer has been sent, which takes longer.
                let other = maker.any_request();
                maker.say(&encode::request(other.0, other.1));
                maker.await_answer(asked.0, RESULTS);
                maker.script.points.push("a request while one is answered".to_owned());
                continue;
            }
            Round::Whole => {
                maker.ask(asked, RESULTS);
                continue;
            }
        };
        maker.script.points.push(point);
        maker.pause(SILENCE);
        let asked = maker.any_request();
        maker.ask(asked, RESULTS);
    }
}

/// As many results as there is room for, and then no faster than the line; bursts and scans that the line is too slow
/// for, which are lost scan by scan, and told.
fn too_fast(facts: &Facts, seed: u64) -> BoardScript {
    let mut maker = Maker::new(facts, seed);
    let depth = 1_usize << facts.fifo_address_bits;
    let chips = maker.chips_per_result();
    // Until so much of the FIFO has left.
    let drained = |share: f64| (share * chips * depth as f64) as u64;
    let at_once = depth - 48;
    maker.offer(at_once, |rng, number| u64::from(number > 0 && rng.random_range(0..8) == 0));
    let mut due = 0.0_f64;
    // As long as the sensor's own scans.
    let in_time = facts.results_of_scan.clamp(MOST_RESULTS_OF_A_FRAME, MOST_PLACES) as usize;
    maker.offer(in_time, |_, _| {
        let before = due;
        due += chips / 0.97;
        // A result has a clock of its own.
        (due.floor() - before.floor() - 1.0).max(0.0) as u64
    });
    maker.era().may_lose_behind = Some(at_once + in_time);
    // It goes full; scans are taken again from where it is less than half full.
    maker.offer(depth, |_, _| 0);
    for comes in [false, true] {
        maker.script.scans.push((maker.script.offers.len(), comes));
        maker.offer(20, |_, number| if number == 0 { drained(0.33) } else { 0 });
    }
    // And a scan that is cut is lost to its end, however much room there is by then.
    maker.offer(depth + HALF_ROUND + 100, |_, number| match number < depth + HALF_ROUND {
        true => 0,
        false => drained(0.007),
    });
    for number in 0..4 {
        let scan = match number {
            0 => maker.rng.random_range(1..depth / 2 - 16),
            1 => maker.rng.random_range(1..40),
            2 => depth / 2 - 17,
            _ => depth + HALF_ROUND,
        };
        let pause = maker.rng.random_range(0.0..0.4) * scan.min(depth) as f64 / depth as f64;
        let is_burst = scan > depth || maker.rng.random();
        maker.offer(scan, |rng, number| match number {
            0 => drained(pause),
            _ if is_burst => 0,
            _ => rng.random_range(0.0..chips) as u64,
        });
    }
    // Short scans without a pause fill it again as soon as there is room, twice: the second time the first loss is told
    // just before that, as half of the FIFO lies between. They come from a little before that until a little behind it.
    maker.offer(depth + SHORT_SCAN, |_, number| if number == 0 { drained(0.66) } else { 0 });
    for rest in [0.47, 0.43] {
        for scan in 0..(0.06 * chips) as usize * depth / SHORT_SCAN {
            let first = if scan == 0 { drained(rest) } else { 0 };
            maker.offer(SHORT_SCAN, |_, number| if number == 0 { first } else { 0 });
        }
    }
    // A loss is told with the result that comes next: the last scan comes late enough to be taken.
    maker.script.scans.push((maker.script.offers.len(), true));
    maker.offer(20, |_, number| if number == 0 { drained(0.66) } else { 0 });
    // Not before the results that just fit.
    maker.pause((1.1 * facts.bits_of_results(in_time as u64)) as u32);
    ask_seldom(&mut maker);
    maker.made()
}

/// Results of a short scan.
const SHORT_SCAN: usize = 100;

/// Resets while results are lost, before a loss is told and behind that: what comes next is as it would be without
/// a loss, and the number of those that are lost then begins anew.
fn resets_among_losses(facts: &Facts, seed: u64) -> BoardScript {
    const IN_TIME: usize = 20;
    let mut maker = Maker::new(facts, seed);
    let (depth, chips) = (1_usize << facts.fifo_address_bits, maker.chips_per_result());
    let drained = |share: f64| (share * chips * depth as f64) as u64;
    // Bits before a reset, and between it and the next result.
    let rest = (400.0 * facts.chips_per_bit) as u64;
    let reset = |maker: &mut Maker| {
        let waits: u64 = maker.script.offers.iter().map(|offer| offer.wait + 1).sum();
        maker.pause_until(waits as f64 / facts.chips_per_bit + 200.0);
        maker.unlock(20.0);
    };
    let (at_once, then) = (depth + 300, [None, Some(0.0), Some(0.7), Some(0.7)]);
    for (number, told) in then.into_iter().enumerate() {
        maker.offer(IN_TIME, |_, number| if number == 0 { rest } else { chips as u64 });
        maker.era().may_lose_behind = Some(IN_TIME + depth - 48);
        maker.offer(at_once, |_, _| 0);
        if let Some(share) = told {
            maker.offer(IN_TIME, |_, number| if number == 0 { drained(0.55) } else { 0 });
            maker.offer(IN_TIME, |_, number| if number == 0 { drained(share) } else { 0 });
        }
        if number + 1 < then.len() {
            reset(&mut maker);
        }
        if number < 2 {
            maker.script.points.push("a reset before a loss is told".to_owned());
        }
    }
    maker.made()
}

/// Few requests while the line is full: an answer takes as long as twenty results.
fn ask_seldom(maker: &mut Maker) {
    let bits = maker.facts.layout.result_bits() << maker.facts.fifo_address_bits;
    maker.pause((20.0 * bits as f64 / 8.0) as u32);
    for _ in 0..4 {
        let asked = maker.request(REQUEST_IDENTITY, 0);
        maker.ask(asked, MOST_RESULTS_OF_A_FRAME);
    }
}

/// Sums one after another until the FIFO is full, and longer: they are lost, one whole sum after another, and told behind a
/// pause.
fn sums_too_fast(facts: &Facts, seed: u64) -> BoardScript {
    let mut maker = Maker::new(facts, seed);
    let Some(sums) = facts.sums else {
        return maker.made();
    };
    let (depth, results) = (1_usize << facts.fifo_address_bits, sums.results as usize);
    // Until two thirds of the FIFO have left.
    let drained = (0.66 * maker.chips_per_result() * depth as f64) as u64;
    let mut offered = 0;
    let mut offer = |maker: &mut Maker, count: usize, pause: u64| {
        for scan in 0..count * sums.scans as usize {
            let first = if scan == 0 { pause } else { 0 };
            maker.offer(results, |_, number| if number == 0 { first } else { 0 });
        }
        offered += count * results;
        offered
    };
    maker.era().may_lose_behind = Some(depth - 48);
    let full = offer(&mut maker, depth.div_ceil(results) + 1, 0);
    maker.script.scans.push((full, false));
    let mut lost = offer(&mut maker, 1, 0);
    let rounds = if facts.loses_a_round() { 2 } else { 0 };
    for round in 0..=rounds {
        maker.script.scans.push((lost, true));
        offer(&mut maker, 1, drained);
        if round < rounds {
            lost = offer(&mut maker, (HALF_ROUND + depth) / results, 0);
        }
    }
    ask_seldom(&mut maker);
    maker.made()
}

/// A source that waits: nothing is lost, and the line is full.
fn waiting(facts: &Facts, seed: u64) -> BoardScript {
    let mut maker = Maker::new(facts, seed);
    maker.script.keeps_line_full = true;
    let mut offered = 0;
    while offered < (3 << facts.fifo_address_bits) / 2 {
        let scan = maker.rng.random_range(600..1200);
        maker.offer(scan, |_, _| 0);
        offered += scan;
    }
    maker.made()
}

/// Resets in the middle of whatever goes on, behind which everything begins anew.
fn resets(facts: &Facts, seed: u64) -> BoardScript {
    const RESULTS: u64 = 60;
    let mut maker = Maker::new(facts, seed);
    for round in 0..16 {
        // Registers take longer than most of the pauses.
        maker.command("slow 1");
        let kind = [REQUEST_WRITE, REQUEST_READ][round / 4 % 2];
        let asked = match round % 4 {
            0 | 1 => maker.request(kind, 4 * round as u16),
            _ => maker.any_request(),
        };
        match round % 4 {
            3 => maker.say(&encode::request(asked.0, asked.1)[..round / 2]),
            _ => {
                let bytes = maker.cut_request(asked);
                maker.say(&bytes);
                let most = [60, 240, 300][round % 4];
                let behind = maker.rng.random_range(0..most);
                maker.pause(behind);
            }
        }
        let lasts = match round % 4 {
            // A chip or two; and once more, wherever the reset is by then.
            0 => {
                let (lasts, behind) = (1.5 / facts.chips_per_bit, maker.rng.random_range(0.3..2.0));
                maker.unlock(lasts);
                maker.command(&format!("bits {behind}"));
                maker.script.points.push("a reset that the line's clock may miss".to_owned());
                lasts
            }
            _ => f64::from(maker.rng.random_range(1..30)),
        };
        maker.unlock(lasts);
        maker.command("slow 0");
        maker.pause(100 + lasts as u32);
        let asked = maker.any_request();
        maker.ask(asked, RESULTS);
    }
    for _ in 0..4 {
        let asked = maker.any_request();
        maker.ask(asked, RESULTS);
    }
    match &facts.sums {
        None => maker.offer_over_script(400),
        Some(sums) => maker.offer_scans_of_sums(sums),
    }
    maker.made()
}

/// Hits by sample: what is counted between two dark moments, and while a host reads.
fn hits(facts: &Facts, seed: u64) -> BoardScript {
    let mut maker = Maker::new(facts, seed);
    maker.script.host = format!("light 0\n{}", maker.script.host);
    // Steady light has a hit of each sample in every third chip: more of them than 16 bits hold.
    let long = (3.0 * 70_000.0 / facts.chips_per_bit) as u32;
    let steps = [
        (Moment::Before, "light 1", 1500),
        (Moment::BehindLight, "light 2", long),
        (Moment::InLight, "light 0", 100),
        (Moment::BehindIt, "light 0", 0),
    ];
    for (moment, command, bits) in steps {
        for first in (0..facts.places_of_hits()).step_by(HITS_OF_BLOCK) {
            let (request, data) = maker.request(REQUEST_HITS, 4 * first as u16);
            maker.say(&encode::request(request, data));
            maker.era().answers.push(ExpectedAnswer::Hits(request, first, moment));
            maker.await_answer(request, 1);
        }
        maker.command(command);
        maker.pause(bits);
        if command == "light 1" {
            maker.command("light 0");
            maker.pause(100);
        }
    }
    maker.made()
}
