//! Sums of passes as named arrays, for files that keep parts of a render.
//!
//! | array | shape | content |
//! |---|---|---|
//! | `passes` | 2 | first pass, and the end of the passes |
//! | `halves` | 2 | numbers of passes of the two halves ([`Half`]) |
//! | `batches` | 3 | number of completed batches, their passes, sum of the squares of their passes |
//! | `image.moments` | 2, 3, 3 | of the beauty, and of the beauty without emission: sums over batches of S, S² and nS, per channel |
//! | `tiles.batch` | tiles, 2, 3 | the same two quantities, summed over the passes of the current batch |
//! | `tiles.moments` | tiles, 3, 3 | moments of the beauty |
//! | `sum.LAYER` | height, width, 3 | sum over passes |
//! | `square.LAYER` | height, width, 3 | sum over passes of the square, for layers with a variance |
//! | `half.LAYER` | height, width, 3 | sum over the passes of the first half less that over the second, for layers with a variance, of 32 bits |
//! | `IDS.count` | height, width | number of ids in a pixel |
//! | `IDS.id`, `IDS.weight` | sum of `IDS.count` | ids of all pixels, and their sums of weights |
//!
//! Pixels and tiles are in row order. A tile has [`TILE_SIZE`] x [`TILE_SIZE`] pixels, fewer at the
//! right and lower edge. S is the sum of a quantity over the pixels and the n passes of a batch.

use super::batches::{BatchCounts, BatchMoments};
use super::coverage::CoverageSums;
use super::halves::HalfCounts;
use super::sums::{PassSums, TileSums};
use super::{Film, IdLayer, Layer};
use crate::arrays::{ArrayKind, ArrayValues, InvalidArray, NamedArray};
use std::borrow::Cow;

#[cfg(doc)]
use super::{Half, TILE_SIZE};

impl IdLayer {
    /// Name of the layer in arrays.
    pub fn array_name(self) -> &'static str {
        match self {
            IdLayer::Object => "object",
            IdLayer::Material => "material",
        }
    }

    /// The inverse of [`IdLayer::array_name`].
    pub fn from_array_name(name: &str) -> Option<Self> {
        let all = [IdLayer::Object, IdLayer::Material];
        all.into_iter().find(|layer| layer.array_name() == name)
    }
}

impl Layer {
    /// Name of the layer in arrays: that in image files, or `beauty`.
    pub fn array_name(self) -> Cow<'static, str> {
        match self {
            Layer::Beauty => "beauty".into(),
            other => other.name(),
        }
    }

    /// The inverse of [`Layer::array_name`].
    pub fn from_array_name(name: &str) -> Option<Self> {
        (Layer::ALL.into_iter())
            .find(|layer| layer.array_name() == name)
            .or_else(|| Layer::light_group_of_name(name))
    }
}

/// `sums` of a film as arrays.
pub fn arrays_of_sums<'f>(film: &'f Film, sums: &'f PassSums) -> Vec<NamedArray<'f>> {
    let (stride, with_variance) = (film.layers.len(), film.with_variance.len());
    let tiles = sums.tiles.len();
    let mut arrays = vec![
        NamedArray::words("passes", [2], || [sums.passes.start, sums.passes.end]),
        NamedArray::words("halves", [2], || sums.half_counts.0),
        NamedArray::doubles("batches", [3], || sums.batches.to_array()),
        NamedArray::doubles("image.moments", [2, 3, 3], || {
            let moments = sums.image_moments.iter();
            moments.flat_map(|moments| moments.to_array())
        }),
        NamedArray::doubles("tiles.batch", [tiles, 2, 3], || {
            sums.tiles.iter().flat_map(|tile| tile.batch).flatten()
        }),
        NamedArray::doubles("tiles.moments", [tiles, 3, 3], || {
            sums.tiles.iter().flat_map(|tile| tile.moments.to_array())
        }),
    ];
    for (l, &layer) in film.layers.iter().enumerate() {
        let name = format!("sum.{}", layer.array_name());
        let values = move || pixel_values(film, sums, |tile, i| tile.sums[i * stride + l]);
        arrays.push(NamedArray::doubles(name, rgb_shape(film), values));
    }
    for (k, &l) in film.with_variance.iter().enumerate() {
        let name = format!("square.{}", film.layers[l].array_name());
        let values =
            move || pixel_values(film, sums, |tile, i| tile.squares[i * with_variance + k]);
        arrays.push(NamedArray::doubles(name, rgb_shape(film), values));
    }
    for (k, &l) in film.with_variance.iter().enumerate() {
        let name = format!("half.{}", film.layers[l].array_name());
        let values = move || pixel_values(film, sums, |tile, i| tile.halves[i * with_variance + k]);
        arrays.push(NamedArray::floats(name, rgb_shape(film), values));
    }
    for (k, &layer) in film.id_layers.iter().enumerate() {
        arrays.extend(id_arrays(film, sums, k, layer));
    }
    arrays
}

