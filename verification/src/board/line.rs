//! Whether what a board sent in a run is what it has to send.

use std::fmt;

use goldtof_wire::{
    ANSWER_BYTES, BLOCK_BYTES, Decoder, Event, Frame, IDENTITY_FRAME_BYTES,
    MOST_RESULTS_OF_A_FRAME, SYNC, encode,
};

use super::BoardRun;
use super::cover::{Cover, LAST_PLACE, LOSS_BEHIND_LOSS, MANY_HITS};
use super::model::{BoardOutcome, Facts};
use super::script::{BoardScript, Era, ExpectedAnswer, HITS_OF_BLOCK, Moment, Offer};

/// A result that has to come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Due {
    /// Its bits on the line.
    bits: u128,
    /// Its place in its scan.
    place: u64,
    last: bool,
}

/// Flags of the core, one state after another, each of which some frame has to show.
struct Flags {
    states: Vec<u8>,
    /// The state of the last frame, and whether one has shown it.
    at: usize,
    is_shown: bool,
    /// The board's own core may saturate.
    may_saturate: bool,
}

impl Flags {
    fn new(script: &BoardScript, has_saturated: bool) -> Flags {
        let shown = |&flags: &u8| if has_saturated { flags } else { flags & 1 };
        let mut states: Vec<u8> = script.flags.iter().map(shown).collect();
        if states.is_empty() {
            states.push(0);
        }
        states.dedup();
        Flags { states, at: 0, is_shown: false, may_saturate: script.is_whole() }
    }

    /// Takes those of a frame; false where they are out of turn.
    fn take(&mut self, seen: u8) -> bool {
        let seen = if self.may_saturate { seen & 1 } else { seen };
        if self.is_shown && self.states.get(self.at + 1) == Some(&seen) {
            self.at += 1;
        }
        let is_right = self.states[self.at] == seen;
        self.is_shown |= is_right;
        is_right
    }

    fn are_told(&self) -> bool {
        self.at + 1 == self.states.len()
    }
}

impl fmt::Display for Flags {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "the core's o_saturated and o_overrun were {:02b}", self.states[self.at])?;
        match self.states.get(self.at + 1) {
            Some(next) => write!(f, ", and then {next:02b}"),
            None => Ok(()),
        }
    }
}

/// Of results that come in order, some of which may be lost.
#[derive(Default)]
struct Results<'a> {
    due: &'a [Due],
    scans: &'a [(usize, bool)],
    /// The next one.
    at: usize,
    /// Behind a loss up to here nothing may be lost anew.
    whole_until: usize,
    /// There was a loss before the next one.
    has_lost: bool,
    /// How many were lost, and the place behind the last loss.
    lost: u64,
    lost_before: usize,
}

