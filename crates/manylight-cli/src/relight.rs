//! Light groups of a picture, weighed anew.
//!
//! The picture is the sum of its groups, so that other intensities and colors of the lights need no
//! render. The variance of a weighed sum needs the covariances of the groups, which a file does not
//! have: groups of one pixel share camera paths. The file has the variance of each group and that
//! of their sum. With one correlation for all pairs of groups of a pixel and channel,
//!
//! ```text
//! V(Σ c_g X_g) = Σ c_g² V_g + ρ ((Σ c_g σ_g)² - Σ c_g² V_g),   σ_g = √V_g,
//! ```
//!
//! the variance of the sum gives ρ. The result is exact for equal factors, and where one group
//! alone has light; in general it is an estimate, never above the bound (Σ c_g σ_g)².

use crate::failure::Failure;
use crate::picture::{GROUP_VARIANCE, RGB, full_name};
use crate::values::GroupWeight;
use manylight::film::Layer;
use manylight_io::image::{ImageLayer, LIGHT_GROUP, LayeredImage, is_combined, light_group};
use manylight_io::shown_path;
use manylight_lab::noise::{BLOCK_ERROR, ERROR, NOISY};
use rayon::prelude::*;
use std::path::Path;

/// Start of the names of metadata with the factors of a picture.
const FACTORS: &str = "relight.";
/// Light outside of all groups, relative to the picture, below which it counts as rounding.
const ROUNDING: f32 = 1e-4;

/// A light group of a picture.
struct Group<'i> {
    name: &'i str,
    /// Name of its layer.
    layer: &'i str,
    /// By channel.
    planes: [&'i [f32]; 3],
    /// By channel, if it is known.
    variances: Option<[&'i [f32]; 3]>,
    factors: [f32; 3],
}

/// What a picture is weighed for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RelitContent {
    /// The picture and all layers that can be kept.
    Layers,
    /// The picture alone, for files without layers.
    Picture,
}

/// The picture `image`, read from `path`, with other factors on the light of some groups. Layers
/// that the factors would change otherwise are left out.
///
/// # Errors
/// The picture has no light groups, or none of a name; or a group is named twice.
pub(crate) fn relight(
    path: &Path,
    image: &LayeredImage,
    weights: &[GroupWeight],
    content: RelitContent,
) -> Result<LayeredImage, Failure> {
    let groups = weighed(path, groups(image), weights)?;
    let name = beauty(image);
    let Some(total) = planes(image, name) else {
        let message = format!("{} has no picture, only layers", shown_path(path));
        return Err(Failure::usage(message, "give an exr file of a render"));
    };
    let sums = (0..3).map(|c| weighed_sum(&groups, total[c], c)).collect();
    let mut picture = layer(picture_name(name), sums);
    let alpha = full_name(picture_name(name), "A");
    if let Some(values) = image.channel(&alpha) {
        picture.channels.push((alpha, values.to_vec()));
    }
    let mut layers = vec![picture];
    if content == RelitContent::Layers {
        layers.extend(other_layers(image, name, &groups));
    }
    Ok(LayeredImage {
        layers,
        metadata: metadata(image, &groups),
        ..image_without_layers(image)
    })
}

/// The variance of the sum of the groups, which is the layer `beauty`, the groups, and the layers
/// that light does not change.
fn other_layers(image: &LayeredImage, beauty: &str, groups: &[Group]) -> Vec<ImageLayer> {
    let mut layers: Vec<ImageLayer> = Vec::new();
    let variance = planes(image, &beside(beauty, "variance"));
    if let Some(variance) = variance
        && groups.iter().all(|group| group.variances.is_some())
    {
        let of = |c: usize| weighed_variance(groups, variance[c], c);
        let variances = (0..3).map(of).collect();
        layers.push(layer(&beside(beauty, "variance"), variances));
    }
    for group in groups {
        let times = |planes: [&[f32]; 3], power: i32| {
            let plane = |c: usize| {
                let factor = group.factors[c].powi(power);
                planes[c].iter().map(|v| v * factor).collect()
            };
            (0..3).map(plane).collect()
        };
        layers.push(layer(group.layer, times(group.planes, 1)));
        if let Some(variances) = group.variances {
            let name = variance_name(group.layer);
            layers.push(layer(&name, times(variances, 2)));
        }
    }
    layers.extend(
        image
            .layers
            .iter()
            .filter(|layer| is_kept(&layer.name))
            .cloned(),
    );
    layers
}