/// The inverse of [`arrays_of_sums`]: sums for a film from the arrays that `read` gives, by name
/// and shape.
///
/// # Errors
/// Those of `read`, and arrays of the wrong type or with contradicting values.
pub fn sums_of_arrays<E: From<InvalidArray>>(
    film: &Film,
    mut read: impl FnMut(&str, &[usize]) -> Result<ArrayValues, E>,
) -> Result<PassSums, E> {
    let mut sums = empty_sums(film, &mut read)?;
    let tiles = sums.tiles.len();
    let image = read_doubles(&mut read, "image.moments", &[2, 3, 3])?;
    for (moments, values) in sums.image_moments.iter_mut().zip(image.chunks_exact(9)) {
        *moments = BatchMoments::from_slice(values);
    }
    let batch = read_doubles(&mut read, "tiles.batch", &[tiles, 2, 3])?;
    let moments = read_doubles(&mut read, "tiles.moments", &[tiles, 3, 3])?;
    for (t, tile) in sums.tiles.iter_mut().enumerate() {
        let batch = &batch[t * 6..][..6];
        tile.batch = [array_of(batch[..3].to_vec()), array_of(batch[3..].to_vec())];
        tile.moments = BatchMoments::from_slice(&moments[t * 9..][..9]);
    }
    let (stride, with_variance) = (film.layers.len(), film.with_variance.len());
    for (l, &layer) in film.layers.iter().enumerate() {
        let values = read_doubles(
            &mut read,
            &format!("sum.{}", layer.array_name()),
            &rgb_shape(film),
        )?;
        set_pixels(film, &mut sums, &values, |tile, i| {
            &mut tile.sums[i * stride + l]
        });
    }
    for (k, &l) in film.with_variance.iter().enumerate() {
        let name = format!("square.{}", film.layers[l].array_name());
        let values = read_doubles(&mut read, &name, &rgb_shape(film))?;
        set_pixels(film, &mut sums, &values, |tile, i| {
            &mut tile.squares[i * with_variance + k]
        });
    }
    for (k, &l) in film.with_variance.iter().enumerate() {
        let name = format!("half.{}", film.layers[l].array_name());
        let values = read_floats(&mut read, &name, &rgb_shape(film))?;
        set_pixels(film, &mut sums, &values, |tile, i| {
            &mut tile.halves[i * with_variance + k]
        });
    }
    for (k, &layer) in film.id_layers.iter().enumerate() {
        read_ids(film, &mut sums, k, layer, &mut read)?;
    }
    Ok(sums)
}

/// Sums of the passes that the arrays count, without their values.
fn empty_sums<E: From<InvalidArray>>(
    film: &Film,
    read: &mut impl FnMut(&str, &[usize]) -> Result<ArrayValues, E>,
) -> Result<PassSums, E> {
    let passes: [u32; 2] = array_of(read_words(read, "passes", &[2])?);
    let mut sums = PassSums::new(film.desc.crop_size, film.shape(), passes[0]);
    sums.passes.end = passes[1];
    sums.half_counts = HalfCounts(array_of(read_words(read, "halves", &[2])?));
    let batches = array_of(read_doubles(read, "batches", &[3])?);
    sums.batches = BatchCounts::from_array(batches);
    if passes[0] > passes[1] || sums.batches.passes() > passes[1] - passes[0] {
        let message = format!(
            "found passes {} to {}, of which {} in batches",
            passes[0],
            passes[1],
            sums.batches.passes()
        );
        return Err(InvalidArray::new("passes", message).into());
    }
    let [first, second] = sums.half_counts.0;
    if first.checked_add(second) != Some(passes[1] - passes[0]) {
        let message = format!("found {first} and {second} of {} passes", sums.count());
        return Err(InvalidArray::new("halves", message).into());
    }
    Ok(sums)
}

fn pixel_shape(film: &Film) -> [usize; 2] {
    let size = film.image_size().as_usizevec2();
    [size.y, size.x]
}

fn rgb_shape(film: &Film) -> [usize; 3] {
    let [height, width] = pixel_shape(film);
    [height, width, 3]
}

fn pixel_values<T: Copy + Default>(
    film: &Film,
    sums: &PassSums,
    value: impl Fn(&TileSums, usize) -> [T; 3],
) -> Vec<T> {
    let [height, width] = pixel_shape(film);
    let mut values = vec![T::default(); height * width * 3];
    for tile in &sums.tiles {
        for (i, pixel) in tile.tile.pixels().enumerate() {
            let start = (pixel.y as usize * width + pixel.x as usize) * 3;
            values[start..start + 3].copy_from_slice(&value(tile, i));
        }
    }
    values
}

fn set_pixels<T: Copy>(
    film: &Film,
    sums: &mut PassSums,
    values: &[T],
    place: impl Fn(&mut TileSums, usize) -> &mut [T; 3],
) {
    let [_, width] = pixel_shape(film);
    for tile in &mut sums.tiles {
        for (i, pixel) in tile.tile.pixels().enumerate() {
            let start = (pixel.y as usize * width + pixel.x as usize) * 3;
            place(tile, i).copy_from_slice(&values[start..start + 3]);
        }
    }
}

