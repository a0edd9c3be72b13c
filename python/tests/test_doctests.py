"""The examples in the documentation of every class and function."""

import doctest
from pathlib import Path

import goldtof
import goldtof._goldtof

QUICK = (Path(__file__).resolve().parents[2] / "scenes/quick.toml").read_text()


def test_examples_do_what_they_say():
    names = {name: getattr(goldtof, name) for name in goldtof.__all__} | {"QUICK": QUICK}
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    runner = doctest.DocTestRunner(optionflags=flags)
    tried = 0
    for name in [None, *goldtof.__all__]:
        what = goldtof if name is None else getattr(goldtof, name)
        text = getattr(what, "__doc__", None) or ""
        if ">>>" in text:
            test = doctest.DocTestParser().get_doctest(text, dict(names), name or "goldtof", None, 0)
            runner.run(test)
            tried += 1
    assert tried >= 6
    assert runner.failures == 0, f"{runner.failures} examples"


def test_stubs_name_everything_that_there_is():
    import ast

    stub = ast.parse(Path(goldtof.__file__).with_name("_goldtof.pyi").read_text())
    told = {node.name: node for node in stub.body if hasattr(node, "name")}
    for name in dir(goldtof._goldtof):
        thing = getattr(goldtof._goldtof, name)
        if name.startswith("_") or not callable(thing):
            continue
        assert name in told, name
        if isinstance(thing, type) and not issubclass(thing, Exception):
            members = {member.name for member in told[name].body}
            public = {m for m in vars(thing) if not m.startswith("_") and m != "doc"}
            assert public <= members, public - members
