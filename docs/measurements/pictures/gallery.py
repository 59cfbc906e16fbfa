#!/usr/bin/env python3
"""Makes the pictures of docs/gallery.md, and prints the command and the time of each.

    python3 gallery.py MANYLIGHT OUT [--only NAME ...] [--times 1] [--equal-time FOLDER]

OUT receives NAME.webp. --times multiplies all render times. With FOLDER, the output of `equal_time.py MANYLIGHT --own -o FOLDER
--time 30 --methods auto --rivals mitsuba cycles`, the sheet of pictures at equal time is made, too.
Needs: pip install Pillow pyoidn numpy OpenEXR.
"""
import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "docs" / "measurements"))
VIEW = "--view agx --denoise oidn"
#: By name: the scene, and the options of each picture of a row.
PICTURES = {
    "kitchen": ("kitchen", [f"--size 1920x1080 --photons 4000000 --time 300s {VIEW} --exposure 0.3"]),
    "garage": ("garage", [f"--size 1280x720 --time 120s {VIEW} --exposure 0.3"]),
    "disco": ("disco", [f"--size 1280x720 --time 120s {VIEW}"]),
    "u-shape": ("u-shape", [f"--size 1280x720 --time 120s {VIEW} --exposure 0.5"]),
    "glossy-room": ("glossy-room", [f"--size 1280x720 --time 120s {VIEW}"]),
    "glossy-cornell": ("glossy-cornell", [f"--size 640x640 --time 60s {VIEW}"]),
    "vpl-and-rich-vpl": ("kitchen", [f"-m {method} --size 640x360 --time 30s --view agx --exposure 0.3" for method in ("vpl", "rich-vpl")]),
}
#: Rows of the sheet at equal time: the scene, the left upper corner of its crop, and the factor that brings it to the brightness of a
#: display.
SHEET = {"u-shape": (30, 20, 0.9), "kitchen": (120, 20, 0.7), "garage": (70, 60, 1.0)}
#: Size of a crop in pixels, and its enlargement.
CROP = (120, 72)
ENLARGED = 3


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("manylight")
    parser.add_argument("output", type=Path)
    parser.add_argument("--only", nargs="+")
    parser.add_argument("--times", type=float, default=1)
    parser.add_argument("--equal-time", type=Path)
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    for name, (scene, rows) in PICTURES.items():
        if args.only is None or name in args.only:
            panels = [rendered(args, scene, options.split()) for options in rows]
            beside(panels).save(args.output / f"{name}.webp", quality=86, method=6)
    if args.equal_time:
        equal_time_sheet(args.manylight, args.equal_time / "own").save(args.output / "equal-time.webp", quality=86, method=6)


def rendered(args: argparse.Namespace, scene: str, options: list[str]) -> Image.Image:
    """A picture; its command and time go to stdout."""
    at = options.index("--time") + 1
    options[at] = f"{float(options[at].rstrip('s')) * args.times:g}s"
    words = ["render", f"scenes/{scene}/scene.xml", *options]
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [args.manylight, *words, "-q", "--json", "-o", f"{folder}/picture.png"], cwd=ROOT, check=True, capture_output=True, text=True
        )
        picture = Image.open(f"{folder}/picture.png").convert("RGB")
    print("manylight", *words, f"| {sum(json.loads(done.stdout)['stages'].values()):.0f} s", flush=True)
    return picture


def beside(panels: list[Image.Image]) -> Image.Image:
    sheet = Image.new("RGB", (sum(p.width for p in panels), panels[0].height))
    x = 0
    for panel in panels:
        sheet.paste(panel, (x, 0))
        x += panel.width
    return sheet


def equal_time_sheet(manylight: str, folder: Path) -> Image.Image:
    """Mitsuba, Cycles, ours and the reference, with the error of each."""
    import equal_time as measured

    rows = []
    for scene in measured.own_scenes():
        if scene["name"] not in SHEET:
            continue
        reference = measured.channels(scene["reference"])
        truth, variance = measured.rgb(reference), measured.rgb(reference, "variance.")
        pictures = {}
        for name, label in {"mitsuba": "Mitsuba + OIDN", "cycles": "Cycles + OIDN", "auto": "manylight + OIDN"}.items():
            picture = measured.channels(folder / f"{scene['name']}.{name}.30s.1.exr")
            image = measured.rgb(picture)
            if name == "mitsuba":
                sys.path.insert(0, str(measured.RIVALS))
                from mitsuba_path import denoise

                guides = measured.channels(folder / f"{scene['name']}.features.exr")
                noisy = measured.rgb(picture, "noisy.") if "noisy.R" in picture else image
                image = denoise(noisy, measured.rgb(guides, "albedo."), measured.rgb(guides, "normal.", "XYZ"))
            pictures[f"{label}: relMSE {measured.error_of_known(image, truth, variance):.4f}"] = image
        pictures["reference"] = truth
        rows.append([crop(image, SHEET[scene["name"]], label) for label, image in pictures.items()])
    strips = [beside(row) for row in rows]
    sheet = Image.new("RGB", (strips[0].width, sum(s.height for s in strips)))
    for k, strip in enumerate(strips):
        sheet.paste(strip, (0, k * strips[0].height))
    return sheet


def crop(linear: np.ndarray, where: tuple[int, int, float], label: str) -> Image.Image:
    """An enlarged crop under a line of text."""
    x, y, factor = where
    linear = np.clip(linear[y : y + CROP[1], x : x + CROP[0]] * factor, 0, 1)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)
    size = (CROP[0] * ENLARGED, CROP[1] * ENLARGED)
    picture = Image.fromarray((255 * encoded).round().astype(np.uint8)).resize(size, Image.Resampling.BICUBIC)
    framed = Image.new("RGB", (picture.width, picture.height + 22))
    framed.paste(picture, (0, 22))
    ImageDraw.Draw(framed).text((4, 3), label, fill="white", font_size=14)
    return framed


if __name__ == "__main__":
    main()