/// The last part of the name of a layer, and what stands before it.
fn last_part(layer: &str) -> (&str, &str) {
    match layer.rfind('.') {
        Some(dot) => (&layer[dot + 1..], &layer[..=dot]),
        None => (layer, ""),
    }
}

/// The name of a layer in the same view layer as `layer`.
fn beside(layer: &str, name: &str) -> String {
    format!("{}{name}", last_part(layer).1)
}

/// The layer with the variance of a group.
fn variance_name(layer: &str) -> String {
    let (last, before) = last_part(layer);
    format!("{before}{GROUP_VARIANCE}{last}")
}

/// The layer that is the sum of the groups: of denoised pictures that with the noise.
fn beauty(image: &LayeredImage) -> &str {
    let names = || image.layers.iter().map(|layer| layer.name.as_str());
    let noisy = names().find(|name| last_part(name).0 == NOISY);
    let combined = || names().find(|name| is_combined(name));
    noisy.or_else(combined).unwrap_or("")
}

/// The name of the layer with the picture of a file in which `beauty` is the sum of the groups.
fn picture_name(beauty: &str) -> &str {
    let (last, _) = last_part(beauty);
    match last == NOISY {
        true => "",
        false => beauty,
    }
}

fn planes<'i>(image: &'i LayeredImage, layer: &str) -> Option<[&'i [f32]; 3]> {
    let [r, g, b] = [0, 1, 2].map(|c| image.channel(&full_name(layer, RGB[c])));
    Some([r?, g?, b?])
}

/// The light groups of a picture.
fn groups<'i>(image: &'i LayeredImage) -> Vec<Group<'i>> {
    let group = |layer: &'i ImageLayer| {
        Some(Group {
            name: light_group(&layer.name)?,
            layer: &layer.name,
            planes: planes(image, &layer.name)?,
            variances: planes(image, &variance_name(&layer.name)),
            factors: [1.0; 3],
        })
    };
    image.layers.iter().filter_map(group).collect()
}

/// `groups` with their factors.
fn weighed<'i>(
    path: &Path,
    mut groups: Vec<Group<'i>>,
    weights: &[GroupWeight],
) -> Result<Vec<Group<'i>>, Failure> {
    if groups.is_empty() {
        return Err(Failure::usage(
            format!("{} has no light groups", shown_path(path)),
            format!(
                "expected layers {LIGHT_GROUP}NAME, which `manylight render --light-groups` writes to exr files"
            ),
        ));
    }
    for (i, weight) in weights.iter().enumerate() {
        if weights[..i].iter().any(|other| other.name == weight.name) {
            return Err(Failure::usage(
                format!("--group: the group `{}` is given twice", weight.name),
                "give each group once",
            ));
        }
        match groups.iter_mut().find(|group| group.name == weight.name) {
            Some(group) => group.factors = weight.factors,
            None => {
                let names: Vec<&str> = groups.iter().map(|group| group.name).collect();
                return Err(Failure::usage(
                    format!("{} has no light group `{}`", shown_path(path), weight.name),
                    format!("its groups: {}", names.join(", ")),
                ));
            }
        }
    }
    Ok(groups)
}

/// The weighed sum of channel `c` of the groups, and the light of the picture that belongs to none.
fn weighed_sum(groups: &[Group], total: &[f32], c: usize) -> Vec<f32> {
    let pixel = |i: usize| {
        let (mut sum, mut weighed) = (0.0, 0.0);
        for group in groups {
            let value = group.planes[c][i];
            sum += value;
            weighed += group.factors[c] * value;
        }
        let rest = total[i] - sum;
        match rest.abs() > ROUNDING * total[i].abs() {
            true => weighed + rest,
            false => weighed,
        }
    };
    (0..total.len()).into_par_iter().map(pixel).collect()
}

