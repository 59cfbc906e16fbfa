"""Renders, their images and their errors."""

import inspect
import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import manylight as ml
from manylight._options import OPTIONS


def test_an_image_has_the_bits_of_the_command(room, small, tmp_path):
    image = ml.render(room, seed=3, **small)
    image.save(tmp_path / "package.exr")
    words = ["--size=32x18", "--passes=2", "--lights=256", "--photons=4000", "--seed=3", "-q", "-o", "command.exr"]
    command = [sys.executable, "-m", "manylight", "render", room.source, *words]
    subprocess.run(command, check=True, cwd=tmp_path)
    ours, theirs = (ml.read_image(tmp_path / name) for name in ("package.exr", "command.exr"))
    assert set(ours.layers) == set(theirs.layers) == set(image.layers)
    for name, layer in ours.layers.items():
        assert np.array_equal(layer, theirs.layers[name]), name
        assert np.array_equal(layer, image.layers[name]), name
    assert ours.metadata["scene.sha256"] == theirs.metadata["scene.sha256"] == room.digest
    assert theirs.passes == image.passes == 2


def test_arrays_share_the_memory_of_the_image_and_cannot_be_changed(room, small):
    image = ml.render(room, **small)
    picture = np.asarray(image)
    assert picture.shape == (18, 32, 3) and picture.dtype == np.float32
    assert np.shares_memory(picture, np.asarray(image))
    assert not picture.flags.writeable
    layers = image.layers
    del image
    assert np.isfinite(layers["albedo"]).all() and layers["albedo"].max() <= 1.0
    assert layers["depth"].shape == (18, 32)
    assert np.array_equal(picture, layers["beauty"])
    doubled = np.array(picture, dtype=np.float64) * 2
    assert doubled.flags.writeable


def test_variance_and_layers_add_up(room, small):
    image = ml.render(room, "path", size=small["size"], passes=16)
    parts = image.layers["emission"] + image.layers["direct"]
    rest = [name for name in ("indirect", "virtual_lights", "compensation", "caustics") if name in image.layers]
    parts = parts + sum(image.layers[name] for name in rest)
    assert np.allclose(parts, np.asarray(image), rtol=1e-4, atol=1e-5)
    assert (image.variance >= 0).all() and image.variance.max() > 0
    assert 0 < image.relative_error < 2 and image.layers["error"].max() > 0


def lamps():
    """A floor under two point lights."""
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 3},
        "sensor": {"type": "perspective", "to_world": ml.transforms.look_at([0, 3, 3], [0, 0, 0], [0, 1, 0])},
        "floor": {"type": "rectangle", "to_world": ml.transforms.rotate([1, 0, 0], -90)},
        "key": {"type": "point", "position": [1, 1, 0], "intensity": 3.0},
        "fill": {"type": "point", "position": [-1, 1, 0], "intensity": 1.0},
    }


def test_light_groups_add_up_and_are_weighed_anew():
    scene = ml.load_dict(lamps())
    image = ml.render(scene, "path", size=(16, 12), passes=4, light_groups=True)
    key, fill = (image.layers[f"Combined_{name}"] for name in ("key", "fill"))
    assert key.max() > 0 and fill.max() > 0
    assert np.allclose(key + fill, np.asarray(image), rtol=1e-5, atol=1e-7)
    relit = image.relight({"key": 0.5, "fill": [1, 2, 0]})
    assert np.allclose(np.asarray(relit), 0.5 * key + np.array([1, 2, 0]) * fill, rtol=1e-5, atol=1e-7)
    assert relit.variance is not None and relit.passes == 4
    assert "direct" not in relit.layers and "albedo" in relit.layers
    joined = ml.render(scene, "path", size=(16, 12), passes=1, light_group={"all": "*"})
    assert "Combined_all" in joined.layers and "Combined_key" not in joined.layers
    for wrong in ({"rim": 1.0}, {"key": -1.0}):
        with pytest.raises(ml.UsageError):
            image.relight(wrong)
    with pytest.raises(ml.UsageError, match="no light groups"):
        ml.render(scene, "path", size=(16, 12), passes=1).relight({"key": 1.0})
    with pytest.raises(ml.UsageError, match="no emitter"):
        ml.render(scene, "path", size=(16, 12), passes=1, light_group={"rim": "rim*"})


