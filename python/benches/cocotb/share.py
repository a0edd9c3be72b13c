"""What the scoreboard takes of a cocotb simulation: the example's testbench, with
recorder and scoreboard and without either, in turns.

    python python/benches/cocotb/share.py icarus|verilator [CLOCKS] [ROUNDS]

Prints the shortest times of both, in seconds of simulation as cocotb counts them.
"""

import sys
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
sys.path[:0] = [str(ROOT / "python/examples/cocotb"), str(HERE)]

import run  # noqa: E402

import goldtof  # noqa: E402

VARIANTS = {"without": ("free_of_it", {"WITHOUT_RECORDER": 1}), "with": ("test_sensor", {})}


def main(simulator, clocks="100000", rounds="5"):
    scene = ROOT / "scenes/quick.toml"
    with tempfile.TemporaryDirectory() as name:
        files = goldtof.emit(goldtof.Scene.load(scene), f"{name}/rtl")["files"]
        sources = [Path(name) / "rtl" / file for file in files]
        best = dict.fromkeys(VARIANTS, float("inf"))
        for variant, (_, defines) in VARIANTS.items():
            (Path(name) / variant).mkdir()
            run.build(simulator, Path(name) / variant, sources, defines)
        for _ in range(int(rounds)):
            for variant, (module, _) in VARIANTS.items():
                folder = Path(name) / variant
                failed, log = run.run(simulator, folder, scene, module, CLOCKS=clocks)
                assert failed == 0, log
                case = ET.parse(folder / "results.xml").getroot().find(".//testcase")
                best[variant] = min(best[variant], float(case.get("time")))
    share = best["with"] / best["without"] - 1
    print(f"{simulator}, {clocks} clocks: {best['without']:.2f} s without, "
          f"{best['with']:.2f} s with: {100 * share:+.1f} %")


if __name__ == "__main__":
    main(*sys.argv[1:])