impl Facts {
    /// Whether a run was as it has to be, and what was seen in it.
    ///
    /// # Errors
    /// What is wrong.
    pub(super) fn check(
        &self,
        script: &BoardScript,
        outcome: &BoardOutcome,
        cover: &mut Cover,
    ) -> Result<BoardRun, String> {
        if let Some(fault) = &outcome.fault {
            return Err(fault.clone());
        }
        let told_fs = self.identity.chip_period_fs;
        if outcome.chip_fs.abs_diff(told_fs.into()) > 1 {
            return Err(format!(
                "the PLL makes chips of {} fs, and the device tells {told_fs} fs",
                outcome.chip_fs
            ));
        }
        let resets = outcome.lines.len() as u64 - 1;
        if resets + 1 < script.eras.len() as u64 {
            return Err(format!("{resets} resets came, and the PLL lost its lock more often"));
        }
        if outcome.broken > resets {
            return Err(format!("{} bytes of the line have no start or stop bit", outcome.broken));
        }
        let mut told = BoardRun { chips: outcome.chips, ..BoardRun::default() };
        let mut answers = Vec::new();
        for (number, line) in outcome.lines.iter().enumerate() {
            let is_last = number as u64 == resets;
            let from = number.checked_sub(1).map_or(0, |before| outcome.taken[before]);
            let due = self.due(&script.offers[from.min(script.offers.len())..]);
            answers.clear();
            let Some(era) = script.eras.get(number) else {
                return Err("there was no reason for a reset".to_owned());
            };
            self.check_line(
                (script, era),
                line,
                number > 0,
                &due,
                is_last,
                &mut answers,
                &mut told,
                cover,
            )
            .and_then(|flags| {
                self.check_answers(era, (script, outcome), &answers, cover)?;
                // The own core's are nowhere written down.
                if !script.is_whole() {
                    era.check_transfers(&outcome.transfers[number])?;
                }
                // Where requests were not received there may be no frames to tell them.
                if is_last && !flags.are_told() {
                    return Err(format!("flags were not told: {flags}"));
                }
                Ok(())
            })
            .map_err(|fault| match number {
                0 => fault,
                _ => format!("{fault} (behind reset {number})"),
            })?;
            told.answers += answers.len() as u64;
        }
        let waits = self.packing.waits;
        // Until the line's side has been reset, too.
        let most_stalled =
            64.0 * self.chips_per_bit / f64::from(self.clocks_per_bit) * (resets + 1) as f64;
        if !waits && outcome.stalled as f64 > most_stalled.max(64.0) {
            return Err(format!(
                "the core waited {} clocks, and has nowhere to wait",
                outcome.stalled
            ));
        }
        if waits && outcome.stalled as f64 > most_stalled {
            cover.reach("the core waits for the line");
        }
        let share = (told.bytes.saturating_sub(1) * 10) as f64 / outcome.busy_bits.max(1.0);
        if script.keeps_line_full && share < self.least_share() {
            return Err(format!(
                "the line is busy for {:.1} % of the time, and results wait",
                100.0 * share
            ));
        }
        script.points.iter().for_each(|point| cover.reach(point));
        Ok(told)
    }

    /// Share of the time that a full line carries bytes.
    fn least_share(&self) -> f64 {
        let most = MOST_RESULTS_OF_A_FRAME;
        0.985 * 10.0 * self.frame_bytes(most) as f64 / self.bits_of_results(most)
    }

    /// Results that have to come of what the core offers.
    fn due(&self, offers: &[Offer]) -> Vec<Due> {
        let mut due = Vec::with_capacity(offers.len());
        let packed = |offer: &Offer| self.packing.packed(&offer.tdata);
        let Some(sums) = &self.sums else {
            let mut place = 0;
            for offer in offers {
                due.push(Due { bits: packed(offer), place, last: offer.last });
                place = if offer.last { 0 } else { place + 1 };
            }
            return due;
        };
        // Sums by their definition, of scans that are whole.
        let (one, sum) = (self.packing.layout, sums.sum);
        let mut scans: Vec<Vec<(i128, u128)>> = Vec::new();
        for scan in offers.split_inclusive(|offer| offer.last) {
            if scan.len() as u64 != sums.results {
                scans.clear();
                continue;
            }
            let counts = scan.iter().map(packed);
            scans.push(
                counts.map(|bits| (one.count(bits, 0).into(), one.more(bits).into())).collect(),
            );
            if scans.len() as u64 == u64::from(sums.scans) {
                let results = scans[0].len();
                due.extend((0..results).map(|place| {
                    let (signed, total) = scans
                        .iter()
                        .map(|scan| scan[place])
                        .fold((0, 0), |(a, b), (c, d)| (a + c, b + d));
                    let signed = signed as u128 & ((1 << sum.count_bits) - 1);
                    let bits = signed | total.checked_shl(sum.count_bits.into()).unwrap_or(0);
                    Due { bits, place: place as u64, last: place + 1 == results }
                }));
                scans.clear();
            }
        }
        due
    }

    /// The byte with which the first frame behind a reset begins.
    fn first_frame(&self, line: &[u8]) -> usize {
        // What was on the line when the reset came: a byte that it cut, and perhaps one before.
        let begins = |&begin: &usize| {
            let mut decoder = Decoder::new(Some(self.layout));
            decoder.push(&line[begin..]);
            decoder.next_event().is_some() && decoder.tally().stray_bytes == 0
        };
        (0..=line.len().min(2)).find(begins).unwrap_or(0)
    }

