"""Values, arrays and threads that a program may get wrong: one exception of the package or a TypeError, never a crash."""

import threading

import numpy as np
import pytest

import manylight as ml
from manylight.errors import Error, FileError, SceneError, UsageError

from test_dictionaries import box_scene

QUICK = {"method": "path", "passes": 1, "size": (8, 6)}
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)


def with_mesh(**changes):
    return box_scene(mesh={"type": "mesh", "vertices": CORNERS, "faces": [[0, 1, 2]], **changes})


def with_texture(data):
    return box_scene(red={"type": "diffuse", "reflectance": {"type": "bitmap", "data": data}})


NO_NUMBERS = {
    "text": "abc",
    "texts": [["0", "1", "2"]] * 3,
    "None": None,
    "complex": CORNERS.astype(complex),
    "objects": np.array([[object()] * 3] * 3),
    "ragged": [[0, 0, 0], [1, 0]],
    "booleans": CORNERS.astype(bool),
    "dates": CORNERS.astype("datetime64[s]"),
    "huge integer": [[10**400, 0, 0]] * 3,
    "masked": np.ma.masked_array(CORNERS, mask=True),
    "nan": np.full((3, 3), np.nan),
    "infinite": np.full((3, 3), np.inf),
    "beyond 32 bits": np.full((3, 3), 1e300),
}
WRONG_SHAPES = {"flat": np.zeros(9), "four": np.zeros((3, 4)), "deep": np.zeros((3, 3, 1)), "number": 3.0, "nothing": []}


@pytest.mark.parametrize("value", [*NO_NUMBERS.values(), *WRONG_SHAPES.values()], ids=[*NO_NUMBERS, *WRONG_SHAPES])
@pytest.mark.parametrize("name", ["vertices", "faces", "normals", "uvs"])
def test_arrays_of_a_mesh_name_their_key(name, value):
    with pytest.raises(SceneError) as found:
        ml.load_dict(with_mesh(**{name: value}))
    assert found.value.key == f"mesh.{name}"
    assert found.value.file is None


@pytest.mark.parametrize("faces", [[[0, 1.5, 2]], [[-1, 1, 2]], [[0, 1, 3]], [[0, 1, 2**40]], np.array([[0, 1, 2**63 + 1]], np.uint64), [[0, 1, 2**70]]])
def test_indices_are_integers_of_vertices(faces):
    with pytest.raises(SceneError) as found:
        ml.load_dict(with_mesh(faces=faces))
    assert found.value.key == "mesh.faces"


@pytest.mark.parametrize("value", NO_NUMBERS.values(), ids=NO_NUMBERS)
def test_arrays_of_a_texture_name_their_key(value):
    with pytest.raises(SceneError) as found:
        ml.load_dict(with_texture(value))
    assert found.value.key == "red.reflectance.data"


@pytest.mark.parametrize("shape", [(0, 2, 3), (2, 0, 3), (0, 0), (2, 2, 4), (2, 2, 2), (1, 2, 2, 3), (5,), ()])
def test_textures_have_pixels(shape):
    with pytest.raises(SceneError) as found:
        ml.load_dict(with_texture(np.ones(shape)))
    assert found.value.key == "red.reflectance.data"


LAYOUTS = {
    "columns first": np.asfortranarray,
    "strided": lambda a: np.repeat(a, 2, axis=0)[::2],
    "reversed": lambda a: a[::-1][::-1],
    "big-endian": lambda a: a.astype(a.dtype.newbyteorder(">")),
    "double": lambda a: a.astype(np.float64),
    "list": lambda a: a.tolist(),
}


@pytest.mark.parametrize("layout", LAYOUTS.values(), ids=LAYOUTS)
def test_layouts_of_arrays_do_not_matter(layout):
    data = np.linspace(0, 1, 24, dtype=np.float32).reshape(2, 4, 3)

    def picture(change):
        arrays = [change(array) for array in (CORNERS, data)]
        for array in arrays:
            if isinstance(array, np.ndarray):
                array.setflags(write=False)
        scene = with_mesh(vertices=arrays[0]) | {"red": with_texture(arrays[1])["red"]}
        return np.array(ml.render(ml.load_dict(scene), **QUICK))

    assert np.array_equal(picture(layout), picture(lambda array: array.copy()))


def test_dictionaries_in_themselves_are_scene_errors():
    scene = box_scene()
    scene["red"]["self"] = scene["red"]
    with pytest.raises(SceneError, match="within each other"):
        ml.load_dict(scene)
    whole = box_scene()
    whole["again"] = whole
    with pytest.raises(SceneError):
        ml.load_dict(whole)
    deep = {"type": "diffuse"}
    for _ in range(5000):
        deep = {"type": "twosided", "inside": deep}
    with pytest.raises(SceneError, match="within each other"):
        ml.load_dict(box_scene(red=deep))
    endless = [1, 2]
    endless.append(endless)
    with pytest.raises(SceneError):
        ml.load_dict(box_scene(lamp={"type": "point", "position": endless}))


