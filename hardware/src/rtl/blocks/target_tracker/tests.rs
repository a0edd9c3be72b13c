use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rust_hdl_core::simulate::simulate;

use super::*;
use crate::reference::tracking::{Follower, WindowSums};
use crate::rtl::front::tick;
use crate::sensor::track::TrackSetting;

const SETTINGS: usize = 5;
const WORD_BITS: usize = 16;
const SCAN_WORD_BITS: usize = 14;
const PEAK_STEP_BITS: usize = 9;

struct Bench {
    block: TargetTracker,
    lost: bool,
}

impl Bench {
    fn clock(&mut self) {
        assert!(simulate(&mut self.block, 50), "it settles");
        tick(&mut self.block, false);
        assert!(simulate(&mut self.block, 50), "it settles");
        self.lost |= self.block.o_lost.val();
    }

    /// Clocks until the next scan may begin, after one with `signal` high.
    fn clocks_to_go(&mut self) -> u32 {
        (0..200)
            .find(|_| {
                let goes = self.block.o_go.val();
                self.clock();
                goes
            })
            .expect("it goes on")
    }

    /// Settings pass by, of which the sequencer gets these.
    fn pass(&mut self, words: [u64; SETTINGS]) -> Vec<u64> {
        self.block.i_taken_first.next = true;
        self.clock();
        self.block.i_taken_first.next = false;
        let mut passed = Vec::new();
        for word in words {
            self.block.i_word.next = Word::new(word.into(), WORD_BITS as u32);
            assert!(simulate(&mut self.block, 50), "it settles");
            passed.push(self.block.o_word.val().value() as u64);
            self.clock();
        }
        passed
    }
}

/// Scans and windows with counts of all kinds, and settings of all kinds: the settings that reach the sequencer, position
/// and flags are those of the rule in whole numbers, after the clocks of the plan.
#[test]
fn the_block_follows_the_rule() {
    for (sample_bits, chips) in [(0, 31), (1, 31), (3, 31), (3, 20)] {
        let setting =
            TrackSetting { is_on: true, gain_halvings: 0, threshold_halvings: 0, patience: 0 };
        let period_steps = chips << sample_bits;
        let step_bits = 5 + sample_bits;
        let plan = TrackPlan { sample_bits, step_bits, period_steps, count_bits: 7, setting };
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(u64::from(sample_bits) + chips);
        let mut bench = Bench {
            block: TargetTracker::new(plan, SETTINGS, WORD_BITS, SCAN_WORD_BITS, PEAK_STEP_BITS),
            lost: false,
        };
        tick(&mut bench.block, true);
        bench.block.i_go.next = true;
        let mut follower = Follower::new(plan, setting);
        let (mut windows, mut losses) = (0, 0);
        for _ in 0..400 {
            let word: u32 = rng.random_range(0..1 << TrackSetting::BITS) | 1;
            let first = rng.random_range(0..period_steps);
            let window = follower.window();
            let passed = bench.pass([77, 5, first, 13, word.into()]);
            let expected = match window {
                Some(window) => [77, plan.window_steps(), window, 13, word.into()],
                None => [77, 5, first, 13, word.into()],
            };
            assert_eq!(passed, expected);
            follower.setting = TrackSetting::of_word(word);
            assert!(!bench.block.o_go.val(), "what follows is waited for");
            bench.block.i_run.next = true;
            bench.clock();
            bench.block.i_run.next = false;
            bench.lost = false;
            let was = bench.block.o_position.val().value() as u64;
            if window.is_some() {
                windows += 1;
                let mean = rng.random_range(-10..40);
                let slope = rng.random_range(-30..30);
                let mut counts = Vec::new();
                for step in 0..plan.window_steps() {
                    let late = step >= plan.window_steps() / 2;
                    let count = mean + if late { slope } else { -slope };
                    let count: i64 = (count + rng.random_range(-3..3)).clamp(-64, 63);
                    counts.push(count);
                    bench.block.i_count.next = Word::new(count as u128, 7);
                    bench.block.i_counted.next = true;
                    bench.block.i_last.next = step + 1 == plan.window_steps();
                    bench.clock();
                    bench.block.i_counted.next = false;
                    bench.block.i_last.next = false;
                    if step + 1 < plan.window_steps() {
                        bench.clock();
                    }
                }
                let is_lost = follower.counted(WindowSums::of(&counts, plan.half_steps()));
                losses += u64::from(is_lost);
                assert_eq!(bench.clocks_to_go(), plan.decision_clocks(), "{plan:?}");
                assert_eq!(bench.lost, is_lost, "{counts:?}");
            } else {
                let (step, count): (u64, i64) = (
                    rng.random_range(0..1 << PEAK_STEP_BITS).min(2 * period_steps - 1),
                    rng.random_range(-8..63),
                );
                bench.block.i_peak_step.next = Word::new(step.into(), PEAK_STEP_BITS as u32);
                bench.block.i_peak_count.next = Word::new(count as u128, 7);
                bench.block.i_peak_valid.next = true;
                bench.clock();
                bench.block.i_peak_valid.next = false;
                follower.found((first + step) % period_steps, count);
                assert_eq!(bench.clocks_to_go(), 16);
                assert!(!bench.lost);
            }
            let position = follower.position().unwrap_or(was);
            assert_eq!(bench.block.o_position.val().value() as u64, position, "{plan:?}");
            assert_eq!(bench.block.o_locked.val(), follower.is_locked());
        }
        assert!(windows > 100 && losses > 10, "{windows} windows, {losses} losses");
    }
}
