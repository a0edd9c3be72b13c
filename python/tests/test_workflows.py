"""The workflow files of ci/, their steps run in a fresh clone of a repository that has
nothing but a scene and somebody's Verilog."""

import json
import os
import shutil
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
import yaml
from conftest import ROOT


def of_github():
    """The environment, and the steps that are goldtof's."""
    workflow = yaml.safe_load((ROOT / "ci/github.yml").read_text())
    steps = workflow["jobs"]["cosim"]["steps"]
    commands = [step["run"] for step in steps if step.get("run", "").startswith("goldtof ")]
    assert len(commands) == 2
    return workflow["env"], commands


def of_gitlab():
    job = yaml.safe_load((ROOT / "ci/gitlab.yml").read_text())["cosim"]
    return job["variables"], ["\n".join(job["script"])]


@pytest.fixture
def clone(tmp_path):
    """A fresh clone of a repository with a scene and the hand-written sensor."""
    theirs = tmp_path / "theirs"
    shutil.copytree(ROOT / "examples/own-rtl", theirs)
    shutil.copy(ROOT / "scenes/quick.toml", theirs / "sensor.toml")
    author = ["-c", "user.name=They", "-c", "user.email=they@example.org"]
    for command in (
        ["git", "init", "--quiet", theirs],
        ["git", "-C", theirs, "add", "."],
        ["git", "-C", theirs, *author, "commit", "--quiet", "--message", "A sensor"],
        ["git", "clone", "--quiet", theirs, tmp_path / "clone"],
    ):
        subprocess.run(command, check=True)
    return tmp_path / "clone"


def run(clone, variables, commands):
    """The statuses of all commands."""
    programs = str(Path(os.environ["GOLDTOF"]).parent)
    environment = os.environ | variables | {"PATH": f"{programs}:{os.environ['PATH']}"}
    return [
        subprocess.run(["bash", "-e", "-c", command], cwd=clone, env=environment).returncode
        for command in commands
    ]


def test_their_design_matches_in_the_steps_for_github(clone):
    variables, commands = of_github()
    assert run(clone, variables, commands) == [0, 0]
    for name in ("photons", "hostile"):
        assert json.loads((clone / f"{name}.json").read_text())["verdict"] == "match"
        report = ET.parse(clone / f"{name}.xml").getroot()
        assert report.findall(".//testcase") and not report.findall(".//failure")
    assert list((clone / ".goldtof-cache").iterdir())


def test_a_fault_of_theirs_fails_the_script_for_gitlab(clone):
    port = clone / "rtl/stream_port.sv"
    text = port.read_text()
    assert text.count("tlast  <= put_last;") == 1
    port.write_text(text.replace("tlast  <= put_last;", "tlast  <= '0;"))
    variables, commands = of_gitlab()
    assert run(clone, variables, commands) == [1]
    for name in ("photons", "hostile"):
        told = json.loads((clone / f"{name}.json").read_text())
        assert told["verdict"] == "mismatch" and told["first_mismatch"]["port"] == "m_axis_tlast"
        assert ET.parse(clone / f"{name}.xml").getroot().findall(".//failure")


def test_both_forms_run_the_same():
    (variables, commands), (others, scripts) = of_github(), of_gitlab()
    assert variables == others
    script = [line.removesuffix(" || status=$?") for line in scripts[0].splitlines()]
    assert [line for line in script if line.startswith("goldtof ")] == commands
