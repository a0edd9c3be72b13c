"""The cocotb scoreboard in Icarus and Verilator, on emitted and own Verilog."""

import os
import subprocess
import sys
from pathlib import Path

import goldtof
import pytest
from conftest import ROOT, of_a_release

EXAMPLE = ROOT / "python/examples/cocotb"
OWN = [ROOT / "examples/own-rtl/rtl" / name for name in
       ("range_top.v", "code_rom.v", "correlator.v", "stream_port.sv")]
QUICK = ROOT / "scenes/quick.toml"


@pytest.fixture
def bench(monkeypatch):
    """The example's own way to build and run."""
    # Its runner hands our path on to the simulator's Python.
    monkeypatch.syspath_prepend(EXAMPLE)
    # It runs for a moment, and would be compiled for long.
    monkeypatch.setenv("MAKEFLAGS", "-j2 OPT_GLOBAL=-O0 OPT_FAST=-O0 OPT_SLOW=-O0")
    # What it sets for Verilator is undone with the rest.
    for name in ("PATH", "VERILATOR_ROOT"):
        monkeypatch.setenv(name, os.environ.get(name, ""))
    if not os.environ["VERILATOR_ROOT"]:
        monkeypatch.delenv("VERILATOR_ROOT")
    import run

    yield run
    del sys.modules["run"]


@pytest.mark.parametrize("simulator", [pytest.param("icarus", marks=of_a_release), "verilator"])
def test_own_verilog_matches_at_its_latency_alone(bench, simulator, tmp_path):
    defines = {"DESIGN": "range_top", "ADDER_STAGES": 8}
    bench.build(simulator, tmp_path, OWN, defines, [ROOT / "examples/own-rtl/include"])
    failed, log = bench.run(simulator, tmp_path, QUICK, LATENCY="10")
    assert failed == 0, log
    assert "match: " in log and "spad: 2 results" in log
    failed, log = bench.run(simulator, tmp_path, QUICK, LATENCY="9")
    assert failed == 1, log
    # Four clocks of reset, then words from clock 5 on: the first step's last is clock 2504.
    assert "clock 2513 " in log and "port m_axis_tdata should be 0x" in log


@pytest.fixture
def short(tmp_path):
    """The file of a scene whose scans end within a run."""
    text = QUICK.read_text().replace('"20 us"', '"2 us"')
    text = text.replace('steps = "all"', 'steps = { around = "3.2 m", halfwidth = 4 }')
    scene = tmp_path / "short.toml"
    scene.write_text(text)
    return scene


def emit_with_a_fault(scene, folder):
    """The emitted Verilog, with a fault that a run switches on by +FAULT."""
    names = goldtof.emit(scene, folder)["files"]
    faulty = folder / "edge_detector.v"
    text, right = faulty.read_text(), "last_sample_r <= i_samples[7];"
    assert text.count(right) == 1
    wrong = 'last_sample_r <= i_samples[7] & !$test$plusargs("FAULT");'
    faulty.write_text(text.replace(right, wrong))
    return [folder / name for name in names]


@pytest.mark.parametrize("simulator", ["icarus", pytest.param("verilator", marks=of_a_release)])
def test_emitted_verilog_matches_and_a_fault_is_named(bench, simulator, tmp_path, short):
    scene = goldtof.Scene.load(short)
    bench.build(simulator, tmp_path, emit_with_a_fault(scene, tmp_path / "rtl"))
    failed, log = bench.run(simulator, tmp_path, short)
    assert failed == 0, log
    results = 6000 // 250
    assert "match: " in log and f"{results} results" in log
    assert log.count(f"a scan of {scene.phase_steps} counts") == results // scene.phase_steps
    failed, log = bench.run(simulator, tmp_path, short, plusargs=["+FAULT"])
    assert failed == 1, log
    # Hits that go over from word to word count twice: the first step's count shows it.
    assert "Mismatch" in log and "clock 260 " in log
    assert "port m_axis_tdata should be 0x" in log


def test_the_example_runs_by_itself(bench, capsys):
    assert bench.main("icarus", str(QUICK)) == 0
    assert "PASS=1 FAIL=0" in capsys.readouterr().out


