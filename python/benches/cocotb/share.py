"""What the scoreboard takes of a cocotb simulation: the example's testbench, with
recorder and scoreboard and without either, in turns.

    python python/benches/cocotb/share.py icarus|verilator [CLOCKS] [ROUNDS]

Prints the shortest processor times of both.
"""

import re
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
sys.path[:0] = [str(ROOT / "python/examples/cocotb"), str(HERE)]

import run  # noqa: E402

import goldtof  # noqa: E402

# Macros of the build, and the environment of the run.
VARIANTS = {
    "without": ({"WITHOUT_RECORDER": 1}, {}),
    "with": ({}, {"WITH_SCOREBOARD": "1"}),
}


def main(simulator, clocks="100000", rounds="5"):
    scene = ROOT / "scenes/quick.toml"
    with tempfile.TemporaryDirectory() as name:
        files = goldtof.emit(goldtof.Scene.load(scene), f"{name}/rtl")["files"]
        sources = [Path(name) / "rtl" / file for file in files]
        best = dict.fromkeys(VARIANTS, float("inf"))
        for variant, (defines, _) in VARIANTS.items():
            (Path(name) / variant).mkdir()
            run.build(simulator, Path(name) / variant, sources, defines)
        for _ in range(int(rounds)):
            for variant, (_, environment) in VARIANTS.items():
                folder = Path(name) / variant
                failed, log = run.run(simulator, folder, scene, "timed", CLOCKS=clocks, **environment)
                assert failed == 0, log
                took_s = float(re.search(r"took ([\d.]+) s", log)[1])
                best[variant] = min(best[variant], took_s)
    share = best["with"] / best["without"] - 1
    print(f"{simulator}, {clocks} clocks: {best['without']:.2f} s without, "
          f"{best['with']:.2f} s with: {100 * share:+.1f} %")


if __name__ == "__main__":
    main(*sys.argv[1:])