    /// Frames of the line from one reset to the next; gives the flags as far as they were told.
    #[expect(clippy::too_many_arguments, reason = "one call")]
    fn check_line(
        &self,
        (script, era): (&BoardScript, &Era),
        line: &[u8],
        is_behind_reset: bool,
        due: &[Due],
        is_last: bool,
        answers: &mut Vec<Frame>,
        told: &mut BoardRun,
        cover: &mut Cover,
    ) -> Result<Flags, String> {
        let begin = if is_behind_reset { self.first_frame(line) } else { 0 };
        let mut decoder = Decoder::new(Some(self.layout));
        decoder.push(&line[begin..]);
        let scans = if is_behind_reset { &[] } else { &script.scans[..] };
        let mut results = Results { due, scans, ..Results::default() };
        let (mut at, mut sequence, mut frames) = (begin, 0_u8, 0);
        let mut flags = Flags::new(script, self.has_saturated);
        // Whether there were results, and an answer behind them.
        let (mut had_results, mut had_answer) = (false, false);
        while let Some(event) = decoder.next_event() {
            let frame = match event {
                Event::Lost(loss) => {
                    if loss.frames > 0 {
                        return Err(format!(
                            "{} frames are missing before frame {sequence}",
                            loss.frames
                        ));
                    }
                    results.lose(loss.dropped, era.may_lose_behind, self, cover)?;
                    continue;
                }
                Event::Frame(frame) => frame,
            };
            let tally = decoder.tally();
            let place = || format!("frame {sequence}, byte {at} of the line");
            if tally.stray_bytes > 0 || tally.torn > 0 || tally.doubled > 0 {
                return Err(format!(
                    "bytes that are no frame, or a frame with a wrong CRC, before {}",
                    place()
                ));
            }
            let raw = &line[at..];
            if raw[2] != sequence {
                return Err(format!("{} has sequence number {}", place(), raw[2]));
            }
            let seen = raw[3] >> 1 & 3;
            if !flags.take(seen) {
                return Err(format!("{} has flags {seen:02b}, and {flags}", place()));
            }
            for (bit, name) in [(1, "o_overrun is told"), (2, "o_saturated is told")] {
                if seen & bit != 0 {
                    cover.reach(name);
                }
            }
            at += match &frame {
                Frame::Results(results_frame) => {
                    let bytes = encode::results(results_frame, sequence, self.layout);
                    if raw[..bytes.len()] != bytes {
                        return Err(format!("bits behind the results of {} are not 0", place()));
                    }
                    results
                        .take(results_frame, script.is_whole(), self, cover)
                        .map_err(|fault| format!("{fault} ({})", place()))?;
                    told.results += results_frame.results.len() as u64;
                    bytes.len()
                }
                Frame::Answer(_) => ANSWER_BYTES,
                Frame::Identity(..) | Frame::Block(..) => IDENTITY_FRAME_BYTES,
            };
            let is_results = matches!(frame, Frame::Results(_));
            if is_results {
                if had_answer {
                    cover.reach("an answer between frames of results");
                }
                (had_results, had_answer) = (true, false);
            } else {
                answers.push(frame);
                had_answer = had_results;
            }
            match frames {
                128 => cover.reach("the sequence number has its top bit"),
                256 => cover.reach("the sequence number goes round"),
                _ => {}
            }
            (frames, sequence) = (frames + 1, sequence.wrapping_add(1));
        }
        told.bytes += line.len() as u64;
        let rest = line.len() - at;
        let is_cut = !is_last || script.is_whole();
        let begins = rest < 3 || line[at] == SYNC && line[at + 2] == sequence;
        if rest > 0 && !(is_cut && begins && rest < self.most_bytes()) {
            return Err(format!("{rest} bytes at the line's end are no frame, nor its beginning"));
        }
        if rest > 2 && !is_last {
            cover.reach("a reset within a frame");
        }
        if results.lost > 0 && !is_last {
            cover.reach("a reset behind a loss that was told");
        }
        if is_last && results.at < due.len() {
            return Err(format!(
                "of {} results that the core sent {} never came",
                due.len(),
                due.len() - results.at
            ));
        }
        Ok(flags)
    }

    /// Bytes of the longest frame.
    fn most_bytes(&self) -> usize {
        self.frame_bytes(MOST_RESULTS_OF_A_FRAME).max(IDENTITY_FRAME_BYTES)
    }

