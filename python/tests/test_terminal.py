"""What the program shows on a terminal, and what not elsewhere."""

import os
import pty
import re
import subprocess

import pytest
from conftest import ROOT

PROGRAM = os.environ["GOLDTOF"]
NO_SCENE = ["plan", "nothing.toml"]
SWEEP = ["sweep", "scenes/quick.toml", "--repeat", "2", "--over", "path.distance=2 m..9 m +8"]


def on_terminal(*words, **environment):
    """What appears on a terminal."""
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [PROGRAM, *map(str, words)],
        cwd=ROOT,
        env=os.environ | {"TERM": "xterm", "NO_COLOR": ""} | environment,
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
    )
    os.close(theirs)
    shown = b""
    try:
        while part := os.read(ours, 65536):
            shown += part
    except OSError:
        # The other end has been closed.
        pass
    process.wait()
    os.close(ours)
    return shown.decode()


def test_errors_are_coloured_where_somebody_sees_it():
    assert on_terminal(*NO_SCENE).startswith("\x1b[1m\x1b[31merror:\x1b[0m nothing.toml")


@pytest.mark.parametrize("environment", [{"NO_COLOR": "1"}, {"TERM": "dumb"}, {"TERM": "dumb", "CI": "true"}])
def test_errors_have_no_colour_for_those_who_want_none(environment):
    assert on_terminal(*NO_SCENE, **environment).startswith("error: nothing.toml")
    # Usage errors are clap's.
    assert on_terminal("plam", **environment).startswith("error: ")


def test_elsewhere_there_are_neither_colours_nor_bars(tmp_path):
    told = subprocess.run([PROGRAM, *NO_SCENE], cwd=ROOT, capture_output=True, text=True)
    assert told.stderr.startswith("error: nothing.toml")
    words = [PROGRAM, *SWEEP, "--out", tmp_path]
    told = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True)
    assert "\x1b" not in told.stdout + told.stderr and "points," not in told.stderr


def test_a_sweep_shows_how_far_it_is_and_leaves_only_its_answer(tmp_path):
    shown = on_terminal(*SWEEP, "--out", tmp_path)
    assert re.search(r"sweep \[=*>? *\] +\d+% \d of 8 points", shown), shown
    last = re.split(r"\x1b\[[0-9;]*K|\r", shown.rstrip())[-1]
    assert last.startswith("quick: 8 points, 8 rows in "), shown
