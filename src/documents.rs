//! The names of the JSON documents of the jobs and their studies: those of their schemas.

/// Names documents.
macro_rules! documents {
    ($($body:ty = $name:literal;)*) => {$(
        impl $crate::document::Body for $body { const NAME: &'static str = $name; }
    )*};
}
#[cfg(feature = "cli")]
pub(crate) use documents;

documents! {
    crate::image::ImageReport = "image";
    crate::plan::overview::Overview = "plan";
    crate::replay::ReplayReport = "replay";
    crate::run::Run = "run";
    crate::shard::Shard = "shard";
    crate::simulate::pulses::PulsesReport = "pulses";
    crate::simulate::repeat::Simulation = "simulate";
    crate::simulate::track::TrackReport = "track";
    crate::study::architectures::ArchitectureComparison = "compare-architectures";
    crate::study::fidelity::FidelityReport = "fidelity";
    crate::study::limits::Limits = "explain";
    crate::study::reproduce::Reproduction = "reproduce";
    crate::study::stress::StressReport = "stress";
    crate::study::sweep::SweepOptions = "sweep-definition";
}
