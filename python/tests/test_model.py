"""The reference model in batches, against the definition of the counts."""

from concurrent.futures import ThreadPoolExecutor

import goldtof
import numpy as np
import pytest

RESET_CLOCKS = 2
STEP_CLOCKS = 2500


def counts_by_definition(samples: np.ndarray, lanes: int, step: int, code: np.ndarray):
    """Signed and total count of a phase step (eq. 11), from the samples themselves."""
    level = ((samples[:, None] >> np.arange(lanes, dtype=np.uint64)) & np.uint64(1)).astype(bool).reshape(-1)
    hits = np.flatnonzero(level[1:] & ~level[:-1]) + 1
    first = (RESET_CLOCKS + 1 + step * STEP_CLOCKS) * lanes
    hits = hits[(hits >= first) & (hits < first + STEP_CLOCKS * lanes)]
    since_reset = hits - (RESET_CLOCKS + 1) * lanes
    chips = code[((since_reset - step) // lanes) % len(code)].astype(int)
    return int((2 * chips - 1).sum()), len(hits)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.uint32, np.uint64])
def test_results_are_the_counts_of_the_definition(quick, dtype):
    random = np.random.default_rng(4)
    clocks = 3 * STEP_CLOCKS + 100
    samples = (random.integers(0, 256, clocks) & random.integers(0, 256, clocks)).astype(dtype)
    reset = np.arange(clocks) < RESET_CLOCKS
    code = goldtof.codes("gold", degree=5)["chips"]
    model = goldtof.ReferenceModel(quick)
    outputs = model.clock(samples, reset)
    results = model.take_results()
    assert results["step"].tolist() == [0, 1, 2]
    for step in range(3):
        expected = counts_by_definition(samples.astype(np.uint64), 8, step, code)
        assert (results["count"][step], results["total"][step]) == expected
    # The same numbers on the stream, at the clocks that the results name.
    valid = np.flatnonzero(outputs["m_axis_tvalid"])
    assert valid.tolist() == results["clock"].tolist()
    assert outputs["m_axis_tdata"][valid].astype(np.int16).tolist() == results["count"].tolist()
    assert (outputs["o_laser"][RESET_CLOCKS:] == np.resize(code, clocks - RESET_CLOCKS)).all()


def test_state_stays_between_batches(quick):
    random = np.random.default_rng(5)
    clocks = 20_000
    samples = random.integers(0, 256, clocks, dtype=np.uint8)
    reset = (np.arange(clocks) < 3) | (np.arange(clocks) == 11_000)
    ready = random.integers(0, 9, clocks) == 0
    whole = goldtof.ReferenceModel(quick)
    expected = whole.clock(samples, reset, ready)
    parts = goldtof.ReferenceModel(quick)
    borders = [0, 1, 2, 4000, 10_999, 11_000, 11_001, 20_000]
    found = [
        parts.clock(samples[a:b], reset[a:b], ready[a:b].astype(np.uint8))
        for a, b in zip(borders, borders[1:])
    ]
    for port, values in expected.items():
        assert (np.concatenate([part[port] for part in found]) == values).all(), port
    assert parts.clocks == whole.clocks == clocks
    taken = parts.take_results()
    assert all((values == taken[name]).all() for name, values in whole.take_results().items())


def test_several_detectors_have_columns():
    from conftest import ROOT

    scene = goldtof.Scene.load(ROOT / "scenes/dual-view.toml")
    detectors = len(scene.detectors)
    model = goldtof.ReferenceModel(scene)
    outputs = model.clock(np.zeros((100, detectors), np.uint8), np.arange(100) < 1)
    assert outputs["o_laser"].max() > 1
    with pytest.raises(ValueError, match=rf"\(clocks, {detectors}\)"):
        model.clock(np.zeros((100, detectors + 1), np.uint8))


def test_inputs_that_are_not_meant_are_refused(quick):
    model = goldtof.ReferenceModel(quick)
    with pytest.raises(ValueError, match="clock 1: the sample word of input 0 is 0x100"):
        model.clock(np.array([0, 256], np.uint16))
    with pytest.raises(ValueError, match="float64"):
        model.clock(np.zeros(3))
    with pytest.raises(ValueError, match="i_rst has 2 clocks, and i_samples has 3"):
        model.clock(np.zeros(3, np.uint8), np.zeros(2, bool))
    with pytest.raises(ValueError, match="at most 4096"):
        goldtof.ReferenceModel(quick, result_latency_clocks=5000)
    # Far behind the first blocks that are clocked together.
    late = np.zeros(100_000, np.uint16)
    late[-1] = 0x100
    with pytest.raises(ValueError, match="clock 99999: the sample word"):
        model.clock(late)
    assert model.clocks == 0
    every_other = model.clock(np.zeros(10, np.uint8)[::2])
    assert len(every_other["o_laser"]) == 5


def test_threads_share_a_model_and_a_scoreboard(quick):
    """Calls of several threads wait for each other, and no clock is lost."""
    model = goldtof.ReferenceModel(quick)
    board = goldtof.Scoreboard(quick, [(name, width) for name, width in quick.ports])
    samples, reset = np.zeros(200_000, np.uint8), np.zeros(200_000, bool)
    words = np.zeros(board.words * 50_000, np.uint64)
    with ThreadPoolExecutor(4) as threads:
        clocked = [threads.submit(model.clock, samples, reset) for _ in range(8)]
        pushed = [threads.submit(board.push, words) for _ in range(8)]
        for done in clocked + pushed:
            done.result()
    assert model.clocks == 8 * len(samples)
    assert board.summary()["verdict"] == "inconclusive"
