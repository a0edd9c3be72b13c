"""docs/python.md says what happens."""

import doctest
import re

from conftest import ROOT


def test_snippets_do_what_they_say(tmp_path, monkeypatch):
    for name in ("scenes", "examples"):
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "docs/python.md").read_text()
    snippets = re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    names = {}
    for snippet in snippets:
        test = doctest.DocTestParser().get_doctest(snippet, names, "python.md", None, 0)
        # They follow on each other.
        runner.run(test, clear_globs=False)
        names = test.globs
    assert runner.tries > 20
    assert runner.failures == 0, f"{runner.failures} examples"


def test_what_it_names_is_there():
    import goldtof

    text = (ROOT / "docs/python.md").read_text()
    table = re.findall(r"^\| (`.*?) \|", text, re.MULTILINE)
    named = {name for row in table for name in re.findall(r"`(\w+)\(", row)}
    assert named == {name for name in goldtof.__all__ if callable(getattr(goldtof, name))} - {
        *("GoldtofError", "SceneError", "ToolError", "Scene", "Scoreboard"),
        *("Report", "Estimate", "Estimates"),
    }