def test_passes_come_one_by_one_and_end_with_the_image(room, small):
    small["passes"] = 3
    seen = list(room.passes(**small))
    assert [image.passes for image in seen] == [1, 2, 3]
    whole = ml.render(room, **small)
    assert np.array_equal(np.asarray(seen[-1]), np.asarray(whole))
    assert not np.array_equal(np.asarray(seen[0]), np.asarray(whole))


def test_leaving_the_loop_stops_the_render(room, small):
    small["passes"] = 100_000
    for image in room.passes(**small):
        if image.passes == 2:
            break
    passes = room.passes(**small)
    next(passes)
    passes.close()
    assert next(passes, None) is None
    # The scene is free again for another film.
    for _ in range(600):
        try:
            assert ml.render(room, size=(8, 6), passes=1).width == 8
            break
        except ml.UsageError:
            time.sleep(0.05)
    else:
        pytest.fail("the render did not stop")


def test_a_scene_in_use_is_not_changed(room, small):
    passes = room.passes(**small)
    next(passes)
    with pytest.raises(ml.UsageError, match="another camera or film"):
        ml.render(room, size=(8, 6), passes=1)
    passes.close()


def test_progress_is_reported_and_can_end_the_render(room, small):
    seen = []
    ml.render(room, progress=lambda *report: seen.append(report), **small)
    assert [report[:2] for report in seen] == [(1, 2), (2, 2)]
    assert seen[0][2] <= seen[1][2]

    class Enough(Exception):
        pass

    def stop(passes, _total, _seconds):
        if passes == 2:
            raise Enough

    small["passes"] = 100_000
    with pytest.raises(Enough):
        ml.render(room, progress=stop, **small)


def test_progress_has_the_passes_of_the_method_that_auto_chooses(room, small):
    seen = []
    # Without indirect light path tracing is chosen, which takes more passes than were asked for.
    options = {**small, "method": "auto", "max_depth": 2}
    image = ml.render(room, progress=lambda *report: seen.append(report), **options)
    assert image.passes > small["passes"]
    assert {total for _, total, _ in seen} == {image.passes}


def test_a_bar_is_shown(room, small, capfd):
    ml.render(room, progress=True, **small)
    assert "2/2" in capfd.readouterr().err


