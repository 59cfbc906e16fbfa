"""Scenes in dictionaries."""

import pickle

import numpy as np
import pytest

import manylight as ml
from manylight import transforms


def box_scene(**changes):
    """A floor, a ball and a lamp."""
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 4},
        "camera": {
            "type": "perspective",
            "fov": 45,
            "to_world": transforms.look_at([0, 1, 4], [0, 0.5, 0]),
            "film": {"type": "hdrfilm", "width": 24, "height": 16, "rfilter": {"type": "box"}},
            "sampler": {"type": "independent", "sample_count": 4},
        },
        "red": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.8, 0.1, 0.1]}},
        "floor": {
            "type": "rectangle",
            "to_world": transforms.rotate([1, 0, 0], -90) @ transforms.scale(3),
            "bsdf": {"type": "ref", "id": "red"},
        },
        "ball": {"type": "sphere", "center": [0, 0.5, 0], "radius": 0.5, "bsdf": {"type": "roughconductor", "alpha": 0.2}},
        "lamp": {"type": "point", "position": [1, 3, 2], "intensity": 20.0},
    }
    scene.update(changes)
    return {key: value for key, value in scene.items() if value is not None}


SAME_AS_XML = """<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="4"/></integrator>
  <sensor type="perspective">
    <float name="fov" value="45"/>
    <transform name="to_world"><lookat origin="0 1 4" target="0 0.5 0" up="0 1 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="16"/><rfilter type="box"/></film>
  </sensor>
  <bsdf type="diffuse" id="red"><rgb name="reflectance" value="0.8 0.1 0.1"/></bsdf>
  <shape type="rectangle">
    <transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/></transform>
    <ref id="red"/>
  </shape>
  <shape type="sphere"><point name="center" value="0 0.5 0"/><float name="radius" value="0.5"/>
    <bsdf type="roughconductor"><float name="alpha" value="0.2"/></bsdf></shape>
  <emitter type="point"><point name="position" value="1 3 2"/><rgb name="intensity" value="20"/></emitter>
</scene>
"""


def test_a_dictionary_is_the_same_scene_as_xml(tmp_path):
    path = tmp_path / "scene.xml"
    path.write_text(SAME_AS_XML)
    options = {"method": "path", "passes": 8}
    ours, theirs = ml.render(ml.load_dict(box_scene()), **options), ml.render(ml.load_file(path), **options)
    assert np.asarray(ours).max() > 0
    assert np.allclose(ours, theirs, rtol=1e-3, atol=1e-4)
    assert "command" not in ours.metadata and ours.metadata["scene"] == "dictionary"


def test_arrays_stand_for_meshes_and_textures():
    corners = np.array([[-3, 0, 3], [3, 0, 3], [3, 0, -3], [-3, 0, -3]], dtype=np.float64)
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    floor = {"type": "mesh", "vertices": corners, "faces": faces, "bsdf": {"type": "ref", "id": "red"}}
    # Direct light of a point depends on no tangent.
    options = {"method": "direct", "passes": 8}
    plain = ml.render(ml.load_dict(box_scene()), **options)
    meshed = ml.render(ml.load_dict(box_scene(floor=floor)), **options)
    assert np.allclose(meshed, plain, rtol=1e-3, atol=1e-4)
    uvs = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    for data in (np.full((2, 2, 3), 0.25), np.full((2, 2), 0.25, dtype=np.float32), np.full((2, 2, 1), 0.25)):
        bitmap = {"type": "diffuse", "reflectance": {"type": "bitmap", "data": data}}
        textured = ml.load_dict(box_scene(floor={**floor, "uvs": uvs, "bsdf": bitmap}))
        flat = ml.load_dict(box_scene(floor={**floor, "bsdf": {"type": "diffuse", "reflectance": 0.25}}))
        assert np.allclose(ml.render(textured, **options), ml.render(flat, **options), rtol=1e-3, atol=1e-4)
    sky = {"type": "envmap", "data": np.full((4, 8, 3), 0.5)}
    lit = ml.render(ml.load_dict(box_scene(lamp=None, sky=sky)), **options)
    assert lit.layers["emission"].max() == pytest.approx(0.5)


def test_values_of_numpy_and_mitsuba_are_taken():
    class Transform:
        matrix = transforms.translate([0, 0, 0]).tolist()

    ball = {"type": "sphere", "center": np.array([0, 0.5, 0]), "radius": np.float32(0.5), "to_world": Transform()}
    ball["flip_normals"] = np.bool_(False)
    spectrum = {"type": "spectrum", "value": [(400, 0.5), (700, 0.5)]}
    ml.load_dict(box_scene(ball={**ball, "bsdf": {"type": "diffuse", "reflectance": spectrum}}))
    ml.load_dict(box_scene(lamp={"type": "constant", "radiance": {"type": "blackbody", "temperature": 4000, "scale": 1e-12}}))


def test_scenes_are_pickled_by_their_dictionaries():
    scene = ml.load_dict(box_scene())
    again = pickle.loads(pickle.dumps(scene))
    assert again.digest == scene.digest
    assert ml.load_dict(box_scene(ball=None)).digest != scene.digest


