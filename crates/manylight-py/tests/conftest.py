"""Scenes of the project."""

from pathlib import Path

import pytest

import manylight as ml

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def scenes() -> Path:
    return ROOT / "scenes"


@pytest.fixture(scope="session")
def room(scenes: Path) -> ml.Scene:
    return ml.load_file(scenes / "glossy-room" / "scene.xml")


SMALL = {"method": "rich-vpl", "size": (32, 18), "passes": 2, "lights": 256, "photons": 4000}


@pytest.fixture
def small() -> dict:
    return dict(SMALL)