/// Coverage of each pixel by the id layer with index `k`, in row order.
fn coverage_in_rows<'f>(film: &Film, sums: &'f PassSums, k: usize) -> Vec<&'f CoverageSums> {
    const NONE: &CoverageSums = &CoverageSums::new();
    let [height, width] = pixel_shape(film);
    let mut pixels = vec![NONE; height * width];
    for tile in &sums.tiles {
        for (i, pixel) in tile.tile.pixels().enumerate() {
            pixels[pixel.y as usize * width + pixel.x as usize] =
                &tile.coverage[i * film.id_layers.len() + k];
        }
    }
    pixels
}

fn id_arrays<'f>(
    film: &'f Film,
    sums: &'f PassSums,
    k: usize,
    layer: IdLayer,
) -> [NamedArray<'f>; 3] {
    let name = layer.array_name();
    let pixels = move || coverage_in_rows(film, sums, k).into_iter();
    let count = pixels().map(|ids| ids.iter().len()).sum();
    let counts = move || pixels().map(|ids| ids.iter().len() as u32);
    let ids = move || pixels().flat_map(|ids| ids.iter().map(|(id, _)| *id));
    let weights = move || pixels().flat_map(|ids| ids.iter().map(|(_, weight)| *weight));
    [
        NamedArray::words(format!("{name}.count"), pixel_shape(film), counts),
        NamedArray::words(format!("{name}.id"), [count], ids),
        NamedArray::doubles(format!("{name}.weight"), [count], weights),
    ]
}

fn read_ids<E: From<InvalidArray>>(
    film: &Film,
    sums: &mut PassSums,
    k: usize,
    layer: IdLayer,
    read: &mut impl FnMut(&str, &[usize]) -> Result<ArrayValues, E>,
) -> Result<(), E> {
    let name = layer.array_name();
    let counts = read_words(read, &format!("{name}.count"), &pixel_shape(film))?;
    let total = counts.iter().map(|&count| count as usize).sum();
    let ids = read_words(read, &format!("{name}.id"), &[total])?;
    let weights = read_doubles(read, &format!("{name}.weight"), &[total])?;
    let [_, width] = pixel_shape(film);
    // Where the ids of each pixel start.
    let mut end = 0;
    let starts = counts.iter().map(|&count| {
        end += count as usize;
        end - count as usize
    });
    let starts: Vec<usize> = starts.collect();
    for tile in &mut sums.tiles {
        for (i, pixel) in tile.tile.pixels().enumerate() {
            let place = pixel.y as usize * width + pixel.x as usize;
            let coverage = &mut tile.coverage[i * film.id_layers.len() + k];
            for entry in starts[place]..starts[place] + counts[place] as usize {
                coverage.add(ids[entry], weights[entry]);
            }
        }
    }
    Ok(())
}

fn read_doubles<E: From<InvalidArray>>(
    read: &mut impl FnMut(&str, &[usize]) -> Result<ArrayValues, E>,
    name: &str,
    shape: &[usize],
) -> Result<Vec<f64>, E> {
    read_values(read, name, shape, ArrayKind::F64, |values| match values {
        ArrayValues::F64(values) => Ok(values),
        other => Err(other),
    })
}

fn read_floats<E: From<InvalidArray>>(
    read: &mut impl FnMut(&str, &[usize]) -> Result<ArrayValues, E>,
    name: &str,
    shape: &[usize],
) -> Result<Vec<f32>, E> {
    read_values(read, name, shape, ArrayKind::F32, |values| match values {
        ArrayValues::F32(values) => Ok(values),
        other => Err(other),
    })
}

fn read_words<E: From<InvalidArray>>(
    read: &mut impl FnMut(&str, &[usize]) -> Result<ArrayValues, E>,
    name: &str,
    shape: &[usize],
) -> Result<Vec<u32>, E> {
    read_values(read, name, shape, ArrayKind::U32, |values| match values {
        ArrayValues::U32(values) => Ok(values),
        other => Err(other),
    })
}

/// The values of the array `name` of this shape, of which `take` finds those of type `kind`.
fn read_values<T, E: From<InvalidArray>>(
    read: &mut impl FnMut(&str, &[usize]) -> Result<ArrayValues, E>,
    name: &str,
    shape: &[usize],
    kind: ArrayKind,
    take: impl FnOnce(ArrayValues) -> Result<Vec<T>, ArrayValues>,
) -> Result<Vec<T>, E> {
    let count = shape.iter().product();
    let values = read(name, shape)?;
    let invalid = |found: &ArrayValues| InvalidArray::unexpected(name, found, kind, count).into();
    if values.count() != count {
        return Err(invalid(&values));
    }
    take(values).map_err(|other| invalid(&other))
}

/// The values as an array of the length that was asked for.
fn array_of<T: Default + Copy, const N: usize>(values: Vec<T>) -> [T; N] {
    let mut array = [T::default(); N];
    array.copy_from_slice(&values);
    array
}
