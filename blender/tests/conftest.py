# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of the add-on against Cycles. They need Blender as a Python module (`bpy`), `manylight` and `OpenEXR`."""

import importlib.util
import os
import sys

import pytest

FOLDER = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [FOLDER, os.path.dirname(FOLDER)]
NEEDED = ("bpy", "manylight", "OpenEXR", "numpy")
MISSING = [name for name in NEEDED if importlib.util.find_spec(name) is None]
# Without Blender, its modules cannot even be imported.
collect_ignore_glob = ["test_*.py"] if MISSING else []


def pytest_report_header(config):
    return [f"skipped: the tests of the Blender add-on need {', '.join(MISSING)}"] if MISSING else []


def pytest_sessionfinish(session, exitstatus):
    if MISSING and exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED:
        session.exitstatus = pytest.ExitCode.OK


@pytest.fixture(scope="session", autouse=True)
def engine():
    """The add-on, registered."""
    import manylight_render

    manylight_render.register()
    yield
    manylight_render.unregister()
