"""Virtual lights that the command keeps, read as arrays."""

import subprocess
import sys

import numpy as np
import pytest

import manylight as ml


def keep(room, folder, storage):
    """The file of the lights, and the picture that was made with them."""
    words = ["--size=32x18", "--passes=2", "--lights=64", "--photons=4000", "--table-size=24", f"--table-storage={storage}", "-q"]
    outputs = [f"--lights-out={storage}.lights", "-o", f"{storage}.exr"]
    command = [sys.executable, "-m", "manylight", "render", room.source, *words, *outputs]
    subprocess.run(command, check=True, cwd=folder)
    return folder / f"{storage}.lights", ml.read_image(folder / f"{storage}.exr")


def test_lights_of_every_storage_have_the_same_tables(room, tmp_path):
    groups = {storage: ml.read_lights(keep(room, tmp_path, storage)[0]) for storage in ("float", "shared", "blocks")}
    exact = groups["float"][0]
    assert exact.passes == range(2) and len(exact) == len(exact.positions) >= 64
    assert np.allclose(np.linalg.norm(exact.normals, axis=1), 1, atol=1e-5) and (exact.flux >= 0).all()
    tables = exact.tables()
    chosen = exact.table_indices
    assert tables.shape[1:] == (24, 24, 3) and chosen.max() == len(tables) - 1
    # Nothing shines below the horizon, but where texels cross it.
    light = int(np.argmax(chosen >= 0))
    towards = ml.octahedral_directions(24) @ exact.normals[light]
    assert exact.tables(chosen[light])[0][towards < -0.2].max() == 0 < tables[chosen[light]].max()
    for storage, bound in (("shared", 0.01), ("blocks", 0.25)):
        others = groups[storage][0]
        assert np.array_equal(others.positions, exact.positions)
        error = np.sqrt(((others.tables() - tables) ** 2).sum((1, 2, 3)) / (tables**2).sum((1, 2, 3)))
        assert error.max() < bound, storage
        assert np.allclose(others.tables().sum((1, 2)), tables.sum((1, 2)), rtol=0.05)


def test_a_picture_by_kept_lights_has_the_bits_of_the_command(room, tmp_path):
    file, picture = keep(room, tmp_path, "blocks")
    image = ml.render(room, size=(32, 18), lights_in=file)
    assert np.array_equal(image, picture) and image.passes == 2
    with pytest.raises(ml.UsageError, match="lights 8: the lights of .* were made with lights 64"):
        ml.render(room, size=(32, 18), lights_in=file, lights=8)
    options = {"passes": 2, "lights": 64, "photons": 4000, "table_size": 24, "table_storage": "blocks"}
    assert np.array_equal(ml.render(room, size=(32, 18), **options, lights_out=tmp_path / "again.lights"), picture)
    assert (tmp_path / "again.lights").read_bytes() == file.read_bytes()


def test_other_files_are_refused(room, tmp_path):
    file, _ = keep(room, tmp_path, "shared")
    data = bytearray(file.read_bytes())
    data[-1] ^= 1
    (tmp_path / "damaged.lights").write_bytes(data)
    (tmp_path / "text.lights").write_text("no lights at all")
    for name, message in (("damaged", "checksum"), ("text", "no file of virtual lights"), ("none", "No such file")):
        with pytest.raises(ml.FileError, match=message):
            ml.read_lights(tmp_path / f"{name}.lights")
