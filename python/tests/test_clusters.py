"""The recipes of examples/cluster, on one machine, with a worker killed on the way: what is
merged is what one run says."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from conftest import ROOT

RECIPES = ROOT / "examples/cluster"
# Six points of some tenths of a second.
SWEEP = [
    "sweep",
    "scenes/quick.toml",
    "--over",
    "path.distance=2 m..7 m +6",
    "--repeat",
    "150",
]


@pytest.fixture(scope="module")
def environment():
    """With goldtof and Python's tools in the path."""
    programs = [Path(os.environ["GOLDTOF"]).parent, Path(sys.executable).parent]
    path = os.pathsep.join([*map(str, programs), os.environ["PATH"]])
    return os.environ | {"PATH": path}


@pytest.fixture(scope="module")
def whole(tmp_path_factory, environment):
    """Bytes of the table that one run makes."""
    out = tmp_path_factory.mktemp("whole")
    words = ["goldtof", *SWEEP, "--quiet", "--out", out]
    subprocess.run(words, cwd=ROOT, env=environment, check=True)
    return (out / "sweep.csv").read_bytes()


def one_that_writes_to(out):
    """A process of goldtof's with this folder on its command line, as soon as there is one,
    and its parent."""
    for _ in range(6000):
        for entry in Path("/proc").glob("[0-9]*"):
            try:
                words = (entry / "cmdline").read_bytes().split(b"\0")
                status = (entry / "status").read_text()
            except OSError:
                continue
            if words[0].endswith(b"goldtof") and os.fsencode(out) in words:
                return int(entry.name), int(re.search(r"PPid:\s*(\d+)", status)[1])
        time.sleep(0.005)
    raise AssertionError("nobody has started a goldtof")


def kill_one(out):
    os.kill(one_that_writes_to(out)[0], signal.SIGKILL)


def test_snakemake_goes_on_after_a_kill(tmp_path, environment, whole):
    out = tmp_path / "out"
    command = " ".join(f"'{word}'" if " " in word else word for word in SWEEP)
    config = ["--config", "shards=12", f"out={out}", f"command={command}"]
    snakemake = ["snakemake", "--cores", "2", "--snakefile", RECIPES / "Snakefile"]
    quiet = ["--quiet", "all", "--directory", ROOT, "--nolock"]
    words = [*snakemake, *quiet, *config]
    cut = subprocess.Popen(words, env=environment, stderr=subprocess.DEVNULL)
    kill_one(out)
    assert cut.wait() != 0
    before = {path: path.stat().st_mtime_ns for path in (out / "shards").glob("*.json")}
    assert len(before) < 12
    subprocess.run([*words, "--rerun-incomplete"], env=environment, check=True)
    assert len(list((out / "shards").glob("*.json"))) == 12
    assert all(path.stat().st_mtime_ns == made for path, made in before.items())
    assert (out / "sweep.csv").read_bytes() == whole
    assert json.loads((out / "merged.json").read_text())["document"] == "sweep"


def test_dask_starts_a_lost_worker_again(tmp_path, environment, whole, monkeypatch):
    import distributed

    monkeypatch.syspath_prepend(RECIPES)
    monkeypatch.chdir(ROOT)
    monkeypatch.setenv("PATH", environment["PATH"])
    import dask_shards

    local = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    out = tmp_path / "out"
    with distributed.LocalCluster(**local) as cluster, distributed.Client(cluster) as client:

        def lose_a_worker():
            for pid in reversed(one_that_writes_to(out)):
                os.kill(pid, signal.SIGKILL)

        with ThreadPoolExecutor() as beside:
            lost = beside.submit(lose_a_worker)
            document = dask_shards.run(client, SWEEP, str(out), 12)
            lost.result()
    assert document["document"] == "sweep" and document["points"] == 6
    assert (out / "sweep.csv").read_bytes() == whole


@pytest.mark.skipif(os.geteuid() != 0, reason="a Slurm of one's own needs root")
def test_slurm_runs_an_array_and_what_was_lost_once_more(tmp_path, environment, whole):
    node, out = tmp_path / "slurm", tmp_path / "out"
    subprocess.run([ROOT / "scripts/slurm-node", "start", node], check=True)
    try:
        environment = environment | {"SLURM_CONF": str(node / "slurm.conf")}
        script = [RECIPES / "slurm.sh", *SWEEP, "--out", out]
        options = ["--wait", "--chdir", ROOT, f"--output={tmp_path}/%a.log"]
        sbatch = ["sbatch", "--quiet", *options]
        cut = subprocess.Popen([*sbatch, "--array=1-6", *script], env=environment)
        kill_one(out)
        assert cut.wait() != 0
        told = subprocess.run(
            ["goldtof", "merge", "--missing", out], env=environment, capture_output=True, text=True
        )
        missing = told.stdout.strip()
        assert re.fullmatch(r"[1-6]", missing), (missing, told.stderr)
        again = environment | {"SHARDS": "6"}
        subprocess.run([*sbatch, f"--array={missing}", *script], env=again, check=True)
    finally:
        subprocess.run([ROOT / "scripts/slurm-node", "stop", node], check=True)
    subprocess.run(["goldtof", "merge", out, "--quiet"], env=environment, check=True)
    assert (out / "sweep.csv").read_bytes() == whole
