//! Sums of scans: `result_accumulator` before a bridge, against sums that are made here of what goes in.

use std::fs;

use super::{
    BRIDGE, Bridge, Event, Frame, Layout, Model, Noise, Offer, Outcome, Path, Summed, run, sources,
};

/// Bridges behind an accumulator: a count alone, and with a total of bits that are no whole bytes; the fewest
/// results, a number of scans that is no power of two, results that follow one another without a pause.
fn summing() -> Vec<(Bridge, u64)> {
    let bridge = Bridge {
        top: "summing_bridge",
        layout: Layout { count_bits: 17 + 2, counts: 1, more_bits: 0 },
        sums: Some(Summed { scans: 4, scans_bits: 2, results: 31, results_bits: 5 }),
        ..BRIDGE
    };
    let with_totals = Bridge {
        memory: "ecp5",
        tdata_bits: 40,
        layout: Layout { count_bits: 18 + 3, counts: 1, more_bits: 13 + 3 },
        more_first_bit: 24,
        clk_ps: 40_000,
        uart_clk_ps: 10_006,
        clocks_per_bit: 33,
        sums: Some(Summed { scans: 5, scans_bits: 3, results: 4, results_bits: 2 }),
        ..bridge
    };
    let many = Bridge {
        layout: Layout { count_bits: 17 + 8, counts: 1, more_bits: 0 },
        sums: Some(Summed { scans: 255, scans_bits: 8, results: 16, results_bits: 4 }),
        ..bridge
    };
    vec![(bridge, 2), (bridge, 700), (with_totals, 0), (many, 0)]
}

/// What the host has to get: the sums by their definition, of whole scans from `first` on, packed.
fn sums(bridge: &Bridge, offers: &[Offer], first: usize) -> Vec<(u64, u128)> {
    let summed = bridge.sums.expect("there are sums");
    let Layout { count_bits, more_bits, .. } = bridge.layout;
    let one = Bridge { layout: summed.of_one(bridge.layout), ..*bridge };
    let results = summed.results as usize;
    let frames = offers[first..].chunks_exact(results * summed.scans as usize);
    frames
        .flat_map(|frame| {
            (0..results).map(move |place| {
                let of_place = frame.iter().skip(place).step_by(results);
                let counts = of_place.map(|offer| one.packed(offer.tdata));
                let count = |packed: u128| i128::from(one.layout.count(packed, 0));
                let (sum, total) = counts.fold((0, 0), |(sum, total), packed| {
                    (sum + count(packed), total + u128::from(one.layout.more(packed)))
                });
                let signed = sum as u128 & ((1 << count_bits) - 1);
                assert!(total < 1 << more_bits, "{total}");
                (place as u64, signed | total << count_bits)
            })
        })
        .collect()
}

fn came(outcome: &Outcome, layout: Layout) -> Vec<(u64, u128)> {
    let (events, tally) = outcome.events(layout);
    assert_eq!((tally.torn, tally.stray_bytes, tally.dropped, tally.lost_frames), (0, 0, 0, 0));
    let lasts = events.iter().filter_map(|event| match event {
        Event::Frame(Frame::Results(frame)) => Some((frame.last, frame.index, frame.results.len())),
        _ => None,
    });
    // A frame that begins with place 0 follows one that ends a scan, and the other way round.
    let mut ended = true;
    for (last, index, _) in lasts {
        assert_eq!(index == 0, ended);
        ended = last;
    }
    super::results(&events)
}

/// Results of one scan, offered to the model.
fn offers(bridge: &Bridge, scans: u64, wait: u64, noise: &mut Noise) -> Vec<Offer> {
    let summed = bridge.sums.expect("there are sums");
    let results = summed.results as usize;
    let mut offers = bridge.offers(results * scans as usize, results, wait, noise);
    // All ones and the least count, over whole sums: nothing of them may be cut off.
    let (ones, least) = (u128::MAX >> (128 - bridge.tdata_bits), {
        let one = summed.of_one(bridge.layout);
        1 << (one.count_bits - 1)
    });
    for (k, offer) in offers.iter_mut().enumerate() {
        match k % results {
            0 => offer.tdata = ones,
            1 => offer.tdata = least,
            _ => {}
        }
    }
    offers
}

/// Whether the host gets the sums, with and without a scan that a reset cut.
fn sums_come_through(model: &Model, wait: u64, seed: u64) -> bool {
    let bridge = model.bridge;
    let summed = bridge.sums.expect("there are sums");
    let mut noise = Noise(seed);
    let scans = u64::from(summed.scans) * 3 + 1;
    let whole = offers(&bridge, scans, wait, &mut noise);
    // The first scan lacks its first results, as one whose beginning fell into a reset.
    let lacking = 1 + noise.below(u64::from(summed.results) - 1) as usize;
    let cut = &whole[lacking..];
    let first = summed.results as usize - lacking;
    [(&whole[..], 0), (cut, first)].into_iter().all(|(offers, first)| {
        let outcome = model.run(offers, "", (1.0, 1.0), seed as u32);
        came(&outcome, bridge.layout) == sums(&bridge, offers, first)
    })
}

