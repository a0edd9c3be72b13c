"""The tables of `goldtof sweep`: pandas has the same from Parquet as from CSV."""

import doctest
import os
import re
import subprocess

import pandas as pd
import pytest
from conftest import ROOT

# Numbers with and without a unit, texts, and a point that the tier cannot do.
SWEEP = [
    "sweep",
    "scenes/quick.toml",
    "--fidelity",
    "counts",
    "--repeat",
    "5",
    "--set",
    "scan.integration=10 us",
    "--over",
    "path[0].velocity=0 m/s, 100 m/s",
    "--over",
    "clock.samples_per_chip=4",
    "--over",
    "estimate.estimator=fft, model",
]


def goldtof(*words):
    command = [os.environ["GOLDTOF"], *words, "--quiet"]
    subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweep")
    goldtof(*SWEEP, "--out", folder)
    return folder


def test_parquet_has_the_values_of_the_csv(out):
    of_csv = pd.read_csv(out / "sweep.csv", float_precision="round_trip")
    of_parquet = pd.read_parquet(out / "sweep.parquet")
    assert len(of_parquet) == 4 and of_parquet["remark"].notna().any()
    pd.testing.assert_frame_equal(of_parquet, of_csv, check_exact=True, check_dtype=False)
    some = pd.read_parquet(out / "sweep.parquet", columns=["path[0].velocity (m/s)", "std_m"])
    pd.testing.assert_frame_equal(some, of_parquet[list(some.columns)])


def test_parquet_has_types_units_and_what_it_is_of(out):
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pq.read_table(out / "sweep.parquet")
    types = {field.name: field.type for field in table.schema}
    assert types["point"] == types["path"] == types["estimates"] == pa.int64()
    assert types["path[0].velocity (m/s)"] == types["bias_m"] == pa.float64()
    assert types["estimate.estimator"] == types["remark"] == pa.string()
    assert b"goldtof" in table.schema.metadata
    told = pd.read_parquet(out / "sweep.parquet").attrs
    assert told["units"]["path[0].velocity (m/s)"] == "m/s"
    assert told["units"]["std_m"] == "m" and "clock.samples_per_chip" not in told["units"]
    assert told["sweep"]["over"][0] == "path[0].velocity=0 m/s, 100 m/s"
    assert told["scene"]["settings"] == ["scan.integration=10 us"]


def test_shards_join_to_the_same_parquet_file(out, tmp_path):
    for shard in ["1/3", "2/3", "3/3"]:
        goldtof(*SWEEP, "--out", tmp_path, "--shard", shard)
    goldtof("merge", tmp_path)
    joined = (tmp_path / "sweep.parquet").read_bytes()
    assert joined == (out / "sweep.parquet").read_bytes()


def test_the_snippet_in_the_guide_does_what_it_says(out, tmp_path, monkeypatch):
    (tmp_path / "out").mkdir()
    (tmp_path / "out/sweep").symlink_to(out)
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "docs/sweeps.md").read_text()
    (snippet,) = re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    test = doctest.DocTestParser().get_doctest(snippet, {}, "sweeps.md", None, 0)
    result = doctest.DocTestRunner().run(test)
    assert result.attempted == 3 and result.failed == 0