    /// Answers of the host's requests from one reset to the next.
    fn check_answers(
        &self,
        era: &Era,
        (script, outcome): (&BoardScript, &BoardOutcome),
        answers: &[Frame],
        cover: &mut Cover,
    ) -> Result<(), String> {
        let mut before = vec![0; self.places_of_hits()];
        for (number, expected) in era.answers.iter().enumerate() {
            let Some(answer) = answers.get(number) else {
                if era.is_cut && number + 1 == era.answers.len() {
                    break;
                }
                return Err(format!(
                    "request {number}, from a host whose bits take {:.3} of the line's, got no answer, which was to be \
                     {expected:?}",
                    script.rates.0
                ));
            };
            let is_right = match (expected, answer) {
                (ExpectedAnswer::Frame(expected), answer) => expected == answer,
                (ExpectedAnswer::Written(request, status), Frame::Answer(answer)) => {
                    (*request, *status) == (answer.request, answer.status)
                }
                (&ExpectedAnswer::Hits(request, first, moment), Frame::Block(asked, block)) => {
                    self.check_hits(moment, first, block, &mut before, outcome, cover)?;
                    request == *asked
                }
                _ => false,
            };
            if !is_right {
                return Err(format!("answer {number} is {answer:?}, and was to be {expected:?}"));
            }
        }
        match answers.get(era.answers.len()) {
            Some(answer) => Err(format!("{answer:?} was not asked for")),
            None => Ok(()),
        }
    }

    /// A block of hits by sample, and what the counts were before.
    fn check_hits(
        &self,
        moment: Moment,
        first: usize,
        block: &[u8; BLOCK_BYTES],
        before: &mut [u32],
        outcome: &BoardOutcome,
        cover: &mut Cover,
    ) -> Result<(), String> {
        // At the core up to the light at random, up to the steady one, and to the end.
        let [_, random, all] = &outcome.hits[..] else {
            return Err(format!("the light changed {} times", outcome.hits.len()));
        };
        let mut differences = Vec::new();
        for (place, word) in (first..before.len()).zip(block.as_chunks::<4>().0) {
            let word = u32::from_le_bytes(*word);
            let counted = u64::from(word.wrapping_sub(before[place]));
            match moment {
                Moment::Before => before[place] = word,
                Moment::BehindLight if counted != random[place] => {
                    return Err(format!(
                        "{counted} hits of sample {place} are counted, and {} came to the core",
                        random[place]
                    ));
                }
                Moment::BehindLight => {
                    before[place] = word;
                    if counted > 0 {
                        cover.reach(&format!("hits of sample {place} are counted"));
                    }
                }
                Moment::InLight => differences.push(counted),
                Moment::BehindIt => {
                    let came = all[place] - random[place];
                    let left_out = came.checked_sub(counted).ok_or_else(|| {
                        format!("{counted} hits of sample {place} are counted, of {came} that came to the core")
                    })?;
                    // Counting rests for short times alone.
                    if left_out >= 1 << 15 {
                        return Err(format!(
                            "{counted} hits of sample {place} are counted, of {came} that came to the core"
                        ));
                    }
                    if counted >> 16 > 0 {
                        cover.reach(MANY_HITS);
                    }
                    differences.push(left_out);
                }
            }
        }
        let (least, most) = (differences.iter().min(), differences.iter().max());
        // Every sample has a hit in every third chip. Counting has rested with each block that was read in this light.
        let blocks = if moment == Moment::InLight { first + 1 } else { before.len() };
        let rests = blocks.div_ceil(HITS_OF_BLOCK) as u64;
        match (least, most) {
            (Some(&least), Some(&most)) if least == 0 || most - least > rests => Err(format!(
                "of samples with as many hits each {least} to {most} hits are counted, or left out: \
                 while a host reads, counting has to rest, and of all of them"
            )),
            _ => Ok(()),
        }
    }
}

impl Era {
    /// Transfers at the core's registers from one reset to the next.
    fn check_transfers(&self, transfers: &[String]) -> Result<(), String> {
        let least = self.transfers.len().saturating_sub(usize::from(self.is_cut));
        if transfers.len() >= least && self.transfers.starts_with(transfers) {
            return Ok(());
        }
        let differs = |k: &usize| transfers.get(*k) != self.transfers.get(*k);
        let k = (0..).find(differs).unwrap_or_default();
        let shown = |transfers: &[String]| transfers.get(k).cloned().unwrap_or("none".to_owned());
        Err(format!(
            "transfer {k} at the core's registers is {}, and was to be {} (direction, address, data, response)",
            shown(transfers),
            shown(&self.transfers)
        ))
    }
}

