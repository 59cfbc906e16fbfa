//! Point lights whose intensity is an image.

use super::super::super::assets::Decode;
use super::super::super::description::{Additions, bitmap, rotation, set_image};
use super::super::super::parameters::{Numbers, Parameters};
use super::super::super::pixels::{luminance, pick};
use super::super::builder::Builder;
use super::super::entities::Entity;
use super::environment::latitude_longitude;
use crate::image::Transfer;
use manylight::emitters::{Emitter, ProjectorTexture, SpotFalloff};
use manylight::ids::{EmitterId, TextureId};
use manylight::image::Image;
use manylight::math::{Mat3, Vec2, Vec3};
use manylight::scene::SceneDesc;
use manylight::texture::{Bitmap, Filtering, Texture, Wrap};
use std::f32::consts::PI;

impl Builder<'_> {
    /// A point light with an intensity by direction. PBRT turns its map's z axis to y.
    pub(super) fn goniometric(&mut self, entity: &Entity<'_>) {
        let params = &entity.params;
        let intensity = self.emission(entity, "I");
        let world = self.world_from(entity);
        let position = world.translation.into();
        let Some(name) = params.string(Self::map_parameter(entity)) else {
            let factor = self.power_factor(entity, "power", 4.0 * PI);
            self.desc.add(Emitter::Point {
                position,
                intensity: intensity * factor,
            });
            return;
        };
        let Some(path) = entity.find_file(name, "intensity map") else {
            return;
        };
        let wrap = [Wrap::Repeat, Wrap::Clamp];
        let map = bitmap(Filtering::Bilinear, wrap, Mat3::IDENTITY);
        let distribution = self.desc.add(map);
        let map_from_local = Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::Y);
        let emitter = self.desc.add(Emitter::Goniometric {
            position,
            intensity,
            emitter_from_world: map_from_local * rotation(world.matrix3.into()).transpose(),
            distribution,
        });
        let power = params.maybe_float("power");
        let is_v3 = self.is_v3;
        let store = move |desc: &mut SceneDesc, image: Image| {
            let photometry = Photometry::new(&image, is_v3);
            if let Emitter::Goniometric { intensity, .. } = &mut desc.emitters[emitter.index()]
                && let Some(power) = power.filter(|power| *power > 0.0)
            {
                *intensity *= power / (4.0 * PI * photometry.mean);
            }
            if let Texture::Bitmap(bitmap) = &mut desc.textures[distribution.index()] {
                photometry.store(bitmap);
            }
        };
        let decode = Decode::Color(Transfer::Auto);
        self.assets.add_image_use(path, decode, name.span, store);
    }

    /// A spot light that projects an image.
    pub(super) fn projection(&mut self, entity: &Entity<'_>) {
        let params = &entity.params;
        let intensity = self.emission(entity, "I");
        let inside = |angle| angle > 0.0 && angle < 180.0;
        let default = if self.is_v3 { 45.0 } else { 90.0 };
        let fov = params.float_where("fov", default, inside, "in (0, 180)");
        let power = params.maybe_float("power");
        let Some(name) = params.required_string(Self::map_parameter(entity)) else {
            return;
        };
        let Some(path) = entity.find_file(name, "projected image") else {
            return;
        };
        let world = self.world_from(entity);
        let axes = rotation(world.matrix3.into());
        let slide = bitmap(Filtering::Nearest, [Wrap::Clamp; 2], Mat3::IDENTITY);
        let texture = self.desc.add(slide);
        let emitter = self.desc.add(Emitter::Spot {
            position: world.translation.into(),
            direction: axes.z_axis,
            intensity,
            cutoff: PI / 4.0,
            beam_width: PI / 4.0,
            falloff: SpotFalloff::SmoothCosine,
            // The axes of images grow to the right and down.
            projector: Some(ProjectorTexture {
                texture,
                axes: [axes.x_axis, -axes.y_axis],
                window: Some(Vec2::ONE),
            }),
        });
        let store = move |desc: &mut SceneDesc, image: Image| {
            let slide = Slide::new(image, (0.5 * fov).to_radians().tan());
            slide.store(desc, emitter, texture, power);
        };
        let decode = Decode::Color(Transfer::Auto);
        self.assets.add_image_use(path, decode, name.span, store);
    }
}

/// The intensity of a goniometric light as a latitude-longitude map.
struct Photometry {
    map: Image,
    /// Whether the first and the last row lie at the poles.
    has_poles: bool,
    /// Mean over the pixels of the file, as which PBRT takes the mean over directions.
    mean: f32,
}

impl Photometry {
    /// PBRT v4 has equal-area octahedral maps, PBRT v3 latitude-longitude maps. Colors count by
    /// their luminance.
    fn new(file: &Image, is_v3: bool) -> Self {
        let gray = pick(&luminance(file, |v| v), &[0; 3]);
        let mean = gray.data.iter().sum::<f32>() / gray.data.len().max(1) as f32;
        let has_poles = !is_v3 && file.width == file.height;
        Photometry {
            map: if has_poles {
                latitude_longitude(&gray)
            } else {
                gray
            },
            has_poles,
            mean: mean.max(f32::MIN_POSITIVE),
        }
    }

    fn store(self, bitmap: &mut Bitmap) {
        if self.has_poles {
            // From v over the rows' centers to v over their edges.
            let rows = self.map.height as f32;
            let scale = Vec3::Y * ((rows - 1.0) / rows);
            let offset = Vec3::new(0.0, 0.5 / rows, 1.0);
            bitmap.uv_transform = Mat3::from_cols(Vec3::X, scale, offset);
        }
        bitmap.image = self.map;
    }
}

/// An image on the plane at distance 1 from a projector.
struct Slide {
    image: Image,
    /// Half the width and half the height of the image on the plane.
    half: Vec2,
}

impl Slide {
    /// The shorter edge spans `tan_half_fov` on each side.
    fn new(image: Image, tan_half_fov: f32) -> Self {
        let aspect = image.width as f32 / image.height as f32;
        let half = Vec2::new(aspect.max(1.0), (1.0 / aspect).max(1.0)) * tan_half_fov;
        Slide { image, half }
    }

    /// Stores the image in `texture`, and cone and power of the spot that projects it.
    fn store(
        self,
        desc: &mut SceneDesc,
        emitter: EmitterId,
        texture: TextureId,
        power: Option<f32>,
    ) {
        if let Emitter::Spot {
            intensity,
            cutoff,
            beam_width,
            projector,
            ..
        } = &mut desc.emitters[emitter.index()]
        {
            *cutoff = self.half.length().atan();
            if let Some(projector) = projector {
                projector.window = Some(self.half);
            }
            *beam_width = *cutoff;
            if let Some(power) = power.filter(|power| *power > 0.0) {
                *intensity *= power / self.luminous_power();
            }
        }
        set_image(&mut desc.textures, texture, self.image);
    }

    /// Luminous power of the intensity that the image gives.
    fn luminous_power(&self) -> f32 {
        let (width, height) = (self.image.width, self.image.height);
        let position =
            |i: usize, n: usize, half: f32| (2.0 * (i as f32 + 0.5) / n as f32 - 1.0) * half;
        let mut sum = 0.0_f64;
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let p = Vec3::new(
                position(x, width, self.half.x),
                position(y, height, self.half.y),
                1.0,
            );
            let solid_angle = p.length().powi(-3);
            sum += f64::from(self.image.rgb(x, y).luminance() * solid_angle);
        }
        let area = 4.0 * self.half.x * self.half.y;
        (sum / (width * height) as f64) as f32 * area
    }
}
