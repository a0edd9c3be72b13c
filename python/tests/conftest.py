"""What all tests have: the standard scenes."""

from pathlib import Path

import goldtof
import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def quick() -> goldtof.Scene:
    return goldtof.Scene.load(ROOT / "scenes/quick.toml")