impl Results<'_> {
    /// The bridge tells that so many are lost, modulo 2^16.
    fn lose(
        &mut self,
        dropped: u64,
        may_lose_behind: Option<usize>,
        facts: &Facts,
        cover: &mut Cover,
    ) -> Result<(), String> {
        let at = self.at;
        let is_allowed = may_lose_behind.is_some_and(|first| at >= first) && at >= self.whole_until;
        if !is_allowed {
            return Err(format!("results are lost behind result {at}, where the bridge has room"));
        }
        self.at += dropped as usize;
        self.lost += dropped;
        if self.lost >= 1 << 16 {
            cover.reach("the number of lost results goes round");
        }
        if self.due.get(self.at).is_none_or(|due| due.place != 0) {
            return Err(format!(
                "{dropped} results are told to be lost behind result {at}, behind which no scan begins"
            ));
        }
        cover.reach("results are lost");
        if self.lost > dropped && at - self.lost_before < 1 << (facts.fifo_address_bits - 1) {
            cover.reach(LOSS_BEHIND_LOSS);
        }
        self.lost_before = self.at;
        for &(first, comes) in self.scans.iter().filter(|(first, _)| (at..self.at).contains(first))
        {
            if comes {
                return Err(format!(
                    "the scan from result {first} on is lost, which began with the FIFO less than half full"
                ));
            }
            cover.reach("a scan is lost with the FIFO more than half full");
        }
        self.has_lost = true;
        // It began with the FIFO less than half full.
        let room = (1_usize << (facts.fifo_address_bits - 1)) - 16;
        let scan = self.due[self.at..].iter().position(|due| due.last).map_or(0, |last| last + 1);
        if scan <= room {
            self.whole_until = self.at + scan;
            cover.reach("a scan is whole behind a loss");
        }
        Ok(())
    }

    /// A frame of results; those behind the last one that is due may be any if there are more.
    fn take(
        &mut self,
        frame: &goldtof_wire::ResultsFrame,
        are_more: bool,
        facts: &Facts,
        cover: &mut Cover,
    ) -> Result<(), String> {
        if frame.gap != std::mem::take(&mut self.has_lost) {
            return Err("the mark of lost results is not where they are".to_owned());
        }
        for (number, &bits) in frame.results.iter().enumerate() {
            let Some(due) = self.due.get(self.at) else {
                let fault = "results come that the core did not send".to_owned();
                return if are_more { Ok(()) } else { Err(fault) };
            };
            let place = u64::from(frame.index) + number as u64;
            let last = frame.last && number + 1 == frame.results.len();
            let came = Due { bits, place, last };
            if came != (Due { place: due.place & 0xff_ffff, ..*due }) {
                return Err(format!(
                    "result {} is {bits:#x} at place {place}{}, and was to be {:#x} at place {}{}",
                    self.at,
                    if last { " and the last one" } else { "" },
                    due.bits,
                    due.place,
                    if due.last { " and the last one" } else { "" },
                ));
            }
            if let Some(&(first, comes)) = self.scans.iter().find(|(first, _)| *first == self.at) {
                if !comes {
                    return Err(format!(
                        "the scan from result {first} on is taken, which began with the FIFO more than half full"
                    ));
                }
                cover.reach("a scan is taken with the FIFO less than half full");
            }
            self.at += 1;
            if place > 255 {
                cover.reach("places beyond 8 bits");
            }
            if place + 1 >= facts.results_of_scan {
                cover.reach(LAST_PLACE);
            }
        }
        match frame.results.len() {
            1 => cover.reach("a frame of one result"),
            255 => cover.reach("a frame of 255 results"),
            _ => {}
        }
        let is_end = if frame.last { "a frame that ends a scan" } else { "a frame within a scan" };
        cover.reach(is_end);
        if self.at as u64 - self.lost > 1 << facts.fifo_address_bits {
            cover.reach("the FIFO's places go round");
        }
        if are_more {
            cover.reach("results of the board's own core");
        }
        Ok(())
    }
}
