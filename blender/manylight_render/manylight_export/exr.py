# SPDX-License-Identifier: GPL-3.0-or-later
"""Uncompressed OpenEXR files of 32-bit floats. Layout: "OpenEXR File Layout", Academy Software Foundation."""

import struct

import numpy as np

MAGIC, VERSION, FLOAT, UNCOMPRESSED = 20000630, 2, 2, 0


def write(path, image):
    """Writes `image`, (height, width, 3) linear RGB with the first row on top."""
    height, width, _ = image.shape
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    channel = struct.pack("<iBxxxii", FLOAT, 0, 1, 1)
    channels = b"".join(name + b"\0" + channel for name in (b"B", b"G", b"R")) + b"\0"
    attributes = [
        (b"channels", b"chlist", channels),
        (b"compression", b"compression", bytes([UNCOMPRESSED])),
        (b"dataWindow", b"box2i", window),
        (b"displayWindow", b"box2i", window),
        (b"lineOrder", b"lineOrder", b"\0"),
        (b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
        (b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0)),
        (b"screenWindowWidth", b"float", struct.pack("<f", 1)),
    ]
    header = struct.pack("<ii", MAGIC, VERSION)
    for name, kind, value in attributes:
        header += name + b"\0" + kind + b"\0" + struct.pack("<i", len(value)) + value
    header += b"\0"
    line_bytes = 12 * width
    first = len(header) + 8 * height
    offsets = first + np.arange(height, dtype=np.uint64) * np.uint64(line_bytes + 8)
    lines = np.empty((height, 2 + 3 * width), np.uint32)
    lines[:, 0] = np.arange(height)
    lines[:, 1] = line_bytes
    planes = np.ascontiguousarray(image[..., ::-1].transpose(0, 2, 1), np.float32)
    lines[:, 2:] = planes.reshape(height, -1).view(np.uint32)
    with open(path, "wb") as file:
        file.write(header + offsets.astype("<u8").tobytes() + lines.astype("<u4").tobytes())
