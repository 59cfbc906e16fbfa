#!/usr/bin/env python3
"""Draws one render by four choices of its lamps.

    manylight render scenes/kitchen/scene.xml -m rich-vpl --size 480x270 --passes 16 --light-groups --denoise oidn --filter box -o kitchen.exr
    python3 relit.py MANYLIGHT kitchen.exr OUT.webp

Needs: pip install Pillow.
"""
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

LAMPS = ["hood_lamp", "left_cove", "left_lamp", "light_0", "right_cove", "shelf_lamp"]
CHOICES = [
    {},
    {**dict.fromkeys(LAMPS, "0"), "sky": "25"},
    {"sky": "0.02,0.04,0.12", "left_cove": "0", "right_cove": "0", "hood_lamp": "3", "left_lamp": "2", "light_0": "2"},
    {"sky": "0.1,0.15,0.4", "hood_lamp": "0.2", "left_lamp": "0", "light_0": "0", "left_cove": "2,0.3,1.2", "right_cove": "0.2,0.8,2"},
]


def main() -> None:
    manylight, picture, out = sys.argv[1:4]
    with tempfile.TemporaryDirectory() as folder:
        panels = []
        for k, choice in enumerate(CHOICES):
            path = Path(folder) / f"{k}.png"
            groups = [word for name, factors in (choice or {"sky": "1"}).items() for word in ("--group", f"{name}={factors}")]
            subprocess.run([manylight, "relight", picture, *groups, "--view", "agx", "--exposure", "0.5", "-q", "-o", str(path)], check=True)
            panels.append(Image.open(path).convert("RGB"))
    width, height = panels[0].size
    sheet = Image.new("RGB", (2 * width, 2 * height))
    for k, panel in enumerate(panels):
        sheet.paste(panel, (k % 2 * width, k // 2 * height))
    sheet.save(out, quality=88)


if __name__ == "__main__":
    main()
