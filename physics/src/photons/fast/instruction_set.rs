//! A loop, compiled for the vector instructions of the processor.

use super::record::GroupRunner;
use super::steps::StepRunner;

/// What runs to the end of what it has to do, in a loop that is inlined into a caller for each instruction set.
pub trait Runner {
    /// Runs: `#[inline(always)]`, with all that it calls.
    fn run(&mut self);
}

impl Runner for StepRunner<'_, '_> {
    #[inline(always)]
    fn run(&mut self) {
        StepRunner::run(self);
    }
}

impl Runner for GroupRunner<'_> {
    #[inline(always)]
    fn run(&mut self) {
        GroupRunner::run(self);
    }
}

/// Vector instructions that loops are compiled for. No number depends on which of them is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InstructionSet {
    /// What every processor of the architecture has (x86-64: SSE2).
    Baseline,
    /// Eight words at a time.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// Sixteen words at a time.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl InstructionSet {
    /// Those that this processor has, the best one last.
    pub fn available() -> Vec<InstructionSet> {
        let mut sets = vec![InstructionSet::Baseline];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") {
                sets.push(InstructionSet::Avx2);
            }
            if is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("avx512bw")
            {
                sets.push(InstructionSet::Avx512);
            }
        }
        sets
    }

    /// The best one that this processor has.
    pub fn best() -> InstructionSet {
        *InstructionSet::available().last().unwrap_or(&InstructionSet::Baseline)
    }

    /// Whether this processor has it.
    pub fn is_available(self) -> bool {
        InstructionSet::available().contains(&self)
    }

    /// Runs all jobs of a runner.
    ///
    /// # Panics
    /// If the processor does not have it.
    pub fn run(self, runner: &mut impl Runner) {
        assert!(self.is_available(), "this processor has no {self:?}");
        match self {
            InstructionSet::Baseline => runner.run(),
            // SAFETY: the processor has the instructions, as just made sure.
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => unsafe { run_avx2(runner) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => unsafe { run_avx512(runner) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_avx2(runner: &mut impl Runner) {
    runner.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
fn run_avx512(runner: &mut impl Runner) {
    runner.run();
}
