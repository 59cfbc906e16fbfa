"""Mean and variance over independent batches of an image, and the OpenEXR files that keep them."""
import json
import os
import shutil
from pathlib import Path

import numpy as np

#: Edge in pixels of the blocks whose means are compared between sources.
BLOCK = 8
#: Weight of the squared mean of the image in the denominator of relMSE, as in `manylight compare`.
RELMSE_FLOOR = 0.01
#: Mantissa bits of stored variances. Their relative rounding error is at most 2^-11, and the zeros after them compress.
VARIANCE_BITS = 10


class Moments:
    """Number, mean and sum of squared differences from the mean of independent samples (arrays of one shape)."""

    def __init__(self, count=0, mean=0.0, squares=0.0):
        self.count, self.mean, self.squares = count, mean, squares

    def add(self, sample):
        """Adds one sample."""
        self.merge(Moments(1, np.asarray(sample, np.float64), 0.0))

    def merge(self, other):
        """Adds the samples of `other` (Chan, Golub and LeVeque 1983)."""
        count = self.count + other.count
        if other.count == 0:
            return
        difference = other.mean - self.mean
        self.mean = self.mean + difference * (other.count / count)
        self.squares = self.squares + other.squares + difference**2 * (self.count * other.count / count)
        self.count = count

    def variance(self):
        """Variance of the mean; infinite for fewer than two samples."""
        if self.count < 2:
            return np.full(np.shape(self.mean), np.inf)
        return self.squares / (self.count - 1) / self.count

    @classmethod
    def of(cls, count, mean, variance):
        """The inverse of `variance`."""
        squares = variance * count * (count - 1) if count > 1 else np.zeros_like(mean)
        return cls(count, mean, squares)


class Accumulated:
    """Moments of the pixels, of the means of blocks, and of the mean of the image, over batches of one source.

    Block means and the image's mean have moments of their own because the pixels of one batch may be correlated.
    `facts` is a dictionary that JSON can hold.
    """

    def __init__(self):
        self.pixels, self.blocks, self.total = Moments(), Moments(), Moments()
        self.facts = {}

    def add(self, image):
        """Adds the image of one batch, of shape (height, width, 3)."""
        self.pixels.add(image)
        self.blocks.add(block_means(image))
        self.total.add(image.mean(axis=(0, 1)))

    def save(self, path):
        """Writes the state under a temporary name, then renames it."""
        state = {
            "facts": self.facts,
            "batches": self.pixels.count,
            "mean": list(self.total.mean),
            "variance_of_mean": finite_list(self.total.variance()),
        }
        block_variance = spread(self.blocks.variance(), self.pixels.mean.shape)
        layers = {
            "": self.pixels.mean,
            "variance.": shortened(self.pixels.variance()),
            "block.variance.": shortened(block_variance),
        }
        write_exr(path, layers, {"state": json.dumps(state)})

    @classmethod
    def load(cls, path):
        """The state in a file, or an empty one where there is no file."""
        loaded = cls()
        if not Path(path).exists():
            return loaded
        layers, header = read_exr(path)
        state = json.loads(header["state"])
        count = state["batches"]
        image, variance = layers[""], layers["variance."]
        loaded.facts = state["facts"]
        loaded.pixels = Moments.of(count, image, variance)
        block_variance = layers["block.variance."][::BLOCK, ::BLOCK]
        loaded.blocks = Moments.of(count, block_means(image), block_variance)
        total_variance = np.array([np.inf if v is None else v for v in state["variance_of_mean"]])
        loaded.total = Moments.of(count, np.array(state["mean"]), total_variance)
        return loaded


def block_means(image):
    """Means over blocks of BLOCK x BLOCK pixels; the last ones of a row or column may be smaller."""
    rows, columns = (np.arange(0, n, BLOCK) for n in image.shape[:2])
    sums = np.add.reduceat(np.add.reduceat(image, rows, axis=0), columns, axis=1)
    sizes = [np.diff(np.append(starts, n)) for starts, n in zip((rows, columns), image.shape[:2])]
    return sums / np.outer(*sizes)[:, :, None]


def spread(blocks, shape):
    """Values of blocks as an image in which each block is constant."""
    return np.repeat(np.repeat(blocks, BLOCK, axis=0), BLOCK, axis=1)[: shape[0], : shape[1]]


def relative_noise(mean, variance):
    """Square root of the relMSE that an image of this variance has as its noise."""
    denominator = mean**2 + RELMSE_FLOOR * mean.mean() ** 2
    return float(np.sqrt(np.mean(variance / denominator)))


def shortened(values):
    """Values as float32, rounded to VARIANCE_BITS bits of mantissa."""
    bits = np.ascontiguousarray(values, np.float32).view(np.uint32)
    unused = 23 - VARIANCE_BITS
    half = np.uint32(1 << (unused - 1))
    rounded = ((bits + half) >> unused) << unused
    # Infinity stays as it is.
    return np.where(np.isfinite(values), rounded, bits).astype(np.uint32).view(np.float32)


def finite_list(values):
    """The values as a list, with None for what is not finite."""
    return [float(v) if np.isfinite(v) else None for v in np.ravel(values)]


def write_exr(path, layers, header=None):
    """Writes layers (prefix to array of shape (height, width, 3)) as float32, under a temporary name first."""
    import OpenEXR

    channels = {}
    for prefix, values in layers.items():
        for index, name in enumerate("RGB"):
            channels[prefix + name] = np.ascontiguousarray(values[:, :, index], np.float32)
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f"{path.stem}.tmp.exr")
    attributes = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, **(header or {})}
    with OpenEXR.File(attributes, channels) as file:
        file.write(str(temporary))
    os.replace(temporary, path)


def copy_file(source, target):
    """Copies a file under a temporary name, then renames it."""
    temporary = target.with_name(f"{target.stem}.tmp.exr")
    shutil.copyfile(source, temporary)
    os.replace(temporary, target)


def read_exr(path):
    """Layers (prefix to array of float64) and the header of a file."""
    import OpenEXR

    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = {name: np.array(c.pixels, np.float64) for name, c in file.channels().items()}
        header = dict(file.header())
    prefixes = [name[:-1] for name in channels if name.endswith("R") and (name == "R" or name[-2] == ".")]
    layers = {prefix: np.stack([channels[prefix + c] for c in "RGB"], axis=-1) for prefix in prefixes}
    return layers, header
