//! A scene's tables, put together and checked against each other.

use super::declare::*;
use super::names::TableNames;
use super::reader::MAX_TABLES;
use super::{Architecture, Detector, Path, Scene, SceneReference, Source};
use super::{array, detector, estimator, hardware, movement, scan, source};
use crate::code::MAX_CODE_CHIPS;
use crate::scan::Clock;

/// Most chips of all codes of a scene together.
pub(super) const MAX_SCENE_CHIPS: u64 = 2 * MAX_CODE_CHIPS;

/// The scene in a document, if nothing is wrong in it; the section is told of what is.
pub(super) fn read_scene(root: &Section, reference: SceneReference) -> Option<Scene> {
    check_tables(root);
    let clock = root.table("clock").and_then(read_clock);
    let source_sections = root.sections("source", MAX_TABLES);
    let detector_sections = root.sections("detector", MAX_TABLES);
    let path_sections = root.sections("path", MAX_TABLES);
    let source_names = TableNames::read("source", &source_sections);
    let detector_names = TableNames::read("detector", &detector_sections);
    check_not_empty(root, "source", &source_sections);
    check_not_empty(root, "detector", &detector_sections);
    let sources = read_sources(source_sections, clock);
    let paths: Option<Vec<Path>> = all(path_sections, |section| {
        source::read_path(section, &source_names, &detector_names, clock)
    });
    let references: Vec<Option<usize>> = detector_sections
        .iter()
        .map(|section| source_names.resolve(section, "reference"))
        .collect();
    check_reference_clocks(&detector_sections, &references, sources.as_deref());
    let code_chips = shared_code_length(&detector_sections, &references, sources.as_deref());
    let steps_per_period =
        code_chips.zip(clock).map(|(chips, clock)| chips * u64::from(clock.samples_per_chip));
    let detectors = read_detectors(detector_sections, references, sources.as_deref(), clock);
    let array = array::read(root, &source_names, sources.as_deref(), detectors.as_deref());
    let scan = root.table("scan");
    let scan = scan.and_then(|section| scan::read(section, clock, steps_per_period));
    let estimate = estimator::read(root);
    let hardware = hardware::read(
        root,
        scan.as_ref(),
        estimate.map(|(estimator, _)| estimator),
        detectors.as_ref().map_or(2, Vec::len),
    )?;
    // Code periods, or scans, are added up: all of them count alike.
    let adds_up = hardware.architecture == Architecture::Histogram || hardware.accumulate > 1;
    let scan = match code_chips.filter(|_| adds_up) {
        Some(chips) => scan.map(|scan| scan.in_whole_periods(chips)),
        None => scan,
    };
    let (estimator, other_light) = estimate?;

    let clock = clock?;
    let scene = Scene {
        name: reference.name,
        origin: reference.origin,
        chip_period_ps: clock.chip_period_ps,
        samples_per_chip: clock.samples_per_chip,
        sources: sources?,
        detectors: detectors?,
        paths: paths?,
        scan: scan?,
        estimator,
        other_light,
        hardware,
        array: None,
    };
    let scene = scene.with_array(array?);
    movement::check_distances(&root.sections("path", usize::MAX), &scene);
    scan::check_sums(root, &scene);
    hardware::check_taps(&root.section_or_defaults("hardware"), &scene);
    hardware::check_tracking(&root.section_or_defaults("hardware"), &scene);
    detector::check_cell_outputs(&root.sections("detector", usize::MAX), &scene);
    detector::check_crosstalk(&root.sections("detector", usize::MAX), &scene);
    Some(scene)
}

/// Reports every table that a scene needs and this one has not.
fn check_tables(root: &Section) {
    for (key, header) in [
        ("clock", "[clock]"),
        ("source", "[[source]]"),
        ("detector", "[[detector]]"),
        ("scan", "[scan]"),
    ] {
        if root.get(key).is_none() {
            root.complain(&format!("the table {header} is missing; a scene needs it"));
        }
    }
}

/// Reports a list of tables that is there and has none.
fn check_not_empty(root: &Section, key: &'static str, sections: &[Section]) {
    if sections.is_empty() && root.get(key).is_some() {
        root.report(key, &format!("a scene needs at least one {key}"));
    }
}

