//! Single edits to emitted Verilog, scene by scene, that co-simulation has to find.

/// One edit: file, what stands there (once), what is put in its place.
pub type Fault = (&'static str, &'static str, &'static str);

/// Those that are planted: of each module some, or, where it is asked for, all.
pub fn planted(faults: &[Fault]) -> Vec<Fault> {
    optics_support::some_of_each(faults, |fault| fault.0).into_iter().copied().collect()
}

/// Faults in the Verilog of scenes/quick.toml.
pub const QUICK: &[Fault] = &[
    // Results: a scan's last in time, or behind another scan's, or of a second loss in one stall.
    ("result_stream.v", "o_last <= i_last;", "o_last <= i_last & ~o_valid;"),
    (
        "result_stream.v",
        "blocked = o_valid & ~i_ready",
        "blocked = o_valid & (~i_ready | (i_counted & i_last))",
    ),
    ("result_stream.v", "load = i_counted & ~blocked", "load = i_counted & (~blocked | o_overrun)"),
    // Codes: taps, seeds, the XOR, the epoch.
    ("gold_generator.v", "U_TAPS = 5'h09", "U_TAPS = 5'h11"),
    ("gold_generator.v", "V_TAPS = 5'h0f", "V_TAPS = 5'h09"),
    ("gold_generator.v", "V_LOAD = 5'h1f", "V_LOAD = 5'h1e"),
    ("gold_generator.v", "u_r[0] ^ v_r[0]", "u_r[0] | v_r[0]"),
    ("gold_generator.v", "u_r[0] ^ v_r[0]", "u_r[0] ^ v_r[1]"),
    ("gold_generator.v", "o_epoch <= u_r == U_LAST", "o_epoch <= v_r == 5'd1"),
    ("gold_generator.v", "if (i_advance)", "if (1'b1)"),
    // Scan: one chip or one step more or fewer, a lost strobe.
    ("scan_controller.v", "CHIP_COUNT_END   = 12'h7ee", "CHIP_COUNT_END   = 12'hff7"),
    ("scan_controller.v", "CHIP_COUNT_TAPS  = 12'h941", "CHIP_COUNT_TAPS  = 12'h841"),
    ("scan_controller.v", "CHIP_COUNT_FIRST = 12'hfff", "CHIP_COUNT_FIRST = 12'h7ff"),
    ("scan_controller.v", "STEP_COUNT_END   = 8'h42", "STEP_COUNT_END   = 8'h84"),
    ("scan_controller.v", "STEP_COUNT_FIRST = 8'hff", "STEP_COUNT_FIRST = 8'h7f"),
    ("scan_controller.v", "} <= 0;", "} <= 0; o_run <= 1'b1;"),
    ("scan_controller.v", "o_pre_last_chip & last_step_r", "o_pre_last_chip"),
    ("scan_controller.v", "o_dump = step_done_r[4]", "o_dump = step_done_r[3]"),
    ("scan_controller.v", "o_counted = step_done_r[5]", "o_counted = step_done_r[4]"),
    ("scan_controller.v", "o_scan_counted = scan_done_r[5]", "o_scan_counted = scan_done_r[4]"),
    // Phase: lanes, the held chip.
    ("lane_delay.v", "i_pre_last_chip & delayed_r[6]", "i_pre_last_chip & delayed_r[5]"),
    ("chip_history.v", "o_advance = ~i_wrap", "o_advance = 1'b1"),
    ("chip_history.v", "o_chips <= {o_chips[0], i_chip}", "o_chips <= {i_chip, i_chip}"),
    ("lane_delay.v", "{delayed_r[5:0], 1'b1}", "{delayed_r[5:0], 1'b0}"),
    // Edges: a lost lane, a wrong edge at a word border, the other edge.
    ("edge_detector.v", "last_sample_r <= i_samples[7]", "last_sample_r <= i_samples[6]"),
    ("edge_detector.v", "i_samples[6:0], last_sample_r", "i_samples[6:0], 1'b0"),
    ("edge_detector.v", "& {8{i_run}}", "& {1'b0, {7{i_run}}}"),
    ("edge_detector.v", "i_samples & ~{i_samples[6:0]", "~i_samples & {i_samples[6:0]"),
    ("edge_detector.v", "rising[2*g] | rising[2*g + 1]", "rising[2*g]"),
    ("edge_detector.v", "= i_samples[2*g]", "= i_samples[2*g + 1]"),
    // Counting: a sign, a pair, a width one short, a missed dump.
    ("updown_correlator.v", "i_hits & ~((i_early", "i_hits & ((i_early"),
    ("updown_correlator.v", "= i_reference[2*g + 1]", "= i_reference[2*g]"),
    ("quad_counter.v", "{&i_hit, two_hits", "{1'b0, two_hits"),
    ("quad_counter.v", "{downs_r, 1'b0}", "{1'b0, downs_r}"),
    ("accumulator.v", "{{11{i_addend[3]}}, i_addend}", "{{12{i_addend[2]}}, i_addend[2:0]}"),
    ("accumulator.v", "base_r <= total_r;", "base_r <= base_r;"),
    // Results: the handshake, the flag, the sign's extension.
    ("result_stream.v", "blocked = o_valid & ~i_ready", "blocked = o_valid"),
    ("result_stream.v", "i_counted | blocked;", "i_counted;"),
    ("result_stream.v", "o_overrun <= 1'b1", "o_overrun <= 1'b0"),
    ("result_stream.v", "{count_r[14], count_r}", "{1'b0, count_r}"),
    // What waits is overwritten, or a loss is not told.
    (
        "result_stream.v",
        "o_valid <= i_counted | blocked;",
        "if (i_counted) o_last <= i_last; o_valid <= i_counted | blocked;",
    ),
    (
        "result_stream.v",
        "o_valid <= i_counted | blocked;",
        "if (i_counted) count_r <= i_count; o_valid <= i_counted | blocked;",
    ),
    ("result_stream.v", "if (i_counted & blocked)", "if (i_counted & blocked & ~i_last)"),
    ("result_stream.v", "if (i_counted & blocked)", "if (i_counted & blocked & ~o_last)"),
    // A second scan is as long as its counter happens to be.
    (
        "scan_controller.v",
        "if (scan_last_chip_r) begin\n                step_count_r <= STEP_COUNT_FIRST;\n            end else if",
        "if",
    ),
    // A reset of one clock leaves something in the pipelines.
    ("edge_detector.v", "} <= 0;", "} <= 0; o_hits <= pairs;"),
    ("quad_counter.v", "} <= 0;", "} <= 0; hits_r <= {&i_hit, two_hits, ^i_hit};"),
    ("quad_counter.v", "} <= 0;", "} <= 0; o_sum <= {1'b0, hits_r} - {downs_r, 1'b0};"),
    ("accumulator.v", "} <= 0;", "} <= 0; base_r <= total_r;"),
    ("scan_controller.v", "} <= 0;", "} <= 0; step_done_r <= {step_done_r[4:0], o_last_chip};"),
    // The top: the laser's timing.
    ("sensor_top.v", "o_laser <= transmit_chip", "o_laser <= ~transmit_chip"),
];

/// Faults in what only tests/scenes/window.toml has.
pub const WINDOW: &[Fault] = &[
    ("interleaver.v", "generator_chip ^ subchip_r", "generator_chip"),
    ("interleaver.v", "i_advance & subchip_r", "i_advance & ~subchip_r"),
    ("scan_controller.v", "i_epoch & may_start_r", "may_start_r"),
    ("scan_controller.v", "STEP_COUNT_END   = 5'h01", "STEP_COUNT_END   = 5'h02"),
    ("lane_delay.v", "DELAYED_LOAD = 3'h3", "DELAYED_LOAD = 3'h1"),
    ("count_clamp.v", "{4{~i_count[9]}}", "{{3{~i_count[9]}}, 1'b0}"),
    ("result_stream.v", "i_counted & i_clamped", "i_counted & ~i_clamped"),
    ("result_stream.v", "i_counted & i_clamped", "i_counted & i_clamped & ~i_last"),
];

/// Faults that show only where a scan ends just before an epoch, as in
/// tests/scenes/window-in-step.toml.
pub const WINDOW_IN_STEP: &[Fault] =
    &[("scan_controller.v", "(o_pre_last_chip & last_step_r) | ~(o_start", "~(o_start")];

/// Faults in the peak detector of tests/scenes/peak.toml.
pub const PEAK: &[Fault] = &[
    // Comparing: the sign, a piece that does not decide, equal counts.
    (
        "count_comparison.v",
        "unsigned_count = {i_other[10], i_count[9:0]}",
        "unsigned_count = i_count",
    ),
    ("count_piece.v", "i_other, 1'b0} - {1'b0, i_count,", "i_count, 1'b0} - {1'b0, i_other,"),
    ("count_piece.v", "i_count, i_below}", "i_count, 1'b0}"),
    ("count_piece.v", "i_count, i_below}", "i_count, 1'b1}"),
    // Keeping: a scan's first count, a step, another count.
    ("running_maximum.v", "i_first | comparison_greater", "comparison_greater"),
    ("running_maximum.v", "best_step_r <= i_step", "best_step_r <= best_step_r"),
    ("running_maximum.v", "o_count <= largest_r", "o_count <= present"),
    // Turns: the wrong count, one too many, one too few.
    ("count_choice.v", "(i_count[32:22] &", "(i_count[21:11] &"),
    ("peak_detector.v", "& ~group_ends_r", "& 1'b1"),
    ("peak_detector.v", "last_group_r ? turn_r[1]", "last_group_r ? turn_r[2]"),
    ("peak_detector.v", "i_counted | next_turn}", "i_counted}"),
    // Scans: their ends, the step behind the code period's last.
    ("peak_detector.v", "last_turn & last_group_r", "last_group_r"),
    ("peak_detector.v", "first_r <= ends_r", "first_r <= 1'b0"),
    ("peak_detector.v", "step_r == ONE_BEFORE_TOP", "step_r == FIRST_STEP"),
    ("peak_detector.v", "o_valid <= done_r", "o_valid <= ends_r"),
    // A maximum below zero; a reset of one clock in the middle of a comparison.
    ("running_maximum.v", "largest_r <= present;", "largest_r <= present[10] ? 11'd0 : present;"),
    ("peak_detector.v", "first_r <= 1'b1;", "first_r <= first_r;"),
    (
        "peak_detector.v",
        "} <= 0;",
        "} <= 0; compares_r <= {compares_r[2:0], i_counted | next_turn};",
    ),
    ("peak_detector.v", "} <= 0;", "} <= 0; done_r <= ends_r;"),
];

/// Faults in the Verilog of tests/scenes/totals.toml: total counts of two detectors.
pub const TOTALS: &[Fault] = &[
    // A lost pair, a sign where there is none, a total that does not clamp or flag.
    ("hit_counter.v", ".i_hit (hit_r)", ".i_hit ({1'b0, hit_r[2:0]})"),
    ("hit_counter.v", ".i_down (4'd0)", ".i_down ({3'd0, hit_r[0]})"),
    ("hit_counter.v", "exact[6:0] | {7{o_clamped}}", "exact[6:0]"),
    ("hit_counter.v", "o_clamped = {1'b0, exact[6:0]} != exact", "o_clamped = 1'b0"),
    ("detector_channel.v", "clamp_clamped[0] | total_clamped", "clamp_clamped[0]"),
    // The stream: whose total, when it is taken over, where it stands.
    ("result_stream.v", "total_r <= i_total[6:0];", "total_r <= i_total[13:7];"),
    ("result_stream.v", "waiting_total_r <= i_total[13:7];", "waiting_total_r <= i_total[6:0];"),
    ("result_stream.v", "if (next_detector)", "if (detector_r[0])"),
    ("result_stream.v", "detector_r[2:1] <= {2{1'b1}};", "detector_r[2:1] <= 2'd2;"),
    ("result_stream.v", "{1'b0, total_r, signed_count}", "{total_r[6], total_r, signed_count}"),
    // The flag: without one of the counts, and with one that a last group has not.
    ("result_stream.v", "(|i_clamped)", "(|{i_clamped[5:3], i_clamped[1:0]})"),
    ("result_stream.v", "{i_clamped[4:3], i_clamped[1:0]}", "{i_clamped[4:2], i_clamped[0]}"),
    (
        "result_stream.v",
        "detector_r <= {1'b1, detector_r[4:1]};",
        "detector_r <= {1'b1, detector_r[4:1]}; waiting_total_r <= i_total[13:7];",
    ),
];

/// Faults in the Verilog of tests/scenes/registers.toml: what a host does, and scans as it sets them.
pub const REGISTERS: &[Fault] = &[
    // Settings: a word taken from another's place, bits that are lost, what fits.
    ("scan_sequencer.v", "chips_r <= i_word;", "chips_r <= i_word ^ 8'd1;"),
    ("scan_sequencer.v", "if (take_r[2])", "if (take_r[3])"),
    ("scan_sequencer.v", "is_within, |groups_r,", "is_within, 1'b1,"),
    ("scan_sequencer.v", "|groups_r, |chips_r[7:4]", "|groups_r, 1'b1"),
    ("scan_sequencer.v", "is_within = ~(&delay_r)", "is_within = 1'b1"),
    ("scan_sequencer.v", "samples > 2'd1", "samples > 2'd2"),
    // A scan's beginning: the reference is let go too early, or begins a code period too soon.
    ("scan_sequencer.v", "CHIP_COUNT_SECOND = 8'd5", "CHIP_COUNT_SECOND = 8'd6"),
    ("scan_sequencer.v", "i_laser_epoch & prepared_r[1]", "i_laser_epoch & prepared_r[0]"),
    ("scan_sequencer.v", "if (prepared_r[0] & delay_match_matched)", "if (delay_match_matched)"),
    ("scan_sequencer.v", "i_epoch & ~o_run", "i_laser_epoch & ~o_run"),
    ("scan_sequencer.v", "(i_epoch | indexed_r)", "1'b1"),
    // Its end: codes that go on, or do not; a step too many.
    ("scan_sequencer.v", "o_on <= i_go & ~i_changed", "o_on <= i_go"),
    ("scan_sequencer.v", "o_on <= i_go & ~i_changed", "o_on <= ~i_changed"),
    ("scan_sequencer.v", "goes_on = i_go & ~i_changed & is_whole_r", "goes_on = i_go & is_whole_r"),
    ("scan_sequencer.v", "goes_on = i_go & ~i_changed & is_whole_r", "goes_on = 1'b0"),
    ("scan_sequencer.v", "step_count_r <= 6'd1", "step_count_r <= 6'd0"),
    // What only some values, or some moments, show.
    ("scan_sequencer.v", "is_within = ~(&delay_r)", "is_within = ~delay_r[4]"),
    (
        "scan_sequencer.v",
        "o_seed[4:0] <= i_word[4:0]",
        "o_seed[4:0] <= i_word[4:0] | {4'd0, ~(|i_word[4:0])}",
    ),
    (
        "register_file.v",
        "to_state_r & ~s_axil_awaddr[2]) begin",
        "to_state_r & ~s_axil_awaddr[2] & ~i_takes) begin",
    ),
    (
        "register_file.v",
        "<= s_axil_wdata[1:0]",
        "<= {s_axil_wdata[1] & ~(i_busy & ~s_axil_wdata[0]), s_axil_wdata[0]}",
    ),
    ("register_file.v", "s_axil_wdata[5:3]", "{1'b1, s_axil_wdata[4:3]}"),
    // The largest values.
    ("scan_sequencer.v", "chips_r <= i_word", "chips_r <= i_word - {7'd0, &i_word}"),
    (
        "scan_sequencer.v",
        "groups_r <= i_word[5:0]",
        "groups_r <= i_word[5:0] - {5'd0, &i_word[5:0]}",
    ),
    // A host's write in the very clock of what the hardware does.
    (
        "register_file.v",
        "<= s_axil_wdata[1:0]",
        "<= {s_axil_wdata[1] & ~i_taken_first, s_axil_wdata[0]}",
    ),
    (
        "register_file.v",
        "{i_refused, i_clamps, i_lost}",
        "{i_refused, i_clamps & ~cleared[1], i_lost}",
    ),
    (
        "register_file.v",
        "{i_refused, i_clamps, i_lost}",
        "{i_refused & ~cleared[2], i_clamps, i_lost}",
    ),
    // The sign of a second detector's peak, of one count alone.
    (
        "register_file.v",
        "{{26{i_peak_count[11]}}, i_peak_count[11:6]}",
        "{{26{i_peak_count[11] & ~(&i_peak_count[11:6])}}, i_peak_count[11:6]}",
    ),
    // The slave: addresses, bytes, errors, who comes first.
    ("register_file.v", "SETTABLE = 16'h7c0", "SETTABLE = 16'h7e0"),
    ("register_file.v", "SETTABLE = 16'h7c0", "SETTABLE = 16'h3c0"),
    ("register_file.v", "&s_axil_wstrb", "|s_axil_wstrb"),
    ("register_file.v", "to_setting_r | to_state_r", "to_setting_r"),
    ("register_file.v", "read_error_r <= ~of_register_r", "read_error_r <= ~of_word_r"),
    // A word that changes while it waits for the host.
    (
        "register_file.v",
        "s_axil_arready <= read_r & ~i_takes;",
        "s_axil_arready <= read_r & ~i_takes; if (s_axil_rvalid & ~s_axil_rready & (s_axil_rdata[31:16] + 16'd1 == \
         scans_r)) s_axil_rdata <= state;",
    ),
    ("register_file.v", "s_axil_arready <= read_r & ~i_takes", "s_axil_arready <= read_r"),
    ("register_file.v", "& ~s_axil_awready & ~s_axil_bvalid", "& ~s_axil_awready"),
    ("register_file.v", "s_axil_rdata <= state;", "s_axil_rdata <= word_r;"),
    // What is told, and cleared.
    ("register_file.v", "runs_r <= 1'b1", "runs_r <= 1'b0"),
    ("register_file.v", "<= s_axil_wdata[1:0]", "<= {2{s_axil_wdata[0]}}"),
    ("register_file.v", "s_axil_wdata[5:3]", "{s_axil_wdata[5:4], s_axil_wdata[4]}"),
    ("register_file.v", "lost_r <= lost_r + 8'd1", "lost_r <= lost_r + 8'd2"),
    ("register_file.v", "scans_r <= scans_r + 16'd1", "scans_r <= scans_r"),
    ("register_file.v", "scans_r <= scans_r + 16'd1", "scans_r <= (scans_r + 16'd1) & 16'h07ff"),
    // The memory is kept in reset, and by the address of the write.
    ("register_memory.v", "i_write & ~i_rst", "1'b0"),
    ("register_memory.v", "words[i_write_address] <= i_data", "words[i_address] <= i_data"),
    ("register_memory.v", "words[k] = INITIAL[32*k +: 32]", "words[k] = INITIAL[31:0]"),
    // Seeds and delays on their way to the references.
    ("gold_generator.v", "v_r <= i_seed", "v_r <= V_LOAD"),
    ("lane_delay.v", "delayed_r <= i_delayed", "delayed_r <= 3'd0"),
    ("sensor_top.v", "transmit_epoch[0] & sequencer_on", "transmit_epoch[0]"),
];

/// Faults in the Verilog of tests/scenes/taps.toml: taps that a host sets.
pub const TAPS: &[Fault] = &[
    ("gold_generator.v", "taps = i_seed[9:5]", "taps = 5'h0f"),
    ("gold_generator.v", "first_chips = i_seed[4:0]", "first_chips = i_seed[9:5]"),
    ("m_sequence_generator.v", "taps = i_seed[9:5]", "taps = U_TAPS"),
    ("m_sequence_generator.v", "o_chip = v_r[0]", "o_chip = u_r[0]"),
    ("m_sequence_generator.v", "last_r <= u_r == U_LAST", "last_r <= 1'b0"),
    ("interleaver.v", ".i_seed (i_seed)", ".i_seed ({i_seed[9:5], 5'h13})"),
    // A sequence of another period goes on behind the code's.
    ("gold_generator.v", "last_r <= u_r == U_LAST", "last_r <= 1'b0"),
    ("gold_generator.v", "o_epoch <= last_r", "o_epoch <= u_r == U_LAST"),
    ("scan_sequencer.v", "o_seed[9:0] <= i_word", "o_seed[9:0] <= {5'h0f, i_word[4:0]}"),
];

/// Faults in the Verilog of tests/scenes/tracking-short.toml: a window that follows a target.
pub const TRACKING: &[Fault] = &[
    // Settings: a window that has the host's, that goes on for ever, or takes a number from another's place.
    ("target_tracker.v", "window_r <= follows_r;", "window_r <= 1'b0;"),
    ("target_tracker.v", "& {2{window_r}}", "& {window_r, 1'b1}"),
    ("target_tracker.v", "own_r <= passes_r[1:0]", "own_r <= {passes_r[2], passes_r[0]}"),
    ("target_tracker.v", "o_go = i_go & ~waits_r", "o_go = i_go"),
    ("target_tracker.v", "waits_r <= i_word[0] | window_r", "waits_r <= i_word[0]"),
    ("target_tracker.v", "<= i_word[10:0]", "<= {i_word[10:4], i_word[4:2], i_word[0]}"),
    // The largest patience; a host's write in the very clock in which a target is lost.
    ("target_tracker.v", "missed_r >= patience_r", "missed_r >= patience_r - {3'd0, &patience_r}"),
    (
        "register_file.v",
        "{i_target_lost, i_refused, i_lost}",
        "{i_target_lost & ~(writes & to_state_r & s_axil_awaddr[2]), i_refused, i_lost}",
    ),
    // Ends of numbers that windows need not show.
    (
        "target_tracker.v",
        "<= i_word[10:0]",
        "<= {i_word[10:7], i_word[6:4] - {2'd0, &i_word[6:4]}, i_word[3:0]}",
    ),
    (
        "target_tracker.v",
        "<= i_word[10:0]",
        "<= {i_word[10:4], i_word[3:1] - {2'd0, &i_word[3:1]}, i_word[0]}",
    ),
    ("target_tracker.v", "<= i_word[10:0]", "<= {i_word[10:7], i_word[5:3], i_word[3:0]}"),
    ("target_tracker.v", "<= i_word[10:0]", "<= {1'b0, i_word[9:0]}"),
    ("target_tracker.v", "if (i_refused) waits_r <= 1'b0", "if (i_refused) waits_r <= waits_r"),
    // Sums: which half, what is left of the window before, signs.
    ("target_tracker.v", "early = ~place_r[2]", "early = ~place_r[1]"),
    ("target_tracker.v", "{place_r, all_r, slope_r} <= 0", "{place_r, all_r} <= 0"),
    ("target_tracker.v", "turned = {{3{i_count[9]}}, i_count}", "turned = {3'd0, i_count}"),
    ("target_tracker.v", "{turned, early}", "{turned, 1'b0}"),
    ("target_tracker.v", "all_r + {{3{i_count[9]}}, i_count}", "all_r + {3'd0, i_count}"),
    // Which peak, and which counts, are a scan's that looks for a target.
    ("target_tracker.v", "began_r <= i_run | (began_r & ~i_taken_first)", "began_r <= 1'b1"),
    ("target_tracker.v", "waits_r & ~window_r", "waits_r"),
    ("target_tracker.v", "i_last & window_r};", "i_last};"),
    // Light: shares, what is expected, windows in a row.
    ("target_tracker.v", "least_r <= {1'b0, least_r[12:1]}", "least_r <= least_r"),
    ("target_tracker.v", "{total_r[24], total_r[24:1]}", "{1'b0, total_r[24:1]}"),
    ("target_tracker.v", "(|all_r) & ~spare[13]", "~spare[13]"),
    ("target_tracker.v", "(|all_r) & ~spare[13]", "(|all_r)"),
    ("target_tracker.v", "gained_r <= spare[13:4]", "gained_r <= 10'd0"),
    ("target_tracker.v", "{{3{gained_r[9]}}, gained_r}", "{3'd0, gained_r}"),
    ("target_tracker.v", "(missed_r + 4'd1) & {4{~lit_r}}", "lit_r ? missed_r : missed_r + 4'd1"),
    ("target_tracker.v", "(missed_r + 4'd1) & {4{~lit_r}}", "missed_r & {4{~lit_r}}"),
    ("target_tracker.v", "(|i_peak_count) & ~i_peak_count[9]", "~i_peak_count[9]"),
    ("target_tracker.v", "(|i_peak_count) & ~i_peak_count[9]", "(|i_peak_count)"),
    ("target_tracker.v", "{1'b0, i_peak_count, 2'd0}", "{2'd0, i_peak_count, 1'd0}"),
    // The quotient: signs, the most, its bits.
    ("target_tracker.v", "{15{minus | stage_r[0]}}", "{15{minus}}"),
    ("target_tracker.v", "minus & ~stage_r[0]}", "1'b0}"),
    ("target_tracker.v", "& {15{~begins_r}}", "& {15{~stage_r[0]}}"),
    ("target_tracker.v", "quotient_r[9] ? {9{1'b1}} : quotient_r[8:0]", "quotient_r[8:0]"),
    ("target_tracker.v", "negative_r <= slope_r[12]", "negative_r <= 1'b0"),
    ("target_tracker.v", "{quotient_r[8:0], minus}", "{quotient_r[8:0], 1'b0}"),
    // The way: the window's middle, what leaves the fraction, the ends of the code period.
    ("target_tracker.v", "{8'd0, ahead_r, 15'd0} - HALF_STEP", "{8'd0, ahead_r, 15'd0}"),
    ("target_tracker.v", "~{10'd0, fraction_r}", "~25'd0"),
    ("target_tracker.v", "carry_r <= (stage_r[13] & negative_r)", "carry_r <= 1'b0"),
    ("target_tracker.v", "negative_r) | stage_r[15]", "negative_r)"),
    ("target_tracker.v", "stage_r[27] | stage_r[30] | stage_r[36]", "stage_r[27] | stage_r[30]"),
    ("target_tracker.v", "total_r[24] ? PERIOD : LESS_PERIOD", "LESS_PERIOD"),
    ("target_tracker.v", "total_r[24] ? PERIOD : LESS_PERIOD", "PERIOD"),
    ("target_tracker.v", "~(tries_r & sum_r[24])", "1'b1"),
    ("target_tracker.v", "{8'd0, ahead_r} - HALF_WINDOW", "{8'd0, ahead_r} - 10'd3"),
    ("target_tracker.v", "ahead_r <= placed[16:15]", "ahead_r <= {1'b0, placed[15]}"),
    ("target_tracker.v", "~placed[14], placed[13:0]", "1'b1, 14'd0"),
    ("target_tracker.v", "owed_r <= HALF_STEP[15:0]", "owed_r <= owed_r"),
    ("target_tracker.v", "{step_r, fraction_r} <= total_r[21:0]", "step_r <= total_r[21:15]"),
    ("target_tracker.v", "{3'd0, first_r, 15'd0} & {25{found_r}}", "25'd0"),
    ("target_tracker.v", "{3'd0, i_peak_step, 15'd0} & {25{found_r}}", "25'd0"),
    // What follows: patience, flags, a host that stops.
    ("target_tracker.v", "missed_r >= patience_r", "missed_r > patience_r"),
    ("target_tracker.v", "{missed_r, gives_up_r} <= 0", "missed_r <= 0"),
    ("target_tracker.v", "follows_r <= keeps", "follows_r <= on_r & ~gives_up_r"),
    ("target_tracker.v", "o_locked <= on_r & window_r & lit_r", "o_locked <= on_r & lit_r"),
    ("target_tracker.v", "follows_r <= keeps", "follows_r <= ~gives_up_r & (window_r | lit_r)"),
    ("target_tracker.v", "o_locked <= on_r & window_r & lit_r", "o_locked <= window_r & lit_r"),
    ("target_tracker.v", "& on_r & gives_up_r", "& gives_up_r"),
    ("target_tracker.v", "{follows_r, o_locked} <= 0", "o_locked <= 0"),
    ("target_tracker.v", "{follows_r, o_locked} <= 0", "follows_r <= 0"),
    // What a host that stops reads for a clock.
    (
        "target_tracker.v",
        "{follows_r, o_locked} <= 0",
        "follows_r <= 0; if (~i_go & ~follows_r) o_locked <= 0",
    ),
    ("target_tracker.v", "{step_r, fraction_r[14:7]}", "{step_r, fraction_r[13:6]}"),
    ("target_tracker.v", "stage_r[24] & ~lit_r", "1'b0"),
    // What a reset leaves.
    ("target_tracker.v", "o_lost} <= 0;", "o_lost} <= 0; follows_r <= follows_r;"),
    // What a host reads, and clears.
    ("register_file.v", "{s_axil_wdata[7]", "{s_axil_wdata[6]"),
    ("sensor_top.v", ".i_go (tracker_go)", ".i_go (registers_go)"),
    ("register_file.v", "peak_word == 2'd2", "peak_word == 2'd3"),
    ("register_file.v", "{i_target_lost, i_refused", "{1'b0, i_refused"),
];

/// Faults in the Verilog of tests/scenes/rows.toml: detectors that are read out by rows.
pub const ROWS: &[Fault] = &[
    // Windows: shorter than the row, never begun anew, ends of steps that are none.
    ("row_sums.v", " WINDOW       = 4'h7", " WINDOW       = 4'h3"),
    ("row_sums.v", "opens_r <= i_dump", "opens_r <= 1'b0"),
    ("row_sums.v", "ends_r[0] <= i_dump", "ends_r[0] <= 1'b1"),
    ("row_sums.v", "ran_r[2] & ~(|remaining_r)", "ran_r[1] & ~(|remaining_r)"),
    // Where counters stood: after reset, and since.
    ("row_sums.v", "fresh_r <= 1'b1;", "fresh_r <= 1'b0;"),
    ("row_sums.v", "fresh_r <= 1'b0;", "fresh_r <= fresh_r;"),
    ("row_sums.v", "piece_r[5:0] - stood", "piece_r[5:0]"),
    ("row_sums.v", "{{3{growth_r[5]}}, growth_r}", "{3'd0, growth_r}"),
    ("row_sums.v", "base_r <= memory_word[14:6];", "base_r <= o_count;"),
    // The row: detectors that are left out, or taken for others.
    ("row_sums.v", "read_place_r == LAST_PLACE", "read_place_r == 3'h3"),
    ("row_sums.v", "o_place == LAST_PLACE", "o_place == 3'h3"),
    ("row_sums.v", "moves_r <= moves_on;", "moves_r <= o_take;"),
    ("row_sums.v", "o_store = moved_r[3] & ends_r[4]", "o_store = moved_r[3]"),
    ("pixel.v", "o_piece <= i_next;", "o_piece <= o_piece;"),
    ("pixel.v", "count_r <= 6'd0;", "count_r <= count_r;"),
    ("pixel.v", "{{3{correlator_addend[2]}}, correlator_addend}", "{3'd0, correlator_addend}"),
    (
        "pixel_array.v",
        "pixel_reference[7:4] = stepper_window[3:0]",
        "pixel_reference[7:4] = stepper_window[7:4]",
    ),
    // Results: of a step that is lost, the last of a scan, a sign.
    ("row_stream.v", "keeps_r <= load;", "keeps_r <= 1'b1;"),
    ("row_stream.v", "i_counted ? load :", "i_counted ? 1'b1 :"),
    ("row_stream.v", "(keeps_r | ~(|i_place))", "keeps_r"),
    ("row_stream.v", "last_r & ~more_r", "last_r"),
    ("row_stream.v", "load | (more_r & i_ready)", "load | more_r"),
    ("row_stream.v", "next_place_r == LAST_PLACE", "next_place_r == 3'h3"),
    ("row_stream.v", "if (i_counted & blocked)", "if (i_counted & more_r)"),
    ("row_stream.v", "{{7{count_r[8]}}, count_r}", "{7'd0, count_r}"),
    ("lookup_memory.v", "words[i_write_address] <= i_data", "words[i_address] <= i_data"),
];

/// Faults in the Verilog of tests/scenes/histogram.toml.
pub const HISTOGRAM: &[Fault] = &[
    // Bins: not begun anew, lost, in the wrong memory or row.
    ("bin_bank.v", "lowest_r <= i_hit;", "lowest_r <= 1'b1;"),
    ("bin_bank.v", "{i_above, lowest_r}", "{1'b0, lowest_r}"),
    ("bin_bank.v", "i_hit | i_first", "i_hit"),
    ("bin_bank.v", "writes_r & ~i_write_half", "writes_r"),
    ("bin_bank.v", "i_half ? i_row : i_read_row", "i_row"),
    ("bin_bank.v", "if (~i_come_hit & ~i_come_half)", "if (1'b0)"),
    ("bin_bank.v", "if (~i_come_hit & i_come_half)", "if (1'b0)"),
    ("bin_bank.v", "if (~i_come_hit & ~i_come_half)", "if (~i_come_hit)"),
    ("bin_bank.v", "if (~i_come_hit & i_come_half)", "if (i_come_half)"),
    ("block_memory.v", "word_r <= read_r;", "word_r <= words[i_address];"),
    ("bin_bank.v", "i_half ? o_bin : o_other", "i_write_half ? o_bin : o_other"),
    // Adders: the wrong sample, no clamp, a sum that begins at the wrong time.
    ("bin_adder.v", "i_hits & i_early", "i_hits"),
    ("bin_adder.v", "sum_r <= chosen_r;", "sum_r <= 2'd0;"),
    // A bin that is full, but not flagged where the memories change places.
    (
        "bin_adder.v",
        "o_clamped <= |hit_r[7:6]",
        "o_clamped <= (|hit_r[7:6]) & ~(hit_r[6] & i_half & ~i_held_half)",
    ),
    ("bin_adder.v", "if (i_held_half)", "if (i_come_half)"),
    ("bin_adder.v", "if (i_held_first)", "if (i_added_first)"),
    // Control: rows, code periods, frames, the reader.
    (
        "histogram_control.v",
        "ahead_is_last_r <= ahead_r == LAST_ROW_BUT_ONE",
        "ahead_is_last_r <= ahead_r == LAST_ROW_BUT_ONE + 5'd1",
    ),
    ("histogram_control.v", "first_r <= period_is_last_r", "first_r <= 1'b0"),
    ("histogram_control.v", "reads_r | (|out_r) | ~o_go", "reads_r | ~o_go"),
    ("histogram_control.v", "reads_r | (|out_r) | ~o_go", "reads_r | (|out_r)"),
    ("histogram_control.v", "ends & busy", "ends"),
    // A frame that ends in a clock in which a row is taken.
    ("histogram_control.v", "reads_r | (|out_r) | ~o_go", "reads_r ? ~o_go : ((|out_r) | ~o_go)"),
    ("histogram_control.v", "o_go = room_r | i_ready", "o_go = i_ready"),
    // A loss that is not told where the reader is at one row; what reset leaves.
    ("histogram_control.v", "ends & busy)", "ends & busy & ~(reads_r & read_is_last_r))"),
    ("histogram_control.v", "ends & busy)", "ends & busy & ~(reads_r & o_read_row == 5'd13))"),
    ("histogram_control.v", "room_r <= 1'b1;", "room_r <= room_r;"),
    ("histogram_control.v", "} <= 0;", "} <= 0; read_is_last_r <= read_is_last_r;"),
    // The top module: a row that changes while it waits.
    ("sensor_top.v", "if (control_shows)", "if (1'b1)"),
];

/// Faults in the Verilog of tests/scenes/histogram-one-memory.toml.
pub const ONE_MEMORY: &[Fault] = &[
    // Rows that come too early, without end, or are not said to be lost.
    ("histogram_control.v", "follows_r & first_r", "first_r"),
    ("histogram_control.v", "follows_r & first_r", "follows_r"),
    ("histogram_control.v", "comes = whole_before_r[2]", "comes = whole_before_r[1]"),
    ("histogram_control.v", "last_before_r[2]", "last_before_r[1]"),
    ("histogram_control.v", "comes & ~room_r & ~i_ready", "comes & ~room_r"),
    ("histogram_control.v", "~room_r & ~i_ready)", "~room_r & ~i_ready & ~last_before_r[1])"),
    (
        "histogram_control.v",
        "~room_r & ~i_ready)",
        "~room_r & ~i_ready & row_before_r[14:10] != 5'd17)",
    ),
    ("histogram_control.v", "if (i_ready)", "if (1'b0)"),
    ("histogram_control.v", "(room_r & comes) | (i_ready & comes)", "comes"),
    // A bin that is not begun anew, and one that does not leave.
    ("bin_bank.v", "i_hit | i_first", "i_hit"),
    ("bin_bank.v", "~i_come_hit & ~i_come_first", "~i_come_hit"),
];

/// Faults in how the cells of scenes/macropixel.toml are combined.
pub const MACROPIXEL: &[Fault] = &[
    // One pulse is enough, or three or all four are needed; all four are not enough.
    (
        "cell_combiner.v",
        "= sum_1 | carry_2",
        "= i_samples[3:0] | i_samples[7:4] | i_samples[11:8] | i_samples[15:12]",
    ),
    ("cell_combiner.v", "= sum_1 | carry_2", "= carry_2 | (sum_1 & (i_samples[15:12] ^ sum_0))"),
    ("cell_combiner.v", "= sum_1 | carry_2", "= carry_2"),
    ("cell_combiner.v", "= sum_1 | carry_2", "= sum_1"),
    // A gate of another kind, a carry that is lost.
    (
        "cell_combiner.v",
        "sum_1 = addends_2[3:0] ^ addends_2[7:4]",
        "sum_1 = addends_2[3:0] & addends_2[7:4]",
    ),
    (
        "cell_combiner.v",
        "i_samples[3:0] ^ i_samples[7:4] ^ i_samples[11:8]",
        "i_samples[3:0] ^ i_samples[7:4]",
    ),
    ("cell_combiner.v", "(i_samples[3:0] & i_samples[7:4])", "4'd0"),
    ("cell_combiner.v", "{sum_0, i_samples[15:12]}", "{i_samples[3:0], i_samples[15:12]}"),
    // A cell that is not connected, one in the place of another, one that always has a pulse.
    ("cell_combiner.v", "{sum_0, i_samples[15:12]}", "{sum_0, 4'd0}"),
    ("cell_combiner.v", "{sum_0, i_samples[15:12]}", "{sum_0, i_samples[3:0]}"),
    ("cell_combiner.v", "{sum_0, i_samples[15:12]}", "{sum_0, 4'd15}"),
    // Samples in another order: of one cell, a clock apart in another, cells and samples mixed up.
    (
        "cell_combiner.v",
        "i_samples[15:12]}",
        "i_samples[12], i_samples[13], i_samples[14], i_samples[15]}",
    ),
    ("cell_combiner.v", "i_samples[15:12]}", "i_samples[14:12], i_samples[15]}"),
    (
        "cell_combiner.v",
        "i_samples[15:12]}",
        "i_samples[12], i_samples[8], i_samples[4], i_samples[0]}",
    ),
];

/// Faults in how the hits of the cells of tests/scenes/adder.toml are added up.
pub const ADDER: &[Fault] = &[
    // Edges of a cell at the border of words: of another cell, of none, swapped.
    (
        "edge_detector.v",
        "{i_samples[10:8], last_samples_r[2]",
        "{i_samples[10:8], last_samples_r[1]",
    ),
    ("edge_detector.v", "{i_samples[10:8], last_samples_r[2]", "{i_samples[10:8], i_samples[7]"),
    ("edge_detector.v", "{i_samples[11], i_samples[7]", "{i_samples[7], i_samples[11]"),
    (
        "edge_detector.v",
        "assign earlier[g] = i_samples[2*g]",
        "assign earlier[g] = i_samples[2*(g % 2)]",
    ),
    // Cells that count once where they are hit together, or not at all, or twice.
    ("updown_correlator.v", "quad_sum[3:0] + quad_sum[7:4]", "quad_sum[3:0] | quad_sum[7:4]"),
    ("updown_correlator.v", "{2'd0, hit_r[5:4]}", "{3'd0, hit_r[4]}"),
    ("updown_correlator.v", "{2'd0, hit_r[5:4]}", "{hit_r[4], 1'd0, hit_r[5:4]}"),
    ("updown_correlator.v", "= hit_r[3:0]", "= {hit_r[3:1], hit_r[0] & ~hit_r[2]}"),
    // A sign of another sample, and a carry that is lost.
    ("updown_correlator.v", "{i_reference[3], i_reference[1]", "{i_reference[1], i_reference[3]"),
    ("updown_correlator.v", "{2'd0, down_r[5:4]}", "{2'd0, down_r[5], down_r[5]}"),
    (
        "updown_correlator.v",
        "quad_sum[3:0] + quad_sum[7:4]",
        "{quad_sum[3] ^ quad_sum[7], quad_sum[2:0] + quad_sum[6:4]}",
    ),
    // The same of the total.
    ("hit_counter.v", "{2'd0, hit_r[5:4]}", "{3'd0, hit_r[4]}"),
    ("hit_counter.v", "quad_sum[3:0] + quad_sum[7:4]", "quad_sum[3:0] | quad_sum[7:4]"),
    ("sensor_top.v", "i_samples[12*g +: 12]", "i_samples[0 +: 12]"),
];

/// Faults in how the cells of tests/scenes/odd-cells.toml are.
pub const ODD_CELLS: &[Fault] = &[
    (
        "cell_combiner.v",
        "i_samples[1:0] ^ i_samples[3:2] ^ i_samples[5:4]",
        "i_samples[1:0] | i_samples[3:2] | i_samples[5:4]",
    ),
    ("cell_combiner.v", "i_samples[3:2] ^ i_samples[5:4]", "i_samples[3:2]"),
    ("sensor_top.v", "= ~i_samples", "= i_samples"),
    ("sensor_top.v", "pulses[6*g +: 6]", "pulses[0 +: 6]"),
    (
        "sensor_top.v",
        "combiner_level[2*g +: 2]),\n            .i_run",
        "combiner_level[2*(1-g) +: 2]),\n            .i_run",
    ),
];
