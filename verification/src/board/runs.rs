//! What is done to a board: results at every rate, requests whole and torn, resets, light.

use goldtof_wire::{
    BLOCK_BYTES, REQUEST_BYTES, REQUEST_HITS, REQUEST_IDENTITY, REQUEST_READ, REQUEST_WRITE, encode,
};
use rand::RngExt as _;

use super::maker::{Maker, SILENCE};
use super::model::Facts;
use super::own_core::whole;
use super::script::{Expected, Moment, Script};
use crate::cosim::error::CosimError;
use crate::sensor::Sensor;

/// A run of the board.
pub(super) struct Run {
    pub name: &'static str,
    /// Whether it says anything of the board.
    pub is_meant: fn(&Facts) -> bool,
    pub script: fn(&Sensor, &Facts, u64) -> Result<Script, CosimError>,
}

/// All of them, those of the board's own core last.
pub(super) const RUNS: [Run; 8] = [
    Run {
        name: "requests, whole and torn, of a host that sends 2 % faster and reads slower",
        is_meant: |_| true,
        script: |_, facts, seed| Ok(requests(facts, seed, (0.98, 1.02), &[0, 1])),
    },
    Run {
        name: "requests, whole and broken, of a host that sends 2 % slower and reads faster",
        is_meant: |_| true,
        script: |_, facts, seed| Ok(requests(facts, seed.wrapping_add(1), (1.02, 0.98), &[2])),
    },
    Run {
        name: "results at 94 % of the line's rate",
        is_meant: |facts| facts.sums.is_none(),
        script: |_, facts, seed| Ok(sustained(facts, seed)),
    },
    Run {
        name: "results faster than the line",
        is_meant: Facts::loses,
        script: |_, facts, seed| Ok(too_fast(facts, seed)),
    },
    Run {
        name: "results of a core that waits for the line",
        is_meant: |facts| facts.packing.waits,
        script: |_, facts, seed| Ok(waiting(facts, seed)),
    },
    Run {
        name: "resets by the PLL's lock",
        is_meant: |_| true,
        script: |_, facts, seed| Ok(resets(facts, seed)),
    },
    Run {
        name: "hits by sample",
        is_meant: |facts| facts.identity.counts_samples,
        script: |_, facts, seed| Ok(hits(facts, seed)),
    },
    Run { name: "the board's own core", is_meant: |_| true, script: whole },
];

/// Requests of every kind, whole and torn in these ways (0: cut, 1: a wrong bit, 2: a byte without its stop bit), each of
/// the torn ones before one that is answered; results between them, and the core's flags.
fn requests(facts: &Facts, seed: u64, rates: (f64, f64), ways: &[usize]) -> Script {
    let mut maker = Maker::new(facts, seed);
    maker.script.rates = rates;
    let mut torn: Vec<(usize, usize)> = Vec::new();
    for &way in ways {
        torn.extend((usize::from(way != 1)..REQUEST_BYTES).map(|byte| (way, byte)));
    }
    // And whole ones among them.
    torn.extend([(3, 0); 30]);
    // Kinds a bit away from those of registers.
    torn.extend((0..16).map(|bit| (4, bit)));
    let (count, mut flags) = (torn.len(), vec![0, 1, 3, 2, 0].into_iter());
    for number in 0..count {
        if number % (count / 5) == 0
            && let Some(next) = flags.next()
        {
            maker.command(&format!("flags {next}"));
            maker.script.flags.push(next);
        }
        let (way, byte) = torn.swap_remove(maker.rng.random_range(0..torn.len()));
        let asked = maker.any_request();
        let mut bytes = encode::request(asked.0, asked.1);
        match way {
            0 => {
                maker.say(&bytes[..byte]);
                maker.script.points.push(format!("a request that is torn before byte {byte}"));
            }
            1 => {
                bytes[byte] ^= 1 << maker.rng.random_range(0..8_u32);
                maker.say(&bytes);
                maker.script.points.push(format!("a request with a wrong bit in byte {byte}"));
            }
            2 => {
                maker.say(&bytes[..byte]);
                maker.command("low 12");
                maker.pause(3);
                // The rest is of no request, or of another one that is whole.
                match byte % 2 {
                    0 => maker.say(&bytes[byte..]),
                    // What follows the break may look like a byte.
                    _ => {
                        maker.pause(12);
                        let whole = maker.any_request();
                        maker.ask(whole);
                        maker.pause_for_answer(8);
                    }
                }
                maker.script.points.push(format!("a byte without its stop bit before byte {byte}"));
            }
            4 => {
                let kind = [REQUEST_READ, REQUEST_WRITE][byte / 8] ^ 1 << (byte % 8);
                let other = maker.request(kind, 0x104);
                maker.ask(other);
                maker.script.points.push("a request of an unknown kind".to_owned());
            }
            _ => match maker.rng.random_range(0..5) {
                2 => {
                    maker.ask(asked);
                    // The device does not listen until the answer has been sent, which takes longer.
                    let other = maker.any_request();
                    maker.say(&encode::request(other.0, other.1));
                    maker.script.points.push("a request while one is answered".to_owned());
                }
                0 => {
                    let pause = maker.rng.random_range(1..REQUEST_BYTES);
                    maker.say(&bytes[..pause]);
                    maker.pause(200);
                    maker.say(&bytes[pause..]);
                    maker.expect(asked.0, asked.1);
                    maker.script.points.push("a pause within a request".to_owned());
                }
                _ => maker.ask(asked),
            },
        }
        if way < 3 {
            maker.pause(SILENCE);
            let asked = maker.any_request();
            maker.ask(asked);
        }
        maker.pause_for_answer(8);
    }
    maker.offer_over_script(500);
    maker.made()
}