@pytest.mark.parametrize(
    ("changes", "key", "message"),
    [
        ({"ball": {"type": "spere"}}, "ball", "sphere"),
        ({"ball": {"type": "sphere", "bsdf": {"type": "difuse"}}}, "ball.bsdf", "diffuse"),
        ({"ball": {"type": "sphere", "radius": "big"}}, "ball.radius", "a number"),
        ({"ball": {"type": "sphere", "radus": 2.0}}, "ball.radus", "radius"),
        ({"ball": {"type": "sphere", "center": [0, 1]}}, "ball.center", "three numbers"),
        ({"ball": {"type": "sphere", "center": object()}}, "ball.center", "object"),
        ({"ball": {"radius": 1.0}}, "ball", "type"),
        ({"ball": {"type": "sphere", "bsdf": {"type": "ref", "id": "rad"}}}, "ball.bsdf", "rad"),
        ({"ball": {"type": "obj", "filename": "absent.obj"}}, "ball", "absent.obj"),
        ({"ball": {"type": "mesh", "vertices": np.zeros((3, 3))}}, "ball", "faces"),
        ({"ball": {"type": "mesh", "vertices": np.zeros((3, 2)), "faces": [[0, 1, 2]]}}, "ball.vertices", "(3, 2)"),
        ({"ball": {"type": "mesh", "vertices": np.zeros((3, 3)), "faces": [[0, 1, 3]]}}, "ball.faces", "3"),
        ({"sky": {"type": "envmap", "data": np.zeros((4, 8, 2))}}, "sky.data", "(4, 8, 2)"),
        ({"text": "two\nlines", "ball": {"type": "spere"}}, "ball", "sphere"),
    ],
)
def test_errors_name_the_keys_of_the_entry(changes, key, message):
    with pytest.raises(ml.SceneError) as raised:
        ml.load_dict(box_scene(**changes))
    assert raised.value.key.startswith(key), str(raised.value)
    assert message in str(raised.value)
    assert "/scene.xml" not in str(raised.value)


def test_warnings_name_the_keys_of_the_entry():
    medium = {"type": "homogeneous", "albedo": 0.5}
    scene = ml.load_dict(box_scene(ball={"type": "sphere", "interior": medium}))
    assert scene.warnings and all("ball" in text and "scene.xml" not in text for text in scene.warnings)
    with pytest.raises(ml.SceneError):
        ml.load_dict(box_scene(ball={"type": "sphere", "interior": medium}), strict=True)
    with pytest.raises(ml.SceneError, match="scene"):
        ml.load_dict({"type": "sphere"})


def test_transforms_are_those_of_mitsuba():
    point = np.array([1.0, 0.0, 0.0, 1.0])
    assert np.allclose(transforms.rotate([0, 0, 2], 90) @ point, [0, 1, 0, 1])
    assert np.allclose(transforms.translate([1, 2, 3]) @ transforms.scale(2) @ point, [3, 2, 3, 1])
    view = transforms.look_at([1, 2, 3], [1, 2, 0])
    assert np.allclose(view @ [0, 0, 2, 1], [1, 2, 1, 1])
    # The camera's x axis points to the left.
    assert np.allclose(view @ [1, 0, 0, 0], [-1, 0, 0, 0])
    with pytest.raises(ValueError, match="two directions"):
        transforms.look_at([0, 0, 0], [0, 1, 0])
    mitsuba = pytest.importorskip("mitsuba", reason="mitsuba is not installed")
    mitsuba.set_variant("scalar_rgb")
    theirs = mitsuba.ScalarTransform4f().look_at(origin=[1, 2, 3], target=[0, 1, 1], up=[0, 1, 0]).matrix
    assert np.allclose(np.array(theirs), transforms.look_at([1, 2, 3], [0, 1, 1]), atol=1e-6)


def test_mitsuba_renders_the_same_dictionary():
    mitsuba = pytest.importorskip("mitsuba", reason="mitsuba is not installed")
    mitsuba.set_variant("scalar_rgb")
    transform = mitsuba.ScalarTransform4f()
    scene = box_scene(
        floor={
            "type": "rectangle",
            "to_world": transform.rotate([1, 0, 0], -90).scale(3),
            "bsdf": {"type": "twosided", "nested": {"type": "ref", "id": "red"}},
        },
        sky={"type": "constant", "radiance": {"type": "rgb", "value": [0.2, 0.3, 0.5]}},
    )
    scene["camera"]["to_world"] = transform.look_at(origin=[0, 1, 4], target=[0, 0.5, 0], up=[0, 1, 0])
    theirs = np.array(mitsuba.render(mitsuba.load_dict(scene), spp=1024))[:, :, :3]
    ours = np.asarray(ml.render(ml.load_dict(scene), "path", passes=1024))
    assert np.allclose(ours.mean(axis=(0, 1)), theirs.mean(axis=(0, 1)), rtol=0.01)
    assert np.abs(ours - theirs).mean() < 0.02 * theirs.mean()


def test_the_cornell_box_of_mitsuba_is_taken_as_it_is():
    mitsuba = pytest.importorskip("mitsuba", reason="mitsuba is not installed")
    mitsuba.set_variant("scalar_rgb")
    scene = mitsuba.cornell_box()
    scene["sensor"]["film"].update(width=32, height=32)
    scene["marble"] = {"type": "sphere", "center": mitsuba.ScalarPoint3f(0, 0.5, 0), "radius": 0.2}
    theirs = np.array(mitsuba.render(mitsuba.load_dict(scene), spp=512))[:, :, :3]
    ours = np.asarray(ml.render(ml.load_dict(scene), "path", passes=512))
    assert np.allclose(ours.mean(axis=(0, 1)), theirs.mean(axis=(0, 1)), rtol=0.01)
