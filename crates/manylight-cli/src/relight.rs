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
use crate::picture::{
    DENOISED_GROUP, GROUP_VARIANCE, color_layer, derived_image, layers_without_light,
    metadata_without_noise, picture_layer, picture_name, planes, split_last_part,
};
use crate::values::GroupWeight;
use manylight_io::image::{ImageLayer, LIGHT_GROUP, LayeredImage, last_part, light_group};
use manylight_io::shown_path;
use manylight_lab::noise::{NOISY, VARIANCE};
use rayon::prelude::*;
use std::path::Path;

/// Start of the names of metadata with the factors of a picture.
const FACTORS: &str = "relight.";
/// Light outside of all groups, relative to the picture, below which it counts as rounding.
const ROUNDING: f32 = 1e-4;

/// Values of pixels, by channel.
type Planes<'i> = [&'i [f32]; 3];

/// A light group of a picture.
struct Group<'i> {
    name: &'i str,
    /// Name of its layer.
    layer: &'i str,
    /// By channel.
    planes: Planes<'i>,
    /// By channel, if it is known.
    variances: Option<Planes<'i>>,
    /// The light of the group in the denoised picture.
    denoised: Option<Planes<'i>>,
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
    let (sum, name) = (sum_of_groups(image), picture_name(image));
    let Some(total) = planes(image, sum) else {
        let message = format!("{} has no picture, only layers", shown_path(path));
        return Err(Failure::usage(message, "give an exr file of a render"));
    };
    let weighed = weighed_sum(
        groups.iter().map(|group| (group.planes, group.factors)),
        total,
    );
    // Without a layer `noisy`, the picture itself is the sum.
    let denoised = match sum == name {
        true => None,
        false => denoised_sum(&groups, image, name),
    };
    let (planes, noisy) = match denoised {
        Some(denoised) => (denoised, Some(color_layer(sum, weighed))),
        None => (weighed, None),
    };
    let mut layers = vec![picture_layer(image, planes)];
    if content == RelitContent::Layers {
        layers.extend(noisy);
        layers.extend(other_layers(image, sum, &groups));
    }
    Ok(derived_image(image, layers, metadata(image, &groups)))
}

/// The variance of the layer `sum`, the sum of the groups, then the groups, and the layers that
/// light does not change.
fn other_layers(image: &LayeredImage, sum: &str, groups: &[Group]) -> Vec<ImageLayer> {
    let mut layers: Vec<ImageLayer> = Vec::new();
    let variance = planes(image, &beside(sum, VARIANCE));
    if let Some(variance) = variance
        && groups.iter().all(|group| group.variances.is_some())
    {
        let of = |c: usize| weighed_variance(groups, variance[c], c);
        let variances = (0..3).map(of).collect();
        layers.push(color_layer(&beside(sum, VARIANCE), variances));
    }
    for group in groups {
        let times = |planes: Planes, power: i32| {
            let plane = |c: usize| {
                let factor = group.factors[c].powi(power);
                planes[c].iter().map(|v| v * factor).collect()
            };
            (0..3).map(plane).collect()
        };
        layers.push(color_layer(group.layer, times(group.planes, 1)));
        if let Some(variances) = group.variances {
            let name = prefixed(GROUP_VARIANCE, group.layer);
            layers.push(color_layer(&name, times(variances, 2)));
        }
        if let Some(denoised) = group.denoised {
            let name = prefixed(DENOISED_GROUP, group.layer);
            layers.push(color_layer(&name, times(denoised, 1)));
        }
    }
    layers.extend(layers_without_light(image));
    layers
}

/// The name of a layer in the same view layer as `layer`.
fn beside(layer: &str, name: &str) -> String {
    format!("{}{name}", split_last_part(layer).1)
}

/// The name of `layer` with `prefix` before its last part: that of another layer of the group.
fn prefixed(prefix: &str, layer: &str) -> String {
    let (last, before) = split_last_part(layer);
    format!("{before}{prefix}{last}")
}

