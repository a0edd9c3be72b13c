"""Counts come in many shapes, and estimates go out as what people work with."""

import pickle

import goldtof
import numpy as np
import pandas as pd
import pytest


@pytest.fixture
def counted(quick):
    return goldtof.scans(quick, fidelity="counts", repetitions=4, seed=2)


def test_whatever_holds_the_counts_gives_the_same(quick, counted, tmp_path):
    signed, total = counted["signed"][0], counted["total"][0]
    right = goldtof.estimate(quick, signed, total=total)
    frame = pd.DataFrame({"phase_step": range(248), "count": signed, "total_count": total})
    frame.to_csv(tmp_path / "counts.csv", index=False)
    given = [
        ((signed.astype(np.int32),), {"total": total.astype(np.int16)}),
        ((signed.tolist(),), {"total": total.tolist()}),
        ((pd.Series(signed),), {"total": pd.Series(total, dtype=float)}),
        ((frame,), {}),
        ((tmp_path / "counts.csv",), {}),
        ((str(tmp_path / "counts.csv"),), {}),
    ]
    for arguments, keywords in given:
        told = goldtof.estimate(quick, *arguments, **keywords)
        assert told.distance_m == right.distance_m and told.chi_square == right.chi_square
    alone = goldtof.estimate(quick, frame[["phase_step", "count"]])
    assert alone.phase_steps.total_residual_in_std.size in (0, 248)
    assert np.isnan(alone.phase_steps.total_residual_in_std).all()


def test_scans_are_what_estimates_read(quick):
    counts = goldtof.scans(quick, repetitions=20, seed=3)
    told = goldtof.estimate(quick, counts["signed"], total=counts["total"], estimator="model")
    error_m = told.distance_m.mean() - quick.path_distances_m[0]
    # About 10 mm each; counts of the tier events would be 205 mm nearer.
    assert abs(error_m) < 5 * told.distance_m.std(ddof=1) / np.sqrt(20)


def test_many_scans_are_one_call(quick, counted):
    told = goldtof.estimate(quick, counted["signed"], total=counted["total"], estimator="model")
    assert isinstance(told, goldtof.Estimates) and len(told) == 4
    one_by_one = [
        goldtof.estimate(quick, signed, total=total, estimator="model").distance_m
        for signed, total in zip(counted["signed"], counted["total"])
    ]
    assert told.distance_m.tolist() == one_by_one
    frame = told.to_pandas()
    assert frame["distance_m"].tolist() == one_by_one and frame.index.name == "scan"
    assert isinstance(told[1:], goldtof.Estimates)
    with pytest.raises(ValueError, match="counts of 4 scans, and totals of 3"):
        goldtof.estimate(quick, counted["signed"], total=counted["total"][1:])
    counted["total"][2, 7] += 1
    with pytest.raises(ValueError, match="scan 2: phase step 7: .* both even or both odd"):
        goldtof.estimate(quick, counted["signed"], total=counted["total"])


def test_what_is_no_count_is_named(quick, counted, tmp_path):
    signed, total = counted["signed"][0], counted["total"][0].astype(np.int64)
    half = signed.astype(float)
    half[5] += 0.5
    for values, told in [(half, r"counts\[5\] is .*\.5"), (["many"] * 248, "counts are whole numbers")]:
        with pytest.raises(ValueError, match=told):
            goldtof.estimate(quick, values)
    half[5] = np.nan
    with pytest.raises(ValueError, match=r"counts\[5\] is nan"):
        goldtof.estimate(quick, half)
    total[3] = -2
    with pytest.raises(ValueError, match=r"total\[3\] is -2"):
        goldtof.estimate(quick, signed, total=total)
    with pytest.raises(ValueError, match="of one dimension"):
        goldtof.estimate(quick, counted["signed"], total=counted["total"][0])
    with pytest.raises(ValueError, match="a column 'count'; this one has phase_step"):
        goldtof.estimate(quick, pd.DataFrame({"phase_step": [1]}))
    with pytest.raises(goldtof.GoldtofError, match="nowhere.csv"):
        goldtof.estimate(quick, tmp_path / "nowhere.csv")
    with pytest.raises(ValueError, match="give it alone"):
        goldtof.estimate(quick, "counts.csv", total=total)


def test_reports_have_attributes_and_become_tables_and_plots(quick, counted):
    told = goldtof.estimate(quick, counted["signed"][0], total=counted["total"][0])
    assert told.estimate.distance_m == told["estimate"]["distance_m"] == told.distance_m
    with pytest.raises(AttributeError, match="no 'distanse' in the report"):
        told.distanse  # noqa: B018
    assert type(told.to_dict()["estimate"]) is dict
    assert pickle.loads(pickle.dumps(told)).distance_m == told.distance_m
    frame = told.to_pandas()
    assert frame["count"].tolist() == counted["signed"][0].tolist()
    import matplotlib

    matplotlib.use("Agg")
    of_counts, of_residuals = told.plot()
    assert of_counts.get_title() == f"spad: {told.distance_m:.4f} m"
    drawn = of_residuals.get_lines()[-1].get_ydata()
    assert np.allclose(drawn, told.phase_steps.residual_in_std)