/// Results that come evenly, a little less fast than the line takes them, and requests among them.
fn sustained(facts: &Facts, seed: u64) -> Script {
    let mut maker = Maker::new(facts, seed);
    let spacing = maker.chips_per_result() / 0.94;
    let mut sent = 0.0_f64;
    let results = 2500;
    let mut offered = 0;
    while offered < results {
        let scan = maker.rng.random_range(1000..2000);
        maker.offer(scan, |_, _| {
            let before = sent;
            sent += spacing;
            // A result has a clock of its own.
            (sent.floor() - before.floor() - 1.0).max(0.0) as u64
        });
        offered += scan;
    }
    // Few requests: an answer takes as long as twenty results.
    for _ in 0..3 {
        let asked = maker.any_request();
        maker.ask(asked);
        maker.pause_for_answer(300);
        maker.pause(4000);
    }
    maker.made()
}

/// Bursts and scans that the line is too slow for: lost scan by scan, and told.
fn too_fast(facts: &Facts, seed: u64) -> Script {
    let mut maker = Maker::new(facts, seed);
    let depth = 1_usize << facts.fifo_address_bits;
    let chips = maker.chips_per_result();
    // As many as there is room for, at once; and time for them.
    let first = depth - 32;
    maker.offer(first, |rng, number| u64::from(number > 0 && rng.random_range(0..8) == 0));
    maker.script.may_lose_behind = Some(first);
    // It goes full; scans are taken again from where it is less than half full.
    maker.pause((20.0 * depth as f64 * facts.layout.result_bits() as f64 / 8.0) as u32);
    maker.offer(depth, |_, _| 0);
    for (drained, comes) in [(0.3, false), (0.3, true)] {
        maker.script.scans.push((maker.script.offers.len(), comes));
        let wait = drained * chips * depth as f64;
        maker.offer(20, |_, number| if number == 0 { wait as u64 } else { 0 });
    }
    // And a scan that is cut is lost to its end, however much room there is by then.
    maker.offer(depth + 100, |_, number| {
        if number < depth { 0 } else { (0.008 * chips * depth as f64) as u64 }
    });
    for number in 0..12 {
        let scan = match number % 4 {
            0 => maker.rng.random_range(1..depth / 2 - 16),
            1 => maker.rng.random_range(1..40),
            2 => maker.rng.random_range(depth / 4..2 * depth),
            // Two of them are more than the number of lost results has bits.
            _ if number % 8 == 3 => 40_000 + depth,
            _ => depth / 2 - 17,
        };
        let pause = maker.rng.random_range(0.0..0.9) * chips * scan.min(2 * depth) as f64;
        // Those that go the number round would take as many chips as all else.
        let is_burst = scan > 2 * depth || maker.rng.random_range(0..3) > 0;
        maker.offer(scan, |rng, number| match number {
            0 => pause as u64,
            _ if is_burst => 0,
            _ => rng.random_range(0.0..chips) as u64,
        });
        let asked = maker.request(REQUEST_IDENTITY, 0);
        maker.ask(asked);
        maker.pause_for_answer(255);
    }
    // A loss is told with the result that comes next: the last scan comes late, and leaves time.
    let late = 1.5 * chips * depth as f64;
    maker.offer(20, |_, number| if number == 0 { late as u64 } else { 0 });
    maker.made()
}

/// A source that waits: nothing is lost, and the line is full.
fn waiting(facts: &Facts, seed: u64) -> Script {
    let mut maker = Maker::new(facts, seed);
    maker.script.keeps_line_full = true;
    let mut offered = 0;
    while offered < 3 << facts.fifo_address_bits {
        let scan = maker.rng.random_range(1500..3000);
        maker.offer(scan, |_, _| 0);
        offered += scan;
    }
    maker.made()
}

/// Resets in the middle of whatever goes on, behind which everything begins anew.
fn resets(facts: &Facts, seed: u64) -> Script {
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
        maker.ask(asked);
        maker.pause_for_answer(60);
    }
    for _ in 0..4 {
        let asked = maker.any_request();
        maker.ask(asked);
        maker.pause_for_answer(60);
    }
    maker.offer_over_script(400);
    // A sum behind the last reset, which has cut the scan before: no faster than the line, but for some results that
    // follow one another without a pause.
    let most = 2 * maker.chips_per_result() as u64;
    for _ in 0..facts.sums.map_or(0, |sums| sums.scans + 1) {
        let scan = maker.scan(1);
        maker.offer(
            scan,
            |rng, number| if number % 64 < 8 { 0 } else { rng.random_range(0..=most) },
        );
    }
    maker.made()
}

/// Hits by sample: what is counted between two dark moments, and while a host reads.
fn hits(facts: &Facts, seed: u64) -> Script {
    let mut maker = Maker::new(facts, seed);
    maker.script.host = format!("light 0\n{}", maker.script.host);
    let words = facts.places_of_hits();
    let steps = [
        (Moment::Before, words, "light 1", 1500),
        (Moment::BehindLight, words, "light 2", 100),
        (Moment::InLight, 1, "light 0", 100),
        (Moment::BehindIt, 1, "light 0", 0),
    ];
    for (moment, words, command, bits) in steps {
        for first in (0..words).step_by(BLOCK_BYTES / 4) {
            let (request, data) = maker.request(REQUEST_HITS, 4 * first as u16);
            maker.say(&encode::request(request, data));
            maker.era().answers.push(Expected::Hits(request, first, moment));
            maker.pause_for_answer(1);
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
