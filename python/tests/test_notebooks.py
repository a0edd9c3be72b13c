"""The notebooks run, draw what they show, and what they say of it holds."""

import runpy

import matplotlib
import matplotlib.pyplot as plt
import pytest
from conftest import ROOT

matplotlib.use("Agg")


@pytest.fixture
def run(tmp_path, monkeypatch):
    for name in ("scenes", "examples"):
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)
    drawn = []

    def show():
        drawn.append(tmp_path / f"{len(drawn)}.png")
        plt.savefig(drawn[-1])
        plt.close("all")

    monkeypatch.setattr(plt, "show", show)

    def run_one(name):
        names = runpy.run_path(str(ROOT / "python/examples" / name))
        assert [path.stat().st_size > 10_000 for path in drawn] == [True]
        return names

    return run_one


def test_bias_against_light(run):
    names = run("bias_against_light.py")
    # Fourteen points; one beyond 4 standard errors by chance in a thousand runs.
    assert names["farthest"] < 4
    phase, fit = (names["expected"][name]["expected_bias_m"].abs() for name in ("fft", "model"))
    # In weak light the coarse stage wavers, which adds to the walk.
    # The fit has what corners of the code's correlation leave in dim light.
    assert phase.iloc[2:].is_monotonic_increasing and phase.iloc[-1] > 0.05 and fit.max() < 1.5e-3


def test_own_rtl(run):
    names = run("own_rtl.py")
    assert names["hostile"]["verdict"] == "match"
    agreed = dict(zip(names["latencies"], names["agreed"]))
    assert agreed[names["latency"]] == 20_000
    # The first result, later or earlier: which of the two comes first ends it.
    own = agreed[names["latency"] + 1]
    assert all(
        clocks == own - max(names["latency"] - held_to, 0)
        for held_to, clocks in agreed.items()
        if held_to != names["latency"]
    )


def test_recorded_counts(run, capsys):
    names = run("recorded_counts.py")
    assert abs(names["estimates"]["model"] - 4.321) < 0.06
    assert "dead time" in names["wrong"]["diagnosis"]["sentence"]
    assert names["right"]["diagnosis"]["causes"] == []
    # The last residuals, 248 of them, are those against the wrong dead time.
    assert names["residuals"].mean() > 5 / 248**0.5