/// Reads the detectors; `references` are the numbers of their own sources, as far as they
/// are known.
fn read_detectors(
    sections: Vec<Section>,
    references: Vec<Option<usize>>,
    sources: Option<&[Source]>,
    clock: Option<Clock>,
) -> Option<Vec<Detector>> {
    let mut references = references.into_iter();
    all(sections, |section| {
        let reference = references.next().flatten();
        let source = sources.zip(reference).map(|(sources, index)| &sources[index]);
        let wavelength_nm = source.map(|source| source.wavelength_nm);
        detector::read(section, reference, clock, wavelength_nm)
    })
}

/// Reads the sources, as long as their codes fit into memory together.
fn read_sources(sections: Vec<Section>, clock: Option<Clock>) -> Option<Vec<Source>> {
    let mut sources = Vec::new();
    let mut chips = 0;
    for section in sections {
        let complaint = section.complaint();
        let source = source::read(section, clock);
        chips += source.as_ref().map_or(0, |source| source.code.len());
        if chips > MAX_SCENE_CHIPS {
            complaint(&format!(
                "with this source the scene's codes have {chips} chips in all, more than \
                 {MAX_SCENE_CHIPS}; use fewer sources, smaller degrees or interleaving depths"
            ));
            return None;
        }
        sources.push(source);
    }
    sources.into_iter().collect()
}

/// Reads every section, so that every error is reported; `None` if one fails.
fn all<'r, 't, T>(
    sections: Vec<Section<'r, 't>>,
    mut read: impl FnMut(Section<'r, 't>) -> Option<T>,
) -> Option<Vec<T>> {
    let values: Vec<Option<T>> = sections.into_iter().map(&mut read).collect();
    values.into_iter().collect()
}

/// A detector's reference is made by its own clock.
fn check_reference_clocks(
    sections: &[Section],
    references: &[Option<usize>],
    sources: Option<&[Source]>,
) {
    for (section, reference) in sections.iter().zip(references) {
        let source = sources.zip(*reference).map(|(sources, index)| &sources[index]);
        if let Some(source) = source.filter(|source| !source.clock.is_shared()) {
            let message = format!(
                "source \"{}\" has a clock of its own, and a detector's sign follows a source of its \
                 own sensor; leave out `clock_offset` and `clock_drift` of that source, or name \
                 another",
                source.name
            );
            section.report("reference", &message);
        }
    }
}

/// Chips per period of the detectors' reference codes. Detectors are stepped
/// together, so all of them must have the first one's length.
fn shared_code_length(
    sections: &[Section],
    references: &[Option<usize>],
    sources: Option<&[Source]>,
) -> Option<u64> {
    let chips = |reference: &Option<usize>| Some(sources?[(*reference)?].code.len());
    let first = references.first().and_then(chips);
    for (section, reference) in sections.iter().zip(references) {
        if let (Some(first), Some(chips)) = (first, chips(reference))
            && chips != first
        {
            section.report(
                "reference",
                &format!(
                    "this detector's reference code is {chips} chips long, the first detector's \
                     {first}; detectors are stepped together, so give them codes of one length"
                ),
            );
        }
    }
    first
}

tables! {
    CLOCK = "clock" {
        chip_period = quantity(Time, "1 ps", "10 ms"), Needed, "8 ns";
            "chip period T_c; one clock of the hardware"
            "1 THz is beyond any hardware, and a delay of 10 s still counts in chips to \
             0.002; slower than 100 Hz nothing is sampled";
        samples_per_chip = integer(1, 64), Or("8"), "8";
            "samples, and phase steps, per chip S; a power of two"
            "a clock's samples of a detector are one word of 64 bits";
    }
}

fn read_clock(section: Section) -> Option<Clock> {
    let chip_period_ps = section.quantity("chip_period");
    let samples: Option<u32> = section.count("samples_per_chip");
    if let Some(samples) = samples.filter(|samples| !samples.is_power_of_two()) {
        let below = samples.next_power_of_two() / 2;
        let message = format!("{samples} is not a power of two; use {below} or {}", 2 * below);
        section.report("samples_per_chip", &message);
    }
    section.finish();
    Some(Clock {
        chip_period_ps: chip_period_ps?,
        samples_per_chip: samples.filter(|samples| samples.is_power_of_two())?,
    })
}