def _interrupt_soon(seconds):
    timer = threading.Timer(seconds, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()


def test_ctrl_c_returns_the_image_so_far(room, small):
    small["passes"] = 100_000
    _interrupt_soon(1.0)
    with pytest.warns(RuntimeWarning, match="interrupted"):
        image = ml.render(room, **small)
    assert image.interrupted and 1 <= image.passes < 100_000
    assert np.isfinite(np.asarray(image)).all()


def test_ctrl_c_ends_an_iteration(room, small):
    small.update(passes=100_000, size=(160, 90))
    _interrupt_soon(0.5)
    passes = room.passes(**small)
    with pytest.raises(KeyboardInterrupt):
        for _ in passes:
            pass
    passes.close()


def test_other_threads_run_meanwhile(room, small):
    counts = []

    def count():
        while not done.is_set():
            counts.append(time.perf_counter())
            time.sleep(0.01)

    done = threading.Event()
    thread = threading.Thread(target=count)
    thread.start()
    ml.render(room, time=1.0, size=small["size"])
    done.set()
    thread.join()
    # A render that kept the lock of the interpreter would let it count once or twice.
    assert len(counts) > 5


def test_renders_end_by_time_and_error(room, small):
    image = ml.render(room, "path", size=small["size"], target_error=0.2)
    assert 4 <= image.passes and image.relative_error <= 0.2
    assert ml.render(room, "path", size=small["size"], time="300ms").passes >= 1


def test_scenes_are_pickled_by_their_files(room, small):
    again = pickle.loads(pickle.dumps(room))
    assert again.digest == room.digest and again.source == room.source
    assert np.array_equal(ml.render(again, **small), ml.render(room, **small))


def test_parts_merge_to_one_run(room, tmp_path):
    settings = {"method": "path", "size": (24, 16), "passes": 40, "block": 8}
    whole = ml.render(room, **settings)
    paths = [tmp_path / f"{i}.part" for i in range(3)]
    for i, path in enumerate(paths):
        ml.render_part(room, path, shard=(i + 1, 3), **settings)
    assert sorted(block for path in paths for block in ml.part_info(path)["blocks"]) == [0, 1, 2, 3, 4]
    merged = ml.merge(reversed(paths))
    assert merged.passes == 40
    for name, layer in whole.layers.items():
        assert np.array_equal(layer, merged.layers[name]), name


@pytest.mark.parametrize("option", [{"checkpoint": "a.part"}, {"resume": "a.part"}, {"lights_out": "a.lights", "method": "rich-vpl"}])
def test_options_of_whole_pictures_are_refused_in_parts(room, tmp_path, option):
    with pytest.raises(ml.UsageError, match=f"{next(iter(option))}: a part"):
        ml.render_part(room, tmp_path / "1.part", shard=(1, 1), **{"method": "path", "size": (8, 6), "passes": 8, **option})


def test_a_render_without_end_has_the_passes_of_its_parts(room, tmp_path):
    settings = {"method": "path", "size": (24, 16), "block": 8}
    paths = [tmp_path / f"{i}.part" for i in range(3)]
    for path, blocks in zip(paths, (range(2, 3), range(0, 1), range(1, 2))):
        ml.render_part(room, path, blocks=blocks, **settings)
    for count in (1, 3):
        chosen = {1: [paths[1]], 3: paths}[count]
        merged = ml.merge(chosen)
        assert merged.passes == 8 * count
        assert np.array_equal(merged, ml.render(room, passes=8 * count, **settings))
    with pytest.raises(ml.UsageError, match="in no part: 1"):
        ml.merge([paths[0], paths[1]])


def test_a_checkpoint_is_continued(room, tmp_path):
    settings = {"method": "path", "size": (24, 16)}
    state = tmp_path / "state.part"
    ml.render(room, passes=20, checkpoint=state, **settings)
    resumed = ml.render(room, passes=40, resume=state, **settings)
    whole = ml.render(room, passes=40, **settings)
    for name, layer in whole.layers.items():
        assert np.array_equal(layer, resumed.layers[name]), name
    with pytest.raises(ml.UsageError, match="seed is 0"):
        ml.render(room, passes=40, resume=state, seed=1, **settings)


def test_damaged_parts_are_refused_by_name(room, tmp_path):
    path = tmp_path / "one.part"
    ml.render_part(room, path, shard=(1, 1), method="path", size=(8, 6), passes=8)
    data = bytearray(path.read_bytes())
    data[-5] ^= 1
    path.write_bytes(data)
    for read in (ml.part_info, lambda part: ml.merge([part])):
        with pytest.raises(ml.FileError, match="one.part"):
            read(path)
    with pytest.raises(ml.UsageError):
        ml.merge([])


@pytest.mark.parametrize(
    ("options", "message", "suggestion"),
    [
        ({"method": "rich-vlp"}, "rich-vlp", "rich-vpl"),
        ({"pases": 3}, "pases", "passes"),
        ({"passes": 0}, "passes", ""),
        ({"lights": "many"}, "lights", ""),
        ({"method": "path", "table_size": 32}, "table_size", "rich-vpl"),
        ({"size": (0, 4)}, "size", ""),
        ({"sensor": 7}, "sensor 7", "counted from 0"),
        ({"max_error": 0.1}, "max_error", "strategy lightcuts"),
    ],
)
def test_wrong_options_are_named_as_keywords(room, options, message, suggestion):
    with pytest.raises(ml.UsageError) as raised:
        ml.render(room, **options)
    assert message in raised.value.message and suggestion in (raised.value.suggestion or "")
    assert "--" not in str(raised.value)
    assert isinstance(raised.value, ValueError)


def test_options_are_those_of_the_command():
    keyword = inspect.Parameter.KEYWORD_ONLY
    loading = {name for name, p in inspect.signature(ml.load_file).parameters.items() if p.kind is keyword}
    assert loading == {name for name, (_, _, loads_scene) in OPTIONS.items() if loads_scene}
    own = inspect.signature(ml.render).parameters
    assert (own["method"].default, own["seed"].default) == ("auto", 0)
    assert "\n    table_size: Texels" in ml.render.__doc__ and "strategy: Summation" in ml.render.__doc__
    assert "--" not in ml.render.__doc__.split("Options:")[1]


@pytest.mark.parametrize("options", [{"output": "x.exr"}, {"json": True}, {"size": object()}, {"environment": "x.hdr"}])
def test_keywords_of_other_places_are_type_errors(room, options):
    with pytest.raises(TypeError):
        ml.render(room, **options)


def test_errors_have_their_place_and_survive_pickling(tmp_path):
    path = tmp_path / "scene.xml"
    path.write_text('<scene version="3.0.0">\n  <sensor type="perspective"/>\n  <shape type="spere"/>\n</scene>\n')
    with pytest.raises(ml.SceneError) as raised:
        ml.load_file(path)
    error = pickle.loads(pickle.dumps(raised.value))
    assert (error.file, error.line) == (str(path), 3) and error.column > 1
    assert "sphere" in str(error) and f"{path}:3:" in str(error)
    with pytest.raises(ml.FileError) as raised:
        ml.load_file(tmp_path / "absent.xml")
    assert isinstance(raised.value, OSError) and "absent.xml" in str(raised.value)


def test_images_are_shown_and_saved(room, small, tmp_path):
    image = ml.render(room, **small)
    assert image._repr_png_().startswith(b"\x89PNG")
    assert image.png(exposure=1.0, view="agx") != image.png()
    with pytest.raises(ml.UsageError, match="view"):
        image.save(tmp_path / "a.png", view="filmic")
    with pytest.raises(ml.FileError, match="tif"):
        image.save(tmp_path / "a.tif")
    with pytest.raises(ml.FileError, match="folder"):
        image.save(tmp_path / "absent" / "a.exr")
    for name in ("a.png", "a.exr", "a.hdr", "a.pfm", "a.jpg"):
        image.save(tmp_path / name)
        assert ml.read_image(tmp_path / name).width == 32
    assert "32x18" in repr(image)


def test_comparison_takes_images_arrays_and_files(room, small, tmp_path):
    image, other = (ml.render(room, "path", size=small["size"], passes=8, seed=seed) for seed in (0, 1))
    image.save(tmp_path / "a.exr")
    measured = ml.compare(image, other)
    assert measured.relmse > 0 and measured.relmse == measured["relmse"]
    assert measured.flip_map.shape == (18, 32)
    assert ml.compare(np.asarray(image), tmp_path / "a.exr").mse == 0.0
    difference = np.asarray(image, dtype=np.float64) - np.asarray(other)
    assert measured.mse == pytest.approx((difference**2).mean(), rel=1e-5)
    assert ml.compare(image, other, layer="albedo").relmse < measured.relmse
    with pytest.raises(ml.UsageError, match="32"):
        ml.compare(image, np.zeros((4, 4, 3)))
    with pytest.raises(ml.UsageError, match="absent"):
        ml.compare(image, other, layer="absent")
    with pytest.raises(AttributeError, match="relmse"):
        _ = measured.rmse


def test_loading_options_reach_the_loader(tmp_path):
    path = tmp_path / "scene.xml"
    path.write_text(
        '<scene version="3.0.0"><default name="edge" value="9"/><sensor type="perspective"><film type="hdrfilm">'
        '<integer name="width" value="$edge"/><integer name="height" value="4"/></film></sensor><emitter type="constant"/></scene>'
    )
    assert ml.load_file(path, edge=7).options == {"edge": 7}
    widths = [ml.render(ml.load_file(path, **defines), "path", passes=1).width for defines in ({}, {"edge": 7})]
    assert widths == [9, 7]
    with pytest.raises(ml.UsageError, match="not a glTF scene"):
        ml.load_file(path, light_units="W")


@pytest.mark.parametrize(("name", "found"), [("portable", "portable"), ("mmx", "UsageError: MANYLIGHT_SIMD: found 'mmx'")])
def test_the_environment_selects_the_instructions(name, found):
    command = [sys.executable, "-c", "import manylight; print(manylight.instruction_set)"]
    ended = subprocess.run(command, env={**os.environ, "MANYLIGHT_SIMD": name}, capture_output=True, text=True)
    assert found in ended.stdout + ended.stderr