/// The layer that is the sum of the groups: of denoised pictures that with the noise.
fn sum_of_groups(image: &LayeredImage) -> &str {
    let mut names = image.layers.iter().map(|layer| layer.name.as_str());
    let noisy = names.find(|name| last_part(name) == NOISY);
    noisy.unwrap_or_else(|| picture_name(image))
}

/// The light groups of a picture.
fn groups<'i>(image: &'i LayeredImage) -> Vec<Group<'i>> {
    let group = |layer: &'i ImageLayer| {
        Some(Group {
            name: light_group(&layer.name)?,
            layer: &layer.name,
            planes: planes(image, &layer.name)?,
            variances: planes(image, &prefixed(GROUP_VARIANCE, &layer.name)),
            denoised: planes(image, &prefixed(DENOISED_GROUP, &layer.name)),
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

/// The weighed sum of the groups in the denoised picture, the layer `name`; `None` if one is not
/// known.
fn denoised_sum(groups: &[Group], image: &LayeredImage, name: &str) -> Option<Vec<Vec<f32>>> {
    let parts = groups
        .iter()
        .map(|group| Some((group.denoised?, group.factors)));
    let parts: Vec<_> = parts.collect::<Option<_>>()?;
    Some(weighed_sum(parts.into_iter(), planes(image, name)?))
}

/// The weighed sum of parts of `total` with their factors, and of the light that belongs to none. By
/// channel.
fn weighed_sum<'i>(
    parts: impl Iterator<Item = (Planes<'i>, [f32; 3])>,
    total: Planes,
) -> Vec<Vec<f32>> {
    let parts: Vec<_> = parts.collect();
    let pixel = |c: usize, i: usize| {
        let (mut sum, mut weighed) = (0.0, 0.0);
        for (planes, factors) in &parts {
            let value = planes[c][i];
            sum += value;
            weighed += factors[c] * value;
        }
        let rest = total[c][i] - sum;
        match rest.abs() > ROUNDING * total[c][i].abs() {
            true => weighed + rest,
            false => weighed,
        }
    };
    let plane = |c: usize| {
        (0..total[c].len())
            .into_par_iter()
            .map(move |i| pixel(c, i))
    };
    (0..3).map(|c| plane(c).collect()).collect()
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

/// The metadata of the picture, without the noise of what it was, with the factors of all groups.
fn metadata(image: &LayeredImage, groups: &[Group]) -> Vec<(String, String)> {
    let mut metadata = metadata_without_noise(image);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::RGB;
    use manylight_io::image::full_name;

    /// A picture of one pixel in view layer `view` with two groups; one channel counts.
    fn picture(view: &str, groups: [f32; 2], variances: [f32; 3]) -> LayeredImage {
        let pixel =
            |name: &str, value: f32| color_layer(&format!("{view}{name}"), vec![vec![value]; 3]);
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
    fn denoised_groups_make_a_denoised_picture() {
        let mut image = picture("", [2.0, 3.0], [0.4, 0.5, 0.9]);
        let layer = |name: &str, value: f32| color_layer(name, vec![vec![value]; 3]);
        image.layers.extend([
            layer("noisy", 5.0),
            layer("denoised_Combined_key", 1.5),
            layer("denoised_Combined_fill", 2.5),
        ]);
        image.layers[0] = layer("", 4.0);
        let relit = relit(&image, &[("key", [2.0; 3])]).unwrap();
        let value = |name: &str| relit.channel(name).unwrap()[0];
        assert_eq!([value("R"), value("noisy.R")], [5.5, 7.0]);
        assert_eq!(value("denoised_Combined_key.G"), 3.0);
        assert!((value("variance.R") - (4.0 * 0.4 + 0.5)).abs() < 1e-5);
        // Of pictures without denoised groups, the sum with the noise is what is known.
        image.layers.pop();
        let relit = super::tests::relit(&image, &[("key", [2.0; 3])]).unwrap();
        assert_eq!(relit.channel("R").unwrap(), [7.0]);
        assert_eq!(relit.channel("noisy.R"), None);
    }

    #[test]
    fn light_outside_of_all_groups_stays() {
        let mut image = picture("", [2.0, 3.0], [0.0; 3]);
        image.layers[0] = color_layer("", vec![vec![6.0]; 3]);
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
