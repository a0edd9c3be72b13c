"""A command of goldtof's in shards, each a task of Dask's, and what they say together.

    python dask_shards.py --shards 20 --out out/sweep -- sweep SCENE --over KEY=VALUES

Without ``--scheduler`` the workers are processes of this machine. The folder has to be one
that all workers see.
"""

import argparse
import json
import os
import subprocess
from pathlib import Path

from distributed import Client, LocalCluster


def shard(number, of, command, out):
    """Does a shard, in a process of its own: a worker that is lost loses no more than that."""
    words = ["goldtof", *command, "--quiet", "--out", out, "--shard", f"{number}/{of}"]
    threads = {"RAYON_NUM_THREADS": "1"}
    ran = subprocess.run(words, env=os.environ | threads, capture_output=True, text=True)
    if ran.returncode != 0:
        raise RuntimeError(f"shard {number}/{of}: {ran.stderr.strip()}")
    return number


def run(client, command, out, of):
    """All shards of a command on a cluster; the document of `goldtof merge`."""
    # Shards have files for results: one that Dask starts again is done already, or is
    # done again with the same numbers.
    tasks = client.map(shard, range(1, of + 1), of=of, command=command, out=out, pure=False)
    client.gather(tasks)
    merged = subprocess.run(["goldtof", "merge", out, "--json"], stdout=subprocess.PIPE)
    document = json.loads(merged.stdout)
    if "error" in document:
        raise RuntimeError(document["error"]["text"])
    return document


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--shards", type=int, required=True, help="how many")
    parser.add_argument("--out", required=True, help="folder of the shards")
    parser.add_argument("--scheduler", help="address, tcp://HOST:8786")
    parser.add_argument("command", nargs="+", help="the command, without --out and --shard")
    arguments = parser.parse_args()
    local = {"threads_per_worker": 1, "dashboard_address": None}
    cluster = arguments.scheduler or LocalCluster(**local)
    with Client(cluster) as client:
        out = str(Path(arguments.out).absolute())
        print(json.dumps(run(client, arguments.command, out, arguments.shards), indent=2))


if __name__ == "__main__":
    main()