#[test]
fn a_host_reads_sums_of_whole_scans() {
    for (number, (bridge, wait)) in summing().into_iter().enumerate() {
        let model = bridge.build();
        assert!(sums_come_through(&model, wait, number as u64 + 3), "bridge {number}");
    }
}

/// Faults in the accumulator, each of which the bench finds.
#[test]
fn faults_of_the_accumulator_are_found() {
    let faults = [
        // A sum that keeps what was there before, or one scan too few or too many.
        ("& {SIGNED_BITS{!word_first_r}}", ""),
        ("scan_r == {SCANS_BITS{1'b0}};", "scan_r <= 1;"),
        ("LAST_SCAN   = SCANS - 1", "LAST_SCAN   = SCANS - 2"),
        // A sign that is lost.
        ("{SCANS_BITS{word_data_r[COUNT_BITS-1]}}", "{SCANS_BITS{1'b0}}"),
        // A scan that was cut counts.
        ("is_last_scan || !is_last_place ?", "is_last_scan ?"),
        // A word too late or too early.
        ("(sum_place_r)", "(word_place_r)"),
        (".i_address       (place_r)", ".i_address       (read_place_r)"),
        // Places that go on.
        ("last_r ? {RESULTS_BITS{1'b0}} :", ""),
        ("sum_last_r   <= word_last_r;", "sum_last_r   <= read_last_r;"),
        ("read_leaves_r <= valid_r && is_last_scan;", "read_leaves_r <= is_last_scan;"),
    ];
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../hdl/bridge");
    let text = fs::read_to_string(folder.join("result_accumulator.v")).expect("it is there");
    let (bridge, wait) = summing()[0];
    for (from, to) in faults {
        assert_eq!(text.matches(from).count(), 1, "{from}");
        let faulty = text.replace(from, to);
        let model = bridge.build_with(Some(&faulty));
        let found = std::panic::catch_unwind(|| !sums_come_through(&model, wait, 3));
        assert!(found.unwrap_or(true), "{from} -> {to} was not found");
    }
}

#[test]
fn the_accumulator_is_clean_under_three_tools_and_refuses_parameters_by_name() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let list = |memory: &str| -> Vec<String> {
        let accumulator = "../hdl/bridge/result_accumulator.v";
        let accumulator = Path::new(env!("CARGO_MANIFEST_DIR")).join(accumulator);
        let all = sources(memory).into_iter();
        all.filter(|name| name.ends_with("bridge_memory.v"))
            .chain([accumulator.display().to_string()])
            .collect()
    };
    let files = list("inferred");
    let lint = |tool: &str, arguments: &[&str]| {
        let files = files.iter().map(String::as_str);
        run(folder.path(), tool, &arguments.iter().copied().chain(files).collect::<Vec<_>>())
    };
    let top = "result_accumulator";
    assert_eq!(lint("verilator", &["--lint-only", "-Wall", "--top-module", top]), "");
    assert_eq!(lint("iverilog", &["-Wall", "-g2005", "-s", top, "-o", "lint.vvp"]), "");
    let read = format!(
        "read_verilog {}; hierarchy -check -top {top}; proc; check -assert; select -assert-none t:$dlatch",
        files.join(" ")
    );
    assert_eq!(run(folder.path(), "yosys", &["-q", "-p", &read]), "");
    for (parameter, what) in [
        ("COUNT_BITS=25", "counts_and_MORE_BITS_within_TDATA_BITS"),
        ("SUM_BITS=18", "SUM_BITS_of_the_fields_with_SCANS_BITS_more_each"),
        ("SCANS=1", "SCANS_of_2_to_65536_and_their_bits"),
        ("SCANS=3", "SCANS_of_2_to_65536_and_their_bits"),
        ("RESULTS=3", "RESULTS_of_4_to_16384_and_their_bits"),
        ("RESULTS=17", "RESULTS_of_4_to_16384_and_their_bits"),
    ] {
        let set = format!("-P{top}.{parameter}");
        let arguments = ["-g2005", "-s", top, &set, "-o", "stop.vvp"];
        let output = std::process::Command::new("iverilog")
            .args(arguments)
            .args(&files)
            .current_dir(folder.path())
            .output()
            .expect("it starts");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let named = said.contains(&format!("result_accumulator_needs_{what}"));
        assert!(!output.status.success() && named, "{parameter}: {said}");
    }
}
