"""What Python is told, against what the command line prints of the same."""

import json
import os
import subprocess

import goldtof
import pytest
from conftest import ROOT

SCENE = "scenes/quick.toml"


def command_line(*arguments):
    """Status, stdout and stderr of the program, in the repository's folder."""
    program = os.environ["GOLDTOF"]
    assert os.path.exists(program), f"{program} is not there: cargo build --workspace"
    ran = subprocess.run([program, *arguments], cwd=ROOT, capture_output=True, text=True)
    return ran.returncode, ran.stdout, ran.stderr


@pytest.fixture
def scene(monkeypatch):
    monkeypatch.chdir(ROOT)
    return goldtof.Scene.load(SCENE)


# What every document begins with, and what two runs differ in.
HEADS = {"document", "goldtof", "commit", "command", "scene"}
TIMES = {"run_time_s", "clocks_per_s"}


def is_same(told, expected):
    """Whether all is equal but for run times, the floats to their last bit."""
    assert told.keys() == expected.keys()
    differing = {name: (told[name], expected[name]) for name in told if told[name] != expected[name]}
    return not differing.keys() - TIMES


def answer(*arguments):
    """The command line's JSON, without its head."""
    status, out, told = command_line("--json", *map(str, arguments))
    assert status in (0, 1), told
    document = json.loads(out)
    return {name: value for name, value in document.items() if name not in HEADS}


@pytest.mark.parametrize("fidelity", ["expected", "counts", "events", "sampled"])
def test_simulations_are_those_of_the_command_line(scene, fidelity):
    repetitions = 1 if fidelity == "expected" else 7
    told = goldtof.simulate(scene, fidelity=fidelity, repetitions=repetitions, seed=9)
    expected = answer("simulate", SCENE, "--fidelity", fidelity, "--repeat", repetitions,
                      "--seed", 9)
    assert expected["estimates"] and is_same(told, expected)


def test_estimators_and_settings_are_those_of_the_command_line(scene):
    scene["path.distance"] = "5.5 m"
    told = goldtof.simulate(scene, fidelity="events", repetitions=3, estimator="model")
    expected = answer("simulate", SCENE, "--set", "path.distance=5.5 m", "--repeat", 3,
                      "--fidelity", "events", "--estimator", "model")
    assert is_same(told, expected)
    assert told["estimates"][0]["true_distance_m"] == 5.5


def test_codes_are_those_of_the_command_line():
    told = goldtof.codes("gold", degree=7, index=2, interleave=1)
    expected = answer("codes", "--family", "gold", "--degree", 7, "--index", 2, "--interleave", 1)
    chips = "".join(map(str, told.pop("chips")))
    assert chips == expected.pop("chips") and len(chips) == 254
    assert told == expected


def test_co_simulations_are_those_of_the_command_line(scene):
    told = goldtof.cosim(scene, stimulus="adversarial", clocks=20_000, engine="lockstep")
    expected = answer("cosim", SCENE, "--stimulus", "adversarial", "--clocks", 20_000,
                      "--engine", "lockstep")
    assert told["verdict"] == "match" and is_same(told, expected)


def test_estimates_are_those_of_the_command_line(scene, tmp_path):
    counts = goldtof.scans(scene, fidelity="sampled", seed=3)
    signed, total = counts["signed"][0], counts["total"][0]
    rows = "".join(f"{step},{a},{b}\n" for step, (a, b) in enumerate(zip(signed, total)))
    recorded = tmp_path / "counts.csv"
    recorded.write_text("phase_step,count,total_count\n" + rows)
    expected = answer("estimate", SCENE, recorded)
    told = goldtof.estimate(scene, signed, total=total)
    expected = expected["assessments"][0]
    # A row for each step there, an array for each column here.
    for rows in ("phase_steps", "bins"):
        columns, steps = told.pop(rows), expected.pop(rows)
        assert all(column.size == len(steps) for column in columns.values())
        for number, step in enumerate(steps):
            assert {name: column[number] for name, column in columns.items()} == step
    assert is_same(told, expected)


REFUSED = {
    "a file that is not there": (
        lambda scene, folder: goldtof.Scene.load("scenes/quik.toml"),
        ["plan", "scenes/quik.toml"],
    ),
    "a scene that is malformed": (
        lambda scene, folder: goldtof.Scene.load(str(folder / "bad.toml")),
        ["plan", "{folder}/bad.toml"],
    ),
    "hardware that is not made": (
        lambda scene, folder: goldtof.emit(goldtof.Scene.load(str(folder / "long.toml")), folder / "out"),
        ["emit", "{folder}/long.toml", "--out", "{folder}/out"],
    ),
    "a folder without Verilog": (
        lambda scene, folder: goldtof.cosim(scene, rtl=folder),
        ["cosim", SCENE, "--rtl", "{folder}"],
    ),
    "a folder that cannot be made": (
        lambda scene, folder: goldtof.emit(scene, folder / "bad.toml" / "out"),
        ["emit", SCENE, "--out", "{folder}/bad.toml/out"],
    ),
    "a code that cannot be": (
        lambda scene, folder: goldtof.codes("gold", degree=8),
        ["codes", "--family", "gold", "--degree", "8"],
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_errors_have_the_words_of_the_command_line(scene, tmp_path, case):
    text = (ROOT / SCENE).read_text()
    (tmp_path / "bad.toml").write_text(text.replace('"8 ns"', '"8 kg"').replace("degree = 5", "degree = 8"))
    (tmp_path / "long.toml").write_text(text.replace("degree = 5", "degree = 18"))
    call, arguments = REFUSED[case]
    status, _, told = command_line(*(argument.format(folder=tmp_path) for argument in arguments))
    with pytest.raises(goldtof.GoldtofError) as caught:
        call(scene, tmp_path)
    assert status in (2, 3)
    assert told.endswith(f"error: {caught.value}\n")
