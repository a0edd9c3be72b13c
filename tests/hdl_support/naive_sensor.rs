//! The sensor from its definition, clock by clock, without pipelines: what
//! the ports have to show.

use goldtof::model::contract::Contract;

/// Inputs at one rising clock edge.
#[derive(Debug, Clone, Copy)]
pub struct Inputs {
    pub reset: bool,
    pub ready: bool,
    pub samples: u32,
}

/// Outputs after one rising clock edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Outputs {
    pub laser: u64,
    pub epoch: bool,
    pub data: u64,
    pub valid: bool,
    pub last: bool,
    pub overrun: bool,
    pub saturated: bool,
}

/// A count and the edge, counted from the first after reset, at which the
/// stream takes it over.
struct Result {
    edge: u64,
    count: i64,
    is_last: bool,
    saturates: bool,
}

/// Outputs for `inputs`; the first input has to be a reset.
pub fn outputs(contract: &Contract, inputs: &[Inputs]) -> Vec<Outputs> {
    let mut out = Vec::new();
    let mut rest = inputs;
    while !rest.is_empty() {
        let in_reset = rest.iter().take_while(|i| i.reset).count();
        out.extend(std::iter::repeat_n(Outputs::default(), in_reset));
        rest = &rest[in_reset..];
        let running = rest.iter().take_while(|i| !i.reset).count();
        out.extend(run(contract, &rest[..running]));
        rest = &rest[running..];
    }
    out
}

/// From the first edge without reset on.
fn run(contract: &Contract, inputs: &[Inputs]) -> Vec<Outputs> {
    let results = results(contract, inputs);
    let mut shown = Outputs::default();
    let mut next = results.iter().peekable();
    inputs
        .iter()
        .zip(0u64..)
        .map(|(input, n)| {
            shown.laser = 0;
            for (m, code) in contract.source_codes.iter().enumerate() {
                let chip = code.chips[(n % code.len()) as usize];
                shown.laser |= u64::from(chip) << m;
            }
            shown.epoch = n % contract.reference_codes[0].len() == 0;
            let blocked = shown.valid && !input.ready;
            shown.valid = blocked;
            if let Some(result) = next.next_if(|r| r.edge == n) {
                if blocked {
                    shown.overrun = true;
                } else {
                    let mask = u64::MAX >> (64 - contract.tdata_bits);
                    shown.data = result.count as u64 & mask;
                    shown.last = result.is_last;
                }
                shown.valid = true;
                shown.saturated |= result.saturates;
            }
            shown
        })
        .collect()
}

fn results(contract: &Contract, inputs: &[Inputs]) -> Vec<Result> {
    let period = contract.reference_codes[0].len();
    let (dwell, steps) = (contract.scan.integration_chips, contract.scan.steps);
    let mut found = Vec::new();
    let mut start = 0;
    loop {
        for j in 0..steps {
            let first = start + j * dwell;
            // The word of cycle n comes at edge n + 1.
            let edge = first + dwell + u64::from(contract.result_latency_clocks);
            if edge >= inputs.len() as u64 {
                return found;
            }
            let exact = (first..first + dwell)
                .map(|n| signed_hits(contract, inputs, n, contract.scan.step(j)))
                .sum::<i64>();
            let half = 1i64 << (contract.count_bits - 1);
            let count = exact.clamp(-half, half - 1);
            found.push(Result {
                edge,
                count,
                is_last: j + 1 == steps,
                saturates: count != exact,
            });
        }
        start += steps * dwell;
        if !contract.scan.is_full() {
            start = start.div_ceil(period) * period;
        }
    }
}

/// Hits of the word of cycle `n` with the sign of the reference delayed by
/// `k` samples.
fn signed_hits(contract: &Contract, inputs: &[Inputs], n: u64, k: u64) -> i64 {
    let code = &contract.reference_codes[0];
    let lanes = i128::from(contract.lanes);
    let level = |lane: i128| {
        // Sample `lane` of cycle n; lane -1 is the last of the word before.
        let edge = (n + 1) as usize - usize::from(lane < 0);
        inputs[edge].samples >> lane.rem_euclid(lanes) & 1 == 1
    };
    (0..lanes)
        .filter(|&l| level(l) && !level(l - 1))
        .map(|l| {
            let chip = (i128::from(n) * lanes + l - i128::from(k)).div_euclid(lanes);
            let chip = code.chips[chip.rem_euclid(i128::from(code.len())) as usize];
            if chip == 1 { 1 } else { -1 }
        })
        .sum()
}
