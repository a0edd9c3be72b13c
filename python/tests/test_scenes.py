"""Scenes from files, texts and dicts, and what is set in them."""

import copy
import pickle
import tomllib
import xml.dom.minidom

import goldtof
import numpy as np
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


def test_scenes_are_pickled_compared_and_hashed_by_what_they_say(quick):
    quick["path.distance"] = "5 m"
    quick["source.code"] = {"family": "gold", "degree": 5, "index": 3}
    twin = pickle.loads(pickle.dumps(quick))
    assert twin == quick and hash(twin) == hash(quick) and twin.settings == quick.settings
    assert len({quick, twin}) == 1
    twin["path.distance"] = "500 cm"
    assert twin == quick
    twin["path.distance"] = "5.001 m"
    assert twin != quick and quick != "quick"


def test_keys_are_read_as_numbers_in_si_units(quick):
    assert quick["clock.chip_period"] == 8e-9
    assert quick["detector.jitter"] == [53.5e-12, 4e-12]
    assert quick["source.extinction_ratio"] == 10.0 and quick["source.rise_time"] == 0.0
    assert quick["source.name"] == "laser" and quick["source.impulse_response"] is None
    assert quick.about("detector.dark_count_rate")["unit"] == "s-1"
    for key in ["clock.chip_period", "detector.jitter", "source.mean_power", "source.clock_offset"]:
        twin = quick.copy()
        twin[key] = quick[key]
        assert twin == quick, key
    quick["path.distance"] = np.float32(2.5)
    assert quick.path_distances_m == [2.5]
    with pytest.raises(KeyError, match="did you mean `distance`"):
        quick["path.distanse"]


def test_a_scene_shows_itself_in_a_notebook(quick):
    html = goldtof.Scene.parse(quick.text.replace('"laser"', '"<laser>"'))._repr_html_()
    assert "&lt;laser&gt; to spad, 3.2 m" in html and "<laser>" not in html
    assert xml.dom.minidom.parseString(html)