@pytest.mark.parametrize("text", ["a\0b", "\x1b[31m", "\udcff", "\ufffe"])
def test_texts_with_other_characters_are_scene_errors(text):
    for scene in (box_scene(red={"type": "diffuse", "id": text}), box_scene(**{text: {"type": "diffuse"}}), box_scene(red={"type": text})):
        with pytest.raises(SceneError) as found:
            ml.load_dict(scene)
        # It can be printed.
        str(found.value).encode()


@pytest.mark.parametrize("text", ['"><x>', "a\nb", "&amp;", "\r\t"])
def test_texts_are_texts(text):
    ml.load_dict(box_scene(**{text: {"type": "diffuse", "id": text}}))


@pytest.mark.parametrize("radius", [float("nan"), float("inf"), -1, 10**400, 1j, b"x", {1}, len, None, np.full((4, 4), np.nan), "x"])
def test_numbers_name_their_key(radius):
    with pytest.raises(SceneError) as found:
        ml.render(ml.load_dict(box_scene(ball={"type": "sphere", "radius": radius})), **QUICK)
    assert found.value.key == "ball.radius"


OPTIONS = [
    {"size": value} for value in ("a", (-1, 2), (1, 2, 3), (1.5, 2), (10**6, 10**6), (10**30, 1), np.array([1, 2]))
] + [
    {"passes": 0}, {"passes": -1}, {"passes": float("nan")}, {"passes": 2**40}, {"passes": True}, {"passes": [1, 2]},
    {"time": float("nan")}, {"time": -1}, {"time": float("inf")}, {"target_error": float("nan")},
    {"seed": -1}, {"seed": 2**70}, {"seed": "x"}, {"threads": 0}, {"threads": 10**9}, {"threads": 60000},
    {"method": "a\0"}, {"method": ""}, {"unknown": 1}, {"a b": 1}, {"aov": [object()]}, {"filter": b"box"}, {"output": "x.exr"},
]  # fmt: skip


@pytest.mark.parametrize("option", OPTIONS, ids=str)
def test_options_are_usage_errors(option):
    scene = ml.load_dict(box_scene())
    with pytest.raises((UsageError, TypeError, ValueError)):
        ml.render(scene, **{**QUICK, **option})


PICTURES = [None, np.zeros(3), np.zeros((6, 8, 4)), np.zeros((0, 0, 3)), np.zeros((5, 5, 3)), [[1], [1, 2]], "no file.exr", "/dev/zero", "."]


@pytest.mark.parametrize("picture", PICTURES, ids=lambda p: str(np.shape(p)) if isinstance(p, np.ndarray) else str(p))
def test_pictures_that_cannot_be_compared(picture):
    reference = np.zeros((6, 8, 3), np.float32)
    with pytest.raises((Error, TypeError, ValueError)):
        ml.compare(picture, reference)


@pytest.mark.parametrize("path", ["/dev/zero", ".", "no file", "a\0b"])
def test_paths_that_are_no_files(path):
    for read in (ml.load_file, ml.read_image, ml.part_info, lambda p: ml.merge([p])):
        with pytest.raises((FileError, ValueError)):
            read(path)


def test_pictures_are_read_only():
    picture = np.asarray(ml.render(ml.load_dict(box_scene()), **QUICK))
    with pytest.raises(ValueError):
        picture[0, 0] = 1
    with pytest.raises(ValueError):
        picture.setflags(write=True)


def test_arrays_may_change_once_a_scene_is_loaded():
    vertices = CORNERS.copy()
    scene = ml.load_dict(with_mesh(vertices=vertices))
    expected = np.array(ml.render(scene, **QUICK))
    done = threading.Event()

    def spoil():
        while not done.is_set():
            vertices[:] = np.random.default_rng().random(vertices.shape)

    thread = threading.Thread(target=spoil)
    thread.start()
    pictures = [np.array(ml.render(scene, **QUICK)) for _ in range(5)]
    done.set()
    thread.join()
    assert all(np.array_equal(picture, expected) for picture in pictures)


def test_threads_may_render_one_scene_at_once():
    scene = ml.load_dict(box_scene())
    expected = {size: np.array(ml.render(scene, **{**QUICK, "size": size})) for size in ((8, 6), (9, 6))}
    wrong: list[object] = []
    refused: list[str] = []

    def work(size):
        for _ in range(4):
            try:
                if not np.array_equal(ml.render(scene, **{**QUICK, "size": size}), expected[size]):
                    wrong.append(size)
            except UsageError as error:
                # Another thread renders another film meanwhile.
                refused.append(str(error))
            except BaseException as error:
                wrong.append(error)

    threads = [threading.Thread(target=work, args=(size,)) for size in expected for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []
    assert all("another camera or film" in text for text in refused)
