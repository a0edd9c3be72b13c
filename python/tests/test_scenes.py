"""Scenes from files, texts and dicts, and what is set in them."""

import copy
import tomllib

import goldtof
import pytest
from conftest import ROOT


def test_a_scene_is_the_same_from_file_text_and_dict(quick):
    text = (ROOT / "scenes/quick.toml").read_text()
    of_text = goldtof.Scene.parse(text, "quick.toml")
    of_dict = goldtof.Scene.from_dict(tomllib.loads(text), "quick.toml")
    for scene in (quick, of_text, of_dict):
        assert (scene.name, scene.phase_steps) == ("quick", 248)
        assert scene.chip_period_s == pytest.approx(8e-9)
        assert scene.integration_s == pytest.approx(20e-6)
        assert scene.path_distances_m == [pytest.approx(3.2)]
        assert scene.ports[:3] == [("i_rst", 1), ("o_laser", 1), ("o_epoch", 1)]


def test_keys_are_set_in_place_or_not_at_all(quick):
    kept = quick.copy()
    quick["path.distance"] = "5 m"
    quick["clock.samples_per_chip"] = 4
    with pytest.raises(goldtof.SceneError, match="5 kg"):
        quick["path.distance"] = "5 kg"
    with pytest.raises(goldtof.SceneError, match="length"):
        quick["path.length"] = "5 m"
    with pytest.raises(ValueError, match="no set"):
        quick["scan.steps"] = {1, 2}
    assert quick.path_distances_m == [5.0]
    assert quick.phase_steps == 124
    assert len(quick.settings) == 2
    assert copy.deepcopy(quick).path_distances_m == [5.0]
    assert kept.path_distances_m == [pytest.approx(3.2)] and kept.settings == []


def test_errors_have_file_line_and_column(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("clock.chip_period = 8\n")
    with pytest.raises(goldtof.SceneError, match=r"mine.toml:1:21: .* has no unit") as caught:
        goldtof.Scene.load(path)
    places = [place for place in caught.value.places if "8 has no unit" in place["message"]]
    assert [(place["file"], place["line"], place["column"]) for place in places] == [
        (str(path), 1, 21)
    ]
    with pytest.raises(goldtof.SceneError, match="cannot read the scene"):
        goldtof.Scene.load(tmp_path / "nothing.toml")
    with pytest.raises(ValueError, match="clock.chip_period: a scene has no bytes"):
        goldtof.Scene.from_dict({"clock": {"chip_period": b"8 ns"}})


def test_values_within_values_have_an_end(quick):
    endless = []
    endless.append(endless)
    deep = {}
    for _ in range(10_000):
        deep = {"a": deep}
    for value in (endless, deep):
        with pytest.raises(ValueError, match="more than 16 lists and dicts within each other"):
            quick["scan.steps"] = value
        with pytest.raises(ValueError, match="more than 16 lists and dicts within each other"):
            goldtof.Scene.from_dict({"scan": value})
    with pytest.raises(ValueError, match="a key of more than 16 parts"):
        quick["a" + ".a" * 30_000] = 1
    assert quick.phase_steps == 248
