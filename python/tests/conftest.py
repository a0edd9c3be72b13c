"""What all tests have: the standard scenes, and what `scripts/test --thorough` alone runs."""

import os
from pathlib import Path

import goldtof
import pytest

ROOT = Path(__file__).resolve().parents[2]
of_a_release = pytest.mark.skipif("GOLDTOF_THOROUGH" not in os.environ, reason="of a release")


@pytest.fixture
def quick() -> goldtof.Scene:
    return goldtof.Scene.load(ROOT / "scenes/quick.toml")