/// The variance of that sum, of groups with variances, where their sum has the variance `total`.
fn weighed_variance(groups: &[Group], total: &[f32], c: usize) -> Vec<f32> {
    let planes: Vec<(&[f32], f32)> = groups
        .iter()
        .filter_map(|group| Some((group.variances?[c], group.factors[c])))
        .collect();
    let pixel = |i: usize| {
        let (mut deviations, mut variances) = (0.0f64, 0.0f64);
        let (mut weighed_deviations, mut weighed_variances) = (0.0f64, 0.0f64);
        for &(plane, factor) in &planes {
            let (variance, factor) = (f64::from(plane[i]), f64::from(factor));
            deviations += variance.sqrt();
            variances += variance;
            weighed_deviations += factor * variance.sqrt();
            weighed_variances += factor * factor * variance;
        }
        if !deviations.is_finite() {
            return f32::INFINITY;
        }
        let covariances = deviations * deviations - variances;
        let correlation = match covariances > 0.0 {
            true => ((f64::from(total[i]) - variances) / covariances).clamp(-1.0, 1.0),
            false => 0.0,
        };
        let covariances = weighed_deviations * weighed_deviations - weighed_variances;
        (weighed_variances + correlation * covariances).max(0.0) as f32
    };
    (0..total.len()).into_par_iter().map(pixel).collect()
}

fn layer(name: &str, planes: Vec<Vec<f32>>) -> ImageLayer {
    let names = RGB.iter().map(|channel| full_name(name, channel));
    ImageLayer {
        name: name.to_owned(),
        channels: names.zip(planes).collect(),
    }
}

/// Whether a layer is the same whatever the light: all but the picture, its terms, its variances
/// and its groups.
fn is_kept(name: &str) -> bool {
    let (last, _) = last_part(name);
    let depends = [
        "",
        "Combined",
        NOISY,
        "variance",
        "block_variance",
        ERROR,
        BLOCK_ERROR,
    ];
    let is_term = |layer: &Layer| {
        let depends = layer.is_term() || matches!(layer, Layer::CutSize | Layer::CutBound);
        depends && layer.name() == last
    };
    !depends.contains(&last)
        && light_group(name).is_none()
        && !last.starts_with(GROUP_VARIANCE)
        && !Layer::ALL.iter().any(is_term)
}

/// The metadata of the picture, without the noise of what it was, with the factors of all groups.
fn metadata(image: &LayeredImage, groups: &[Group]) -> Vec<(String, String)> {
    let is_noise = |name: &str| name == "batches" || name.starts_with("variance_of_mean");
    let mut metadata = image.metadata.clone();
    metadata.retain(|(name, _)| !is_noise(name));
    for group in groups.iter().filter(|group| group.factors != [1.0; 3]) {
        let name = format!("{FACTORS}{}", group.name);
        let before = image.metadata_value(&name);
        let before: Vec<f32> = (before.unwrap_or_default().split(' '))
            .filter_map(|word| word.parse().ok())
            .collect();
        let factor = |c: usize| group.factors[c] * before.get(c).copied().unwrap_or(1.0);
        let text = [0, 1, 2].map(|c| factor(c).to_string()).join(" ");
        metadata.retain(|(other, _)| *other != name);
        metadata.push((name, text));
    }
    metadata
}

