"""The jobs, against the command line's numbers where it has them and theory where not."""

import multiprocessing
import signal
import threading
import time

import goldtof
import numpy as np
import pytest
from conftest import ROOT


def test_codes_correlate_as_gold_says():
    code = goldtof.codes("gold", degree=7, index=3)
    other = goldtof.codes("gold", degree=7, index=4)
    assert len(code["chips"]) == code["length_chips"] == 127
    of_both = goldtof.correlation(code["chips"], other["chips"])
    # Gold's theorem: -1, -t, t - 2 with t = 2^((n + 1) / 2) + 1.
    assert set(of_both.tolist()) <= {-1, -17, 15}
    signs = 1 - 2.0 * code["chips"]
    by_fft = np.fft.ifft(np.abs(np.fft.fft(signs)) ** 2).real.round()
    assert (goldtof.correlation(code["chips"], code["chips"]) == by_fft).all()
    with pytest.raises(ValueError, match="family"):
        goldtof.codes("silver", degree=7)


def test_emit_writes_what_the_repository_keeps(quick, tmp_path):
    manifest = goldtof.emit(quick, tmp_path / "out")
    kept = ROOT / "generated/quick"
    assert manifest["top"] == "sensor_top"
    assert len(manifest["files"]) > 5
    for name in manifest["files"]:
        assert (tmp_path / "out" / name).read_text() == (kept / name).read_text(), name


@pytest.mark.parametrize("fidelity", ["counts", "events", "sampled"])
def test_expected_counts_are_those_of_many_scans(quick, fidelity):
    told = goldtof.expected(quick, fidelity=fidelity)
    scans = goldtof.scans(quick, fidelity=fidelity, repetitions=400, seed=5)
    assert scans["signed"].shape == (400, 248)
    for name in ("signed", "total"):
        error = scans[name].mean(axis=0) - told[f"{name}_mean"]
        in_std = error / np.sqrt(told[f"{name}_variance"] / 400)
        # One of 248 numbers beyond 5 standard deviations has a chance of 1.4e-4.
        assert np.abs(in_std).max() < 5, name
        assert 0.8 < np.mean(in_std**2) < 1.3, name
        spread = scans[name].var(axis=0, ddof=1) / told[f"{name}_variance"]
        assert abs(spread.mean() - 1) < 0.05, name
    assert told["expected_std_m"] >= told["bound_m"] > 0


def test_tiers_agree_with_theory_and_hear_of_progress(quick):
    heard = []
    told = goldtof.simulate(
        quick, fidelity="counts", repetitions=300, on_progress=lambda *args: heard.append(args)
    )
    path = told["estimates"][0]
    assert path["estimates"] + path["missed_scans"] == 300
    assert abs(path["std_m"] / path["expected_std_m"] - 1) < 0.2
    assert heard and heard[-1] == (300, 300)
    exact = goldtof.simulate(quick)["estimates"][0]
    assert exact["bias_m"] == exact["expected_bias_m"]
    with pytest.raises(ValueError, match="there are expected, counts, events, sampled, rtl"):
        goldtof.simulate(quick, fidelity="guess")


def test_estimates_find_the_scenes_distance(quick):
    counts = goldtof.scans(quick, fidelity="sampled", repetitions=1, seed=2)
    told = goldtof.estimate(quick, counts["signed"][0], total=counts["total"][0])
    assert abs(told["estimate"]["distance_m"] - 3.2) < 0.3
    assert told["chi_square"] / told["degrees_of_freedom"] < 1.5
    steps = told["phase_steps"]
    assert (steps["count"] == counts["signed"][0]).all()
    both = np.concatenate([steps["residual_in_std"], steps["total_residual_in_std"]])
    assert np.isclose((both**2).sum(), told["chi_square"])
    with pytest.raises(ValueError, match="3 phase steps were counted, and a scan of this scene has 248"):
        goldtof.estimate(quick, np.zeros(3, np.int64))
    with pytest.raises(ValueError, match='no detector "eye"; it has "spad"'):
        goldtof.estimate(quick, counts["signed"][0], detector="eye")


def test_histograms_come_as_bins_and_give_the_distance(quick):
    quick["hardware.architecture"] = "histogram"
    bins = goldtof.scans(quick, fidelity="sampled", repetitions=40, seed=2)["bins"]
    assert bins.shape == (40, 248) and bins.dtype == np.uint64
    expected = goldtof.expected(quick)
    # Neighbours go together, so that the sum of squares scatters more than its parts do.
    sigmas = (bins.mean(axis=0) - expected["bin_mean"]) / (expected["bin_std"] / np.sqrt(40))
    assert abs(np.mean(sigmas**2) - 1) < 0.5
    told = goldtof.estimate(quick, bins=bins[0])
    assert abs(told["estimate"]["distance_m"] - 3.2) < 0.3
    assert (told["bins"]["count"] == bins[0]).all() and told["phase_steps"]["count"].size == 0
    assert abs(np.mean(told["bins"]["residual_in_std"] ** 2) - 1) < 0.5
    assert told["diagnosis"]["causes"] == []
    with pytest.raises(ValueError, match="3 bins were given, and a histogram of this scene has 248"):
        goldtof.estimate(quick, bins=np.zeros(3, np.uint64))
    with pytest.raises(ValueError, match="bin 0 counts 99 rising edges, but each of the 81"):
        goldtof.estimate(quick, bins=np.full(248, 99, np.uint64))
    with pytest.raises(ValueError, match="give counts, of phase steps"):
        goldtof.estimate(quick)
    quick["hardware.architecture"] = "updown"
    with pytest.raises(ValueError, match="bins are of a sensor that keeps a histogram"):
        goldtof.estimate(quick, bins=bins[0])


