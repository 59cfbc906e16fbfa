//! The environment, which glTF files do not have, and light for files without any.

use super::super::options::{EnvironmentSource, GltfOptions};
use super::super::pixels::three_channels;
use super::json::Json;
use crate::file_error::FileErrorKind;
use crate::image::{Transfer, make_finite, read_image};
use manylight::color::Rgb;
use manylight::emitters::{Emitter, Environment};
use manylight::math::{Mat3, Vec3};
use manylight::scene::SceneDesc;
use manylight::texture::{ColorInput, Texture};

/// Adds the environment of the options. A scene without any emitter gets a white one.
pub(super) fn add(desc: &mut SceneDesc, root: &Json<'_>, options: &GltfOptions) {
    match &options.environment {
        Some(EnvironmentSource::White) => desc.emitters.push(Emitter::Constant {
            radiance: Rgb::splat(options.environment_scale),
        }),
        Some(EnvironmentSource::File(path)) => match read_image(path, Transfer::Auto) {
            Ok(mut image) => {
                root.reporter().note_read(path);
                if let Some(replaced) = make_finite(&mut image) {
                    let message = format!("in the environment {}, {replaced}", path.display());
                    root.warn_once("environment", message);
                }
                desc.emitters.push(Emitter::Environment(Environment {
                    image: three_channels(&image),
                    scale: options.environment_scale,
                    world_from_emitter: orientation(),
                }));
            }
            Err(error) => {
                let message = format!("cannot use the environment {error}");
                match error.kind {
                    FileErrorKind::NotFound | FileErrorKind::Unreadable(_) => {
                        root.reporter().file_error("", &message, None);
                    }
                    _ => root.error(message),
                }
            }
        },
        None => {}
    }
    if options.environment.is_none() {
        add_default(desc, root);
    }
}

/// Light for files without lights. Screens and labels emit by textures and are not meant to light a
/// scene; surfaces with an emission of one color may be.
fn add_default(desc: &mut SceneDesc, root: &Json<'_>) {
    let textures = &desc.textures;
    let emits_by_texture = |emitter: &Emitter| match emitter {
        Emitter::Area {
            radiance: ColorInput::Texture(id),
        } => !is_faded_color(&textures[id.index()]),
        _ => false,
    };
    if desc.emitters.iter().all(emits_by_texture) {
        root.warn_once(
            "no emitter",
            "the scene has neither lights nor surfaces that emit one color; a white environment of radiance 1 lights it (choose another by `--environment FILE`)",
        );
        desc.emitters.push(Emitter::Constant {
            radiance: Rgb::WHITE,
        });
    } else if desc
        .emitters
        .iter()
        .all(|emitter| matches!(emitter, Emitter::Area { .. }))
    {
        root.warn_once(
            "no lights",
            "emitting surfaces alone light the scene; `--environment white` or `--environment FILE` adds light from around",
        );
    }
}

/// Whether a texture is the emission of one color behind a mask: see
/// [`faded_radiance`](super::super::description::faded_radiance).
fn is_faded_color(texture: &Texture) -> bool {
    matches!(
        texture,
        Texture::Mix {
            second: ColorInput::Constant(_),
            ..
        }
    )
}

/// From the frame of the image to the world. The center of the image is +x and the quarter to its
/// right +z, as in Blender and three.js for the same image; the renderer's own frame has the center
/// at +z.
fn orientation() -> Mat3 {
    Mat3::from_cols(Vec3::NEG_Z, Vec3::Y, Vec3::X)
}
