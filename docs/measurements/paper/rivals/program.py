"""What the programs of docs/measurements/paper/plan.json have in common: options, images, the report, and what to do without a renderer."""
import argparse
import contextlib
import json
import os
import re
import struct
import sys
import zlib
from pathlib import Path

import numpy as np

#: Exit code that `manylight study` takes for: not installed, or the scene cannot be translated.
UNAVAILABLE = 5


def unavailable(reason):
    """Ends the program with the reason."""
    print(reason, file=sys.stderr)
    sys.exit(UNAVAILABLE)


def parser(description):
    """The options that `manylight study` passes to a program."""
    found = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    found.add_argument("scene", type=Path)
    budget = found.add_mutually_exclusive_group(required=True)
    budget.add_argument("--time", type=seconds_of, help="such as 90s or 2m")
    budget.add_argument("--spp", "--passes", type=int)
    found.add_argument("--size", required=True, type=lambda text: tuple(int(n) for n in text.split("x")))
    found.add_argument("--max-depth", type=int, default=-1, help="as in Mitsuba: 2 = direct light, -1 = no limit")
    found.add_argument("--filter", choices=["box"], default="box")
    found.add_argument("--seed", type=int, default=0)
    found.add_argument("--output", "-o", action="append", required=True, type=Path, help=".exr or .png")
    found.add_argument("--json", action="store_true")
    found.add_argument("--quiet", action="store_true")
    found.add_argument("--progress", choices=["none", "plain"], default="none")
    return found


def seconds_of(text):
    found = re.fullmatch(r"([0-9.]+)(s|m|h)", text)
    if not found:
        raise argparse.ArgumentTypeError(f"found {text}, expected a time such as 90s or 2m")
    return float(found[1]) * {"s": 1, "m": 60, "h": 3600}[found[2]]


def report(version, settings, stages, counts):
    """Prints the object that `manylight study` reads. `stages` are seconds by name, `counts` numbers by name."""
    print(json.dumps({"version": version, "settings": settings, "stages": stages, "counts": counts}))


@contextlib.contextmanager
def output_to_stderr():
    """Sends what a library writes to stdout to stderr."""
    sys.stdout.flush()
    kept = os.dup(1)
    os.dup2(2, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)


def write(path, mean, variance=None):
    """Writes an image of shape (height, width, 3), linear in .exr with the variance if known, sRGB in .png."""
    if path.suffix == ".png":
        path.write_bytes(png(mean))
        return
    import OpenEXR

    layers = {"": mean} if variance is None else {"": mean, "variance.": variance}
    channels = {
        prefix + name: np.ascontiguousarray(values[:, :, i], np.float32)
        for prefix, values in layers.items()
        for i, name in enumerate("RGB")
    }
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, channels) as file:
        file.write(str(path))


def png(linear):
    """An 8-bit sRGB PNG file."""
    x = np.clip(linear, 0, 1)
    srgb = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    rows = (255 * srgb + 0.5).astype(np.uint8)
    height, width = rows.shape[:2]
    lines = b"".join(b"\0" + row.tobytes() for row in rows)
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", zlib.compress(lines)) + chunk(b"IEND", b"")