def made(folder, *arguments):
    """`make` in what `emit --cocotb` has written; its status and what it said."""
    environment = os.environ | {
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        "PYTHON": sys.executable,
    }
    command = ["make", "SIM=icarus", *arguments]
    done = subprocess.run(
        command, cwd=folder, env=environment, check=False, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    # cocotb's Makefiles end well whatever the tests say.
    return done.stdout


def emitted(scene, folder, *words):
    subprocess.run([os.environ["GOLDTOF"], "emit", scene, "--out", folder, "--cocotb", "--quiet",
                    *words], check=True)
    return folder / "cocotb"


def test_what_emit_writes_for_cocotb_runs_and_finds_a_fault(tmp_path, short):
    folder = emitted(short, tmp_path / "rtl", "--set", "path.distance=5 m")
    said = made(folder)
    assert "PASS=1 FAIL=0" in said and "match: " in said, said
    (folder / "results.xml").unlink()
    faulty = tmp_path / "rtl/edge_detector.v"
    text, right = faulty.read_text(), "last_sample_r <= i_samples[7];"
    assert text.count(right) == 1
    faulty.write_text(text.replace(right, "last_sample_r <= 1'b0;"))
    said = made(folder)
    assert "PASS=0 FAIL=1" in said and "port m_axis_tdata should be" in said, said


@pytest.mark.parametrize("scene", ["every-part", "histogram"])
def test_it_is_wired_for_whatever_ports_there_are(tmp_path, scene):
    said = made(emitted(ROOT / f"tests/scenes/{scene}.toml", tmp_path / "rtl"))
    assert "PASS=1 FAIL=0" in said, said


@pytest.mark.parametrize(
    "scene", [pytest.param(QUICK, marks=of_a_release), ROOT / "tests/scenes/registers.toml"])
def test_a_host_sets_a_scan_and_a_setting_that_is_not_taken_is_found(tmp_path, scene):
    folder = emitted(scene, tmp_path / "rtl", "--set", "hardware.registers=axi4-lite")
    said = made(folder)
    assert "PASS=2 FAIL=0" in said and said.count("match: ") == 2, said
    (folder / "results.xml").unlink()
    faulty = tmp_path / "rtl/scan_sequencer.v"
    text, right = faulty.read_text(), "if (take_r[2]) "
    assert text.count(right) == 1
    faulty.write_text(text.replace(right, "if (take_r[2] & !i_word[2]) "))
    said = made(folder)
    # A scan of four groups has those of the scene.
    assert "FAIL=" in said and "FAIL=0" not in said and "Mismatch" in said, said


@pytest.mark.parametrize(
    "host", [pytest.param([], marks=of_a_release), ["--set", "hardware.registers=axi4-lite"]])
def test_cells_have_pulses_together_and_each_of_them_has_some(tmp_path, host):
    folder = emitted(ROOT / "scenes/macropixel.toml", tmp_path / "rtl", *host)
    said = made(folder)
    assert "FAIL=0" in said and "match: " in said, said
    faulty = tmp_path / "rtl/cell_combiner.v"
    text, right = faulty.read_text(), "{sum_0, i_samples[15:12]}"
    (folder / "results.xml").unlink()
    assert text.count(right) == 1
    faulty.write_text(text.replace(right, "{sum_0, 4'd0}"))
    said = made(folder)
    assert "FAIL=0" not in said and "should be" in said, said


def test_own_verilog_is_held_to_the_latency_that_it_shows(tmp_path):
    folder = emitted(QUICK, tmp_path / "rtl")
    own = ["RTL=" + " ".join(map(str, OWN)), "DESIGN=range_top",
           f"COMPILE_ARGS=-DADDER_STAGES=8 -I{ROOT}/examples/own-rtl/include"]
    said = made(folder, *own, "LATENCY=auto")
    assert "PASS=1 FAIL=0" in said, said
    assert "results after 10 clocks, 4 later than the emitted design's" in said
    # Held to that of the emitted design it is late.
    (folder / "results.xml").unlink()
    said = made(folder, *own)
    assert "PASS=0 FAIL=1" in said and "clock 25" in said, said


def test_a_latency_that_is_none_is_refused():
    ports = [("i_rst", 1)]
    with pytest.raises(ValueError, match='write clocks, or "auto"'):
        goldtof.Scoreboard(goldtof.Scene.load(QUICK), ports, result_latency_clocks="soon")