fn image_without_layers(image: &LayeredImage) -> LayeredImage {
    LayeredImage {
        width: image.width,
        height: image.height,
        layers: Vec::new(),
        metadata: Vec::new(),
        window: image.window,
        camera: image.camera,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture of one pixel in view layer `view` with two groups; one channel counts.
    fn picture(view: &str, groups: [f32; 2], variances: [f32; 3]) -> LayeredImage {
        let pixel = |name: &str, value: f32| layer(&format!("{view}{name}"), vec![vec![value]; 3]);
        let combined = if view.is_empty() { "" } else { "Combined" };
        LayeredImage {
            width: 1,
            height: 1,
            layers: vec![
                pixel(combined, groups[0] + groups[1]),
                pixel("variance", variances[2]),
                pixel("direct", 1.0),
                pixel("normal", 0.5),
                pixel("Combined_key", groups[0]),
                pixel("variance_Combined_key", variances[0]),
                pixel("Combined_fill", groups[1]),
                pixel("variance_Combined_fill", variances[1]),
            ],
            ..LayeredImage::default()
        }
    }

    fn relit(image: &LayeredImage, weights: &[(&str, [f32; 3])]) -> Result<LayeredImage, Failure> {
        let weight = |&(name, factors): &(&str, [f32; 3])| GroupWeight {
            name: name.into(),
            factors,
        };
        let weights: Vec<_> = weights.iter().map(weight).collect();
        relight(Path::new("a.exr"), image, &weights, RelitContent::Layers)
    }

    #[test]
    fn groups_are_weighed_per_channel() {
        for (view, combined) in [("", ""), ("ViewLayer.", "ViewLayer.Combined")] {
            let image = picture(view, [2.0, 3.0], [0.4, 0.5, 0.9]);
            let relit = relit(&image, &[("key", [0.0, 1.0, 2.0])]).unwrap();
            let value = |name: &str, channel| relit.channel(&full_name(name, channel)).unwrap()[0];
            assert_eq!(
                RGB.iter().map(|c| value(combined, c)).collect::<Vec<_>>(),
                [3.0, 5.0, 7.0]
            );
            let key = format!("{view}Combined_key");
            assert_eq!(value(&key, "B"), 4.0);
            // Independent groups: the variance of the sum is the sum of the variances.
            let variance = format!("{view}variance");
            assert!((value(&variance, "R") - 0.5).abs() < 1e-6);
            assert!((value(&variance, "B") - (4.0 * 0.4 + 0.5)).abs() < 1e-5);
            assert!(relit.channel(&format!("{view}direct.R")).is_none());
            assert_eq!(value(&format!("{view}normal"), "R"), 0.5);
            assert_eq!(relit.metadata_value("relight.key"), Some("0 1 2"));
            // Weighing twice multiplies.
            let again = super::tests::relit(&relit, &[("key", [2.0; 3])]).unwrap();
            assert_eq!(again.metadata_value("relight.key"), Some("0 2 4"));
        }
    }

    #[test]
    fn equal_factors_scale_the_variance_of_the_picture() {
        // Correlated groups: σ are 1 and 2, the variance of the sum is 8.
        let image = picture("", [2.0, 3.0], [1.0, 4.0, 8.0]);
        let twice = relit(&image, &[("key", [2.0; 3]), ("fill", [2.0; 3])]).unwrap();
        assert!((twice.channel("variance.R").unwrap()[0] - 32.0).abs() < 1e-4);
        let one = relit(&image, &[("key", [0.0; 3])]).unwrap();
        assert!((one.channel("variance.R").unwrap()[0] - 4.0).abs() < 1e-5);
    }

    #[test]
    fn light_outside_of_all_groups_stays() {
        let mut image = picture("", [2.0, 3.0], [0.0; 3]);
        image.layers[0] = layer("", vec![vec![6.0]; 3]);
        let dark = relit(&image, &[("key", [0.0; 3]), ("fill", [0.0; 3])]).unwrap();
        assert_eq!(dark.channel("R").unwrap(), [1.0]);
    }

    #[test]
    fn unknown_groups_and_pictures_without_groups_are_refused() {
        let image = picture("", [2.0, 3.0], [0.0; 3]);
        for (image, weights) in [
            (&image, &[("rim", [1.0; 3])][..]),
            (&image, &[("key", [1.0; 3]), ("key", [2.0; 3])]),
            (&LayeredImage::default(), &[("key", [1.0; 3])]),
        ] {
            let failure = relit(image, weights).unwrap_err();
            assert_eq!(failure.exit_code(), 2, "{failure}");
        }
    }
}
