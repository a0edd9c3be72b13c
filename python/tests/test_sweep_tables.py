"""The tables of `goldtof sweep`: pandas has the same from Parquet as from CSV."""

import csv
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
    assert types["expectation_holds"] == pa.bool_()
    assert b"goldtof" in table.schema.metadata
    told = pd.read_parquet(out / "sweep.parquet").attrs
    assert told["units"]["path[0].velocity (m/s)"] == "m/s"
    assert told["units"]["std_m"] == "m" and "clock.samples_per_chip" not in told["units"]
    assert told["sweep"]["over"][0] == "path[0].velocity=0 m/s, 100 m/s"
    assert told["scene"]["settings"] == ["scan.integration=10 us"]


# From what is in a field of the CSV to what Parquet has; nothing is null.
AS_PARQUET = {"int64": int, "double": float, "string": str, "bool": lambda text: {"true": True, "false": False}[text]}


def assert_same_fields(folder):
    """Every field of the CSV, read as text, is that of the Parquet file, read by pyarrow."""
    import pyarrow.parquet as pq

    with open(folder / "sweep.csv", newline="", encoding="utf-8") as file:
        heading, *rows = csv.reader(file)
    table = pq.read_table(folder / "sweep.parquet")
    assert table.column_names == heading and table.num_rows == len(rows) > 0
    for field, column, texts in zip(table.schema, table.columns, zip(*rows), strict=True):
        of_csv = [AS_PARQUET[str(field.type)](text) if text else None for text in texts]
        assert column.to_pylist() == of_csv, field.name
    return table


def test_every_field_is_that_of_the_csv_and_null_where_it_has_none(out):
    table = assert_same_fields(out)
    row = table.to_pylist()[2]
    assert row["remark"] and row["mean_distance_m"] is None and row["detector"] is None
    assert table.to_pylist()[0]["remark"] is None


def test_a_sweep_of_refused_points_has_all_columns_and_their_types(out, tmp_path):
    import pyarrow.parquet as pq

    moving = ["path[0].velocity=100 m/s, 200 m/s" if "velocity" in word else word for word in SWEEP]
    goldtof(*moving, "--out", tmp_path)
    table = assert_same_fields(tmp_path)
    assert table.schema.equals(pq.read_schema(out / "sweep.parquet"))
    assert table["remark"].null_count == 0 and table["std_m"].null_count == table.num_rows


SECOND_DETECTOR = """
[[detector]]
name = 'far, "left" ä'
reference = "laser"
dead_time = "10 ns"

[[path]]
source = "laser"
detector = 'far, "left" ä'
distance = "4 m"
"""


def test_texts_with_commas_and_quotes_and_numbers_below_zero_come_back_whole(tmp_path):
    import pyarrow as pa

    scene = tmp_path / "two.toml"
    scene.write_text((ROOT / "scenes/quick.toml").read_text() + SECOND_DETECTOR, encoding="utf-8")
    codes = '{ family = "gold", degree = 5 }, { family = "m-sequence", degree = 5 }'
    axes = ["source.mean_power=-80 dBm..-70 dBm +2", f"source.code={codes}"]
    over = [word for axis in axes for word in ["--over", axis]]
    goldtof("sweep", scene, "--fidelity", "expected", *over, "--out", tmp_path)
    table = assert_same_fields(tmp_path)
    assert table["source.mean_power (dBm)"].to_pylist()[0] == -80.0
    assert table["source.code"].type == pa.string()
    assert set(table["detector"].to_pylist()) == {"spad", 'far, "left" ä'}
    assert set(table["source.code"].to_pylist()) == set(codes.replace("}, {", "}|{").split("|"))


def test_a_sweep_that_goes_on_ends_with_the_same_parquet_file(out, tmp_path):
    goldtof(*SWEEP, "--out", tmp_path)
    log = tmp_path / "points.log"
    log.write_bytes(log.read_bytes().split(b"\n", 1)[1])
    (tmp_path / "sweep.parquet").unlink()
    goldtof(*SWEEP, "--out", tmp_path)
    assert (tmp_path / "sweep.parquet").read_bytes() == (out / "sweep.parquet").read_bytes()


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
