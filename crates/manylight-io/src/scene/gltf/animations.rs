//! Animated cameras: the transforms of nodes over time. All animations of a file play at once.
//!
//! Source: "glTF 2.0 Specification", Khronos Group, sections 3.11 and appendix C.

use super::accessors::{Accessors, Allowed, FLOAT, QUANTIZED};
use super::json::Json;
use super::nodes::{Hierarchy, local_transform};
use glam::{DMat4, DQuat, DVec3, DVec4};
use std::cell::Cell;
use std::collections::HashMap;

/// Components of rotations.
const ROTATION: Allowed = Allowed {
    normalized: true,
    ..QUANTIZED
};
/// Most transforms of nodes, over all frames of all cameras: a bound of the work that a file from a
/// stranger can ask for. A camera below ten nodes may have a million frames.
const MAX_TRANSFORMS: f64 = 1e7;

/// The animated transforms of the cameras and of the nodes above them.
#[derive(Default)]
pub(super) struct CameraAnimations {
    /// By index of the node.
    tracks: HashMap<usize, NodeTracks>,
    /// The last time of all, in s.
    end: f64,
    /// Transforms of nodes so far.
    transforms: Cell<f64>,
}

/// What moves a node. Parts without a track are as in the node.
#[derive(Default)]
struct NodeTracks {
    translation: Option<Track>,
    rotation: Option<Track>,
    scale: Option<Track>,
}

impl CameraAnimations {
    /// The animations of a document. Warns of those of other nodes.
    pub(super) fn read<'a>(hierarchy: &Hierarchy<'a>, accessors: &Accessors<'a, '_>) -> Self {
        let document = accessors.document;
        let mut animations = CameraAnimations::default();
        let above_cameras = hierarchy.above(|node| node.json.has("camera"));
        for animation in document.root.objects("animations") {
            let samplers = animation.objects("samplers");
            for channel in animation.objects("channels") {
                let Some(target) = channel.required_member("target") else {
                    continue;
                };
                let node = target.index("node", "nodes", document.nodes.len());
                let Some(node) = node.filter(|&node| above_cameras[node]) else {
                    channel.warn_once(
                        "animations",
                        "animations of objects are ignored; they stand in the pose of their nodes",
                    );
                    continue;
                };
                let sampler = channel.index("sampler", "samplers", samplers.len());
                if let Some(sampler) = sampler {
                    animations.add((&target, node), &samplers[sampler], accessors);
                }
            }
        }
        animations
    }

    /// Adds a channel.
    fn add<'a>(
        &mut self,
        (target, node): (&Json<'a>, usize),
        sampler: &Json<'a>,
        accessors: &Accessors<'a, '_>,
    ) {
        let path = target
            .check_given("path")
            .and_then(|()| target.string("path"));
        let Some(path) = path else {
            return;
        };
        // Of morph targets, which cameras do not have.
        if path == "weights" {
            return;
        }
        let tracks = self.tracks.entry(node).or_default();
        let (track, kind) = match path {
            "translation" => (&mut tracks.translation, "VEC3"),
            "rotation" => (&mut tracks.rotation, "VEC4"),
            "scale" => (&mut tracks.scale, "VEC3"),
            other => {
                let expected = "`translation`, `rotation`, `scale` or `weights`";
                target.unexpected("path", format!("`{other}`"), expected);
                return;
            }
        };
        if track.is_some() {
            target.warn_once(
                "animated twice",
                format!("several channels set the {path} of this node; the last one counts"),
            );
        }
        *track = Track::read(sampler, kind, accessors);
        let end = track.as_ref().and_then(|track| track.times.last().copied());
        self.end = self.end.max(end.unwrap_or(0.0));
    }

    /// The transforms from a node to the world, frame by frame from time 0 on at `fps` frames per
    /// second; empty if nothing moves it.
    pub(super) fn frames(&self, hierarchy: &Hierarchy, node: usize, fps: f32) -> Vec<DMat4> {
        if self.tracks.is_empty() || self.transforms.get() > MAX_TRANSFORMS {
            return Vec::new();
        }
        let chain = hierarchy.chain(node);
        // Times are rounded to 32 bits.
        let last = match chain.iter().any(|(node, _)| self.tracks.contains_key(node)) {
            true => (self.end * f64::from(fps) + 1e-3).floor(),
            false => -1.0,
        };
        let transforms = self.transforms.get() + (last + 2.0) * chain.len() as f64;
        self.transforms.set(transforms);
        if let Some((_, json)) = chain.last().filter(|_| transforms > MAX_TRANSFORMS) {
            let frames = last + 1.0;
            json.error(format!(
                "the animations take {frames} frames at {fps} per second: found {transforms:.1e} transforms of nodes, expected at most {MAX_TRANSFORMS:.0e}"
            ));
        }
        if last < 0.0 || transforms > MAX_TRANSFORMS {
            return Vec::new();
        }
        let frame = |index: u32| {
            let time = f64::from(index) / f64::from(fps);
            let local = |(node, json): &(usize, &Json)| self.local(*node, json, time);
            chain.iter().map(local).product()
        };
        (0..=last as u32).map(frame).collect()
    }

    /// The transform from a node to its parent.
    fn local(&self, node: usize, json: &Json, time: f64) -> DMat4 {
        let at_rest = local_transform(json).unwrap_or_default();
        let Some(tracks) = self.tracks.get(&node) else {
            return at_rest;
        };
        let (mut scale, mut rotation, mut translation) = at_rest.to_scale_rotation_translation();
        if let Some(track) = &tracks.translation {
            translation = track.at(time, DVec4::lerp).truncate();
        }
        if let Some(track) = &tracks.rotation {
            let turned = track.at(time, |a, b, u| {
                DVec4::from(DQuat::from_vec4(a).slerp(DQuat::from_vec4(b), u))
            });
            rotation = DQuat::from_vec4(turned.normalize_or(DVec4::W));
        }
        if let Some(track) = &tracks.scale {
            scale = track.at(time, DVec4::lerp).truncate();
        }
        DMat4::from_scale_rotation_translation(scale, rotation, translation)
    }
}

