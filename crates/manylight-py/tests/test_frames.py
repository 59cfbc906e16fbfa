"""Walkthroughs: the pictures of the command, one by one, and on a cluster."""

import json
import subprocess
import sys

import numpy as np
import pytest

import manylight as ml
from manylight import _frames

SMALL = {"size": (16, 9), "passes": 2, "lights": 64, "photons": 4000, "max_depth": 4}


@pytest.fixture(scope="module")
def cameras(scenes):
    """The first of the cameras of the glossy room's walkthrough."""
    return np.array(json.loads((scenes / "glossy-room" / "walk.json").read_text())[:3])


def of_command(room, cameras, folder, *more):
    """The frames as the command renders them."""
    (folder / "walk.json").write_text(json.dumps(cameras.tolist()))
    words = ["--cameras", "walk.json", "--size=16x9", "--passes=2", "--max-depth=4", "-q", "-o", "####.exr", *more]
    subprocess.run([sys.executable, "-m", "manylight", "render", room.source, *words], check=True, cwd=folder)
    return [ml.read_image(folder / f"{frame:04}.exr") for frame in range(1, len(cameras) + 1)]


def same(images, expected):
    for image, other in zip(images, expected, strict=True):
        assert set(image.layers) == set(other.layers)
        assert all(np.array_equal(image.layers[name], other.layers[name]) for name in image.layers)


def test_frames_are_those_of_the_command(room, cameras, tmp_path):
    expected = of_command(room, cameras, tmp_path, "--lights=64", "--photons=4000")
    images = list(ml.frames(room, cameras=cameras, **SMALL))
    same(images, expected)
    same(ml.frames(room, cameras=tmp_path / "walk.json", frames=[3, 1], **SMALL), [expected[2], expected[0]])
    same([ml.render(room, cameras=cameras, frame=2, **SMALL)], [expected[1]])
    *_, last = room.passes(cameras=cameras, frame=2, **SMALL)
    same([last], [expected[1]])
    assert not np.array_equal(expected[0], expected[1])
    # The command of the metadata names no file that is gone.
    assert "command" not in images[0].metadata
    assert "--frames 2..2" in ml.render(room, cameras=tmp_path / "walk.json", frame=2, **SMALL).metadata["command"]
    # Without frames, the scene's own camera sees it again.
    assert not np.array_equal(ml.render(room, **SMALL), expected[0])


def test_lights_of_a_walkthrough_stay_if_a_file_is_named(room, cameras, tmp_path):
    first = list(ml.frames(room, cameras=cameras, lights_out=tmp_path / "walk.lights", **SMALL))
    same(ml.frames(room, cameras=cameras, lights_in=tmp_path / "walk.lights", **SMALL), first)
    with pytest.raises(ml.UsageError, match="lights 32: the lights of .*walk.lights were made with lights 64"):
        ml.render(room, lights_in=tmp_path / "walk.lights", **{**SMALL, "lights": 32})


@pytest.mark.parametrize("value", [None, False])
def test_lights_that_are_not_given_are_kept(room, cameras, monkeypatch, value):
    used = []

    def spied(scene, options, *more):
        used.append(options.get("lights_in"))
        return rendered(scene, options, *more)

    rendered = _frames.rendered
    monkeypatch.setattr(_frames, "rendered", spied)
    list(ml.frames(room, cameras=cameras, lights_in=value, **SMALL))
    assert not used[0] and used[1] and used[1:] == 2 * used[1:2]


def test_methods_without_lights_render_frames_alone(room, cameras, tmp_path):
    assert ml.keeps_lights("auto") and ml.keeps_lights("rich-vpl", lights=64)
    assert not any(ml.keeps_lights(method) for method in ("path", "photon-map", "rich-lightcuts"))
    options = {"size": (16, 9), "passes": 2, "max_depth": 4}
    same(ml.frames(room, "path", cameras=cameras, **options), of_command(room, cameras, tmp_path, "-m=path"))


def test_wrong_frames(room, cameras):
    for options, message in (
        ({"cameras": cameras}, "cameras: found no frame"),
        ({"cameras": cameras, "frame": 4}, "found 3 cameras"),
        ({"cameras": cameras[0], "frame": 1}, r"found an array \(4, 4\)"),
        ({"cameras": [["a"]], "frame": 1}, "found no array of numbers"),
        ({"frame": 1}, "stands still"),
        ({"cameras": np.zeros((1, 4, 4)), "frame": 1}, "camera"),
    ):
        with pytest.raises(ml.Error, match=message):
            ml.render(room, **options, **SMALL)
    with pytest.raises(ml.UsageError, match="stands still"):
        next(ml.frames(room, **SMALL))
    with pytest.raises(ml.FileError, match="cannot read the camera path"):
        next(ml.frames(room, cameras="missing.json", **SMALL))
    assert room.frame_counts == [0]


def test_frames_on_a_cluster(room, cameras, tmp_path):
    distributed = pytest.importorskip("distributed", reason="the package `distributed` is not installed")
    from manylight.distributed import render_frames

    expected = list(ml.frames(room, cameras=cameras, **SMALL))
    output = tmp_path / "walk-###.exr"
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=50) as cluster,
        distributed.Client(cluster) as client,
    ):
        walk = {"cameras": cameras, "client": client, "progress": False, **SMALL}
        files = render_frames(room, output, **walk)
        assert files == [tmp_path / f"walk-00{frame}.exr" for frame in (1, 2, 3)]
        same(map(ml.read_image, files), expected)
        assert sorted(tmp_path.iterdir()) == files, "neither lights nor the description stay"
        # What has a file is not rendered again.
        files[1].unlink()
        kept = files[0].stat().st_mtime_ns
        assert render_frames(room, output, frames=[1, 2], **walk) == files[:2]
        same([ml.read_image(files[1])], [expected[1]])
        assert files[0].stat().st_mtime_ns == kept
        with pytest.raises(ml.UsageError, match="found 3 cameras"):
            render_frames(room, output, frames=[4], **walk)
        # What failed leaves its description: another walkthrough does not mix with it.
        with pytest.raises(ml.UsageError, match="has parts of another render .*cameras"):
            render_frames(room, output, **{**walk, "cameras": cameras[:2]})
        with pytest.raises(ml.UsageError, match="time: does not go with frames"):
            render_frames(room, output, time=3, **walk)
