"""The examples in the documentation of every class and function."""

import doctest
import os
import subprocess
import sys
from pathlib import Path

import goldtof

ROOT = Path(__file__).resolve().parents[2]
QUICK = (ROOT / "scenes/quick.toml").read_text()


def test_examples_do_what_they_say():
    names = {name: getattr(goldtof, name) for name in goldtof.__all__} | {"QUICK": QUICK}
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    runner = doctest.DocTestRunner(optionflags=flags)
    tried = 0
    for name in [None, *goldtof.__all__]:
        what = goldtof if name is None else getattr(goldtof, name)
        text = getattr(what, "__doc__", None) or ""
        if ">>>" in text:
            test = doctest.DocTestParser().get_doctest(text, dict(names), name or "goldtof", None, 0)
            runner.run(test)
            tried += 1
    assert tried >= 6
    assert runner.failures == 0, f"{runner.failures} examples"


def test_stubs_are_those_of_the_library(tmp_path):
    # What other packages' types are is mypy's, below.
    rules = tmp_path / "mypy.ini"
    rules.write_text("[mypy]\nfollow_imports = skip\n")
    ran = subprocess.run(
        [sys.executable, "-P", "-m", "mypy.stubtest", "--mypy-config-file", rules, "goldtof._goldtof"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    # A module that it does not find is none of its failures.
    assert "no issues found in 1 module" in ran.stdout, ran.stdout + ran.stderr


def test_types_are_whole(tmp_path):
    """The package itself, and a user's lines, under the strictest rules of mypy."""
    lines = tmp_path / "lines.py"
    lines.write_text(
        "import goldtof\nimport numpy as np\n"
        "scene = goldtof.Scene.load('quick.toml')\n"
        "scene['path.distance'] = 5.0\n"
        "counts = goldtof.scans(scene, fidelity='sampled')['signed']\n"
        "distance = goldtof.estimate(scene, counts).distance_m\n"
        "data = goldtof.sweep(scene, {'path.distance': np.linspace(1, 3, 3)}, to='xarray')\n"
        "units: str = data['bias_m'].attrs['units']\n"
    )
    # Neither the package nor an example names these: what uses them is in other packages' files.
    rules = tmp_path / "mypy.ini"
    rules.write_text(
        "[mypy]\nstrict = True\nignore_missing_imports = True\n"
        "[mypy-PIL.*,_pytest.*,dask.*,distributed.*,jinja2.*,tornado.*,traitlets.*]\n"
        "follow_imports = skip\n"
    )
    examples = ROOT / "python/examples"
    modules = ["lines", *(path.stem for path in examples.glob("*.py"))]
    ran = subprocess.run(
        [sys.executable, "-P", "-m", "mypy", "--config-file", rules, "-p", "goldtof",
         *(f"--module={name}" for name in modules)],
        cwd=tmp_path,
        env=os.environ | {"MYPYPATH": str(examples)},
        capture_output=True,
        text=True,
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