/// How values between key frames follow from them.
#[derive(Clone, Copy, PartialEq)]
enum Interpolation {
    Linear,
    Step,
    /// Each key frame has the tangent before it, its value, and the tangent after it.
    CubicSpline,
}

/// A value over time.
struct Track {
    /// Ascending, in s.
    times: Vec<f64>,
    /// Vectors with a last component of 0, or quaternions.
    values: Vec<DVec4>,
    interpolation: Interpolation,
}

impl Track {
    /// Of a sampler with outputs of the type `kind`; `None` if it is invalid, which is reported.
    fn read<'a>(sampler: &Json<'a>, kind: &str, accessors: &Accessors<'a, '_>) -> Option<Self> {
        sampler.check_given("input")?;
        sampler.check_given("output")?;
        let (input, output) = (sampler.get("input")?, sampler.get("output")?);
        let times: Vec<[f32; 1]> = accessors.floats(&input, "SCALAR", FLOAT)?;
        let times: Vec<f64> = times.into_iter().map(|[time]| f64::from(time)).collect();
        let values: Vec<DVec4> = match kind {
            "VEC3" => {
                let values: Vec<[f32; 3]> = accessors.floats(&output, kind, FLOAT)?;
                let vector = |[x, y, z]: [f32; 3]| DVec3::new(x.into(), y.into(), z.into());
                values.into_iter().map(|v| vector(v).extend(0.0)).collect()
            }
            _ => {
                let values: Vec<[f32; 4]> = accessors.floats(&output, kind, ROTATION)?;
                values
                    .into_iter()
                    .map(|v| DVec4::from(v.map(f64::from)))
                    .collect()
            }
        };
        let interpolation = match sampler.string("interpolation") {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::CubicSpline,
            Some(other) => {
                let expected = "LINEAR, STEP or CUBICSPLINE";
                sampler.unexpected("interpolation", format!("`{other}`"), expected);
                return None;
            }
        };
        if times.is_empty() || !times.is_sorted_by(|a, b| a < b) {
            sampler.error_at("input", "expected one time or more, in ascending order");
            return None;
        }
        let per_time = match interpolation {
            Interpolation::CubicSpline => 3,
            _ => 1,
        };
        if values.len() != per_time * times.len() {
            let expected = format!("{} for {} times", per_time * times.len(), times.len());
            sampler.unexpected("output", format!("{} values", values.len()), &expected);
            return None;
        }
        Some(Track {
            times,
            values,
            interpolation,
        })
    }

    /// The value at a time; `mix` interpolates linearly.
    fn at(&self, time: f64, mix: impl Fn(DVec4, DVec4, f64) -> DVec4) -> DVec4 {
        let value = |key: usize| match self.interpolation {
            Interpolation::CubicSpline => self.values[3 * key + 1],
            _ => self.values[key],
        };
        let after = self.times.partition_point(|&key| key <= time);
        if after == 0 || after == self.times.len() {
            return value(after.saturating_sub(1));
        }
        let before = after - 1;
        let length = self.times[after] - self.times[before];
        let u = (time - self.times[before]) / length;
        match self.interpolation {
            Interpolation::Step => value(before),
            Interpolation::Linear => mix(value(before), value(after), u),
            Interpolation::CubicSpline => {
                let (u2, u3) = (u * u, u * u * u);
                let (leaving, arriving) = (self.values[3 * before + 2], self.values[3 * after]);
                value(before) * (2.0 * u3 - 3.0 * u2 + 1.0)
                    + leaving * (length * (u3 - 2.0 * u2 + u))
                    + value(after) * (3.0 * u2 - 2.0 * u3)
                    + arriving * (length * (u3 - u2))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(interpolation: Interpolation, values: &[f64]) -> Track {
        Track {
            times: vec![1.0, 3.0],
            values: values.iter().map(|&x| DVec4::X * x).collect(),
            interpolation,
        }
    }

    #[test]
    fn values_between_key_frames() {
        let linear = track(Interpolation::Linear, &[2.0, 6.0]);
        let step = track(Interpolation::Step, &[2.0, 6.0]);
        // Tangents of 1 and 3 per second: x = 2 + t + t² / 2 over two seconds.
        let cubic = track(Interpolation::CubicSpline, &[0.0, 2.0, 1.0, 3.0, 6.0, 0.0]);
        for (time, expected) in [
            (0.0, [2.0, 2.0, 2.0]),
            (1.5, [3.0, 2.0, 2.625]),
            (2.5, [5.0, 2.0, 4.625]),
            (3.0, [6.0, 6.0, 6.0]),
            (9.0, [6.0, 6.0, 6.0]),
        ] {
            for (track, expected) in [&linear, &step, &cubic].into_iter().zip(expected) {
                let found = track.at(time, DVec4::lerp).x;
                assert!(
                    (found - expected).abs() < 1e-9,
                    "{found} for {expected} at {time}"
                );
            }
        }
    }
}