def test_cosim_tells_matches_from_faults(quick, tmp_path):
    own = ["examples/own-rtl/range_top.f"]
    lists = [ROOT / name for name in own]
    told = goldtof.cosim(
        quick, file_lists=lists, top="range_top", latency="auto", clocks=20_000, engine="lockstep"
    )
    assert told["verdict"] == "match" and told["latency"]["result_clocks"] == 10
    told = goldtof.cosim(
        quick, file_lists=lists, top="range_top", clocks=20_000, engine="lockstep"
    )
    assert told["verdict"] == "mismatch"
    assert told["first_mismatch"]["port"].startswith("m_axis_")
    with pytest.raises(goldtof.GoldtofError):
        goldtof.cosim(quick, rtl=tmp_path)


@pytest.fixture
def interruptible():
    """SIGINT as in a shell: whoever starts the tests in the background has it ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_other_threads_run_and_ctrl_c_ends_a_long_call(quick, interruptible):
    turns = []
    over = threading.Event()

    def count():
        while not over.wait(0.01):
            turns.append(1)

    def interrupt():
        time.sleep(0.5)
        signal.raise_signal(signal.SIGINT)

    for job in (count, interrupt):
        threading.Thread(target=job, daemon=True).start()
    started = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        goldtof.simulate(quick, fidelity="sampled", repetitions=1_000_000)
    took_s = time.monotonic() - started
    over.set()
    assert took_s < 2 and len(turns) > 5


def test_a_callback_that_raises_ends_the_call(quick):
    def stop(done, all):
        raise RuntimeError(f"enough at {done}")

    with pytest.raises(RuntimeError, match="enough at"):
        goldtof.simulate(quick, fidelity="sampled", repetitions=1_000_000, on_progress=stop)


def test_sweeps_are_frames_and_datasets_of_numbers_with_units(quick):
    over = {"path.distance": ["1 m", "200 cm", "10 m"], "source.mean_power": ["20 pW", "10 pW"]}
    frame = goldtof.sweep(quick, over)
    assert frame["path.distance"].tolist() == [1, 1, 2, 2, 10, 10]
    assert frame["true_distance_m"].round(9).tolist() == [1, 1, 2, 2, 10, 10]
    assert frame.attrs["units"]["source.mean_power"] == "W" and frame.attrs["units"]["std_m"] == "m"
    data = goldtof.sweep(quick, over, to="xarray")
    assert data["source.mean_power"].values.tolist() == [1e-11, 2e-11]
    assert data["path.distance"].attrs["units"] == data["bias_m"].attrs["units"] == "m"
    # A slice takes what lies between; as texts "10 m" would lie between "1 m" and "2 m".
    near = data["bias_m"].sel({"path.distance": slice(1, 2)})
    assert near.sizes["path.distance"] == 2
    point = data["bias_m"].sel({"path.distance": 2, "source.mean_power": 2e-11})
    quick["path.distance"] = "2 m"
    alone = goldtof.simulate(quick)["estimates"][0]["bias_m"]
    assert float(point.squeeze()) == alone


def test_a_sweep_takes_arrays_with_a_unit_and_texts_in_their_order(quick):
    over = {"path.distance": (np.linspace(100, 300, 3), "cm"), "estimate.estimator": ["model", "fft"]}
    data = goldtof.sweep(quick, over, to="xarray")
    assert data["path.distance"].values.tolist() == [1, 2, 3]
    assert data["estimate.estimator"].values.tolist() == ["model", "fft"]
    si = goldtof.sweep(quick, {"path.distance": np.linspace(1, 3, 3)})
    of_fft = data["expected_std_m"].sel({"estimate.estimator": "fft"}).values.ravel()
    assert si["expected_std_m"].tolist() == of_fft.tolist()
    with pytest.raises(ValueError, match="is one value; write a list"):
        goldtof.sweep(quick, {"path.distance": "1 m"})


def test_counts_that_no_hardware_has_are_refused(quick):
    """As the command line refuses them; else a sine of any amplitude is a distance."""
    steps = quick.phase_steps
    sine = (9e18 * np.sin(2 * np.pi * np.arange(steps) / steps)).astype(np.int64)
    with pytest.raises(ValueError, match="hold at most"):
        goldtof.estimate(quick, sine)
    counts, totals = np.full(steps, 2), np.full(steps, 4, np.uint64)
    totals[7] = 1
    with pytest.raises(ValueError, match="phase step 7: total_count is 1; with count 2"):
        goldtof.estimate(quick, counts, total=totals)
    totals[7] = 5
    with pytest.raises(ValueError, match="phase step 7: .* both even or both odd"):
        goldtof.estimate(quick, counts, total=totals)
    with pytest.raises(ValueError, match="247 phase steps were counted"):
        goldtof.estimate(quick, counts, total=totals[1:])


def _simulated(answers):
    scene = goldtof.Scene.load(ROOT / "scenes/quick.toml")
    answers.put(goldtof.simulate(scene, fidelity="counts", repetitions=50)["estimates"][0]["std_m"])


def test_a_child_of_fork_computes(quick):
    """The parent's threads are not there, and nobody may wait for them."""
    here = goldtof.simulate(quick, fidelity="counts", repetitions=50)["estimates"][0]["std_m"]
    fork = multiprocessing.get_context("fork")
    answers = fork.SimpleQueue()
    child = fork.Process(target=_simulated, args=(answers,))
    child.start()
    child.join(60)
    is_over = child.exitcode is not None
    child.kill()
    assert is_over and child.exitcode == 0
    assert answers.get() == here
