//! Meshes and images of a scene. Requests are collected first; then the files are read in parallel,
//! each one once.

use super::attributes::AttributeRequest;
use super::curve_files::CurveFile;
use super::description::{add, set_environment, set_image};
use super::pixels::{of_size, pick, three_channels};
use super::sink::{FileSpan, Problem, Sink};
use crate::file_error::FileError;
use crate::image::{NotFinite, Transfer, make_finite, read_alpha, read_image};
use crate::mesh::{
    MeshAttribute, MeshFormat, orient_to_normals, read_mesh as read_file, smooth_normals_placed,
};
use manylight::geometry::{Mesh, Shape};
use manylight::ids::{EmitterId, ShapeId, TextureId};
use manylight::image::Image;
use manylight::math::Affine3A;
use manylight::scene::SceneDesc;
use rayon::prelude::*;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The channels of an image that a texture uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Channel {
    All,
    Index(usize),
    Alpha,
}

impl Channel {
    /// Values of the parameter `channel`.
    pub(super) const NAMES: [(&'static str, Channel); 8] = [
        ("r", Channel::Index(0)),
        ("g", Channel::Index(1)),
        ("b", Channel::Index(2)),
        ("x", Channel::Index(0)),
        ("y", Channel::Index(1)),
        ("z", Channel::Index(2)),
        ("a", Channel::Alpha),
        ("", Channel::All),
    ];
}

/// A mesh file to read, and how to process it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MeshRequest {
    pub(super) path: PathBuf,
    pub(super) content: MeshContent,
    /// Whether v is replaced by 1 - v.
    pub(super) flip_v: bool,
    pub(super) normals: Normals,
}

/// What a mesh file contains.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum MeshContent {
    Mesh(MeshFormat),
    Curves(CurveFile),
}

/// The shading normals of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Normals {
    /// None: faces are flat.
    Faceted,
    /// Those of the file, or smooth ones if it has none.
    Smooth {
        /// The transform to world space if it changes angles or mirrors, else the identity.
        placement: Affine3A,
    },
    /// Those of the file, or none. With normals, every triangle is wound so that its geometric
    /// normal is on their side.
    Stored {
        /// Whether the transform to world space mirrors.
        mirrored: bool,
    },
}

/// The part of an image file to read.
#[derive(Clone, Copy, Debug)]
pub(super) enum Decode {
    /// One or three color channels.
    Color(Transfer),
    /// The alpha channel; 1 if the file has none.
    Alpha,
    /// One channel, as PBRT's float textures read it: alpha if the file has one that is not 1
    /// everywhere, else the mean of the color channels.
    Float(Transfer),
}

/// What to do with an image that has been read.
type ImageUse = Box<dyn FnOnce(&mut SceneDesc, Image)>;

/// What to do after all files have been read.
pub(super) type Finish = Box<dyn FnOnce(&mut SceneDesc)>;

/// An image file to read, and its uses.
struct ImageRequest {
    path: PathBuf,
    decode: Decode,
    span: FileSpan,
    uses: Vec<ImageUse>,
}

/// The files to read for a scene. Equal requests share one entry.
#[derive(Default)]
pub(super) struct Assets {
    meshes: Vec<(MeshRequest, ShapeId, FileSpan)>,
    mesh_ids: HashMap<(PathBuf, String), ShapeId>,
    attributes: Vec<AttributeRequest>,
    images: Vec<ImageRequest>,
    image_ids: HashMap<(PathBuf, String), usize>,
}

impl Assets {
    /// Requests a mesh, and returns its shape, which is added to `shapes` for the first of equal
    /// requests.
    pub(super) fn mesh(
        &mut self,
        request: MeshRequest,
        span: FileSpan,
        shapes: &mut Vec<Shape>,
    ) -> ShapeId {
        let (content, normals) = (&request.content, request.normals);
        let settings = format!("{content:?} {} {normals:?}", request.flip_v);
        let key = (request.path.clone(), settings);
        *self.mesh_ids.entry(key).or_insert_with(|| {
            let shape = add(shapes, Shape::Mesh(Mesh::default()));
            self.meshes.push((request, shape, span));
            shape
        })
    }

    /// Requests the values of an attribute of a mesh. They go into a texture that is stored
    /// already.
    pub(super) fn add_attribute(&mut self, request: AttributeRequest) {
        self.attributes.push(request);
    }

    /// Whether the shape is a mesh of a file.
    pub(super) fn is_mesh_file(&self, shape: ShapeId) -> bool {
        self.meshes.iter().any(|(_, id, _)| *id == shape)
    }

    /// Requests the image of a bitmap texture.
    pub(super) fn add_texture_image(
        &mut self,
        texture: TextureId,
        path: PathBuf,
        transfer: Transfer,
        channel: Channel,
        span: FileSpan,
    ) {
        let decode = if channel == Channel::Alpha {
            Decode::Alpha
        } else {
            Decode::Color(transfer)
        };
        self.add_image_use(path, decode, span, move |desc, image| {
            set_image(&mut desc.textures, texture, select(image, channel));
        });
    }

    /// Requests the image of an environment emitter.
    pub(super) fn add_environment_image(
        &mut self,
        emitter: EmitterId,
        path: PathBuf,
        span: FileSpan,
    ) {
        let decode = Decode::Color(Transfer::Auto);
        self.add_image_use(path, decode, span, move |desc, image| {
            set_environment(desc, emitter, three_channels(&image));
        });
    }

    /// Requests an image for a use that the caller defines.
    pub(super) fn add_image_use(
        &mut self,
        path: PathBuf,
        decode: Decode,
        span: FileSpan,
        image_use: impl FnOnce(&mut SceneDesc, Image) + 'static,
    ) {
        let key = (path.clone(), format!("{decode:?}"));
        let index = *self.image_ids.entry(key).or_insert_with(|| {
            self.images.push(ImageRequest {
                path,
                decode,
                span,
                uses: Vec::new(),
            });
            self.images.len() - 1
        });
        self.images[index].uses.push(Box::new(image_use));
    }

    /// Reads all files and stores their content in `desc`. Errors are reported.
    pub(super) fn load(self, desc: &mut SceneDesc, sink: &Sink) {
        let Assets {
            meshes,
            images,
            attributes,
            ..
        } = self;
        let paths = (meshes.iter().map(|(request, ..)| &request.path))
            .chain(images.iter().map(|request| &request.path));
        paths.for_each(|path| sink.note_read(path));
        let files: Vec<(&Path, Decode)> = images
            .iter()
            .map(|request| (request.path.as_path(), request.decode))
            .collect();
        let (read_meshes, read_images): (Vec<_>, Vec<_>) = rayon::join(
            || {
                meshes
                    .par_iter()
                    .map(|(request, shape, _)| {
                        read_mesh(request, attributes.iter().any(|a| a.shape == *shape))
                    })
                    .collect()
            },
            || files.par_iter().map(read_pixels).collect(),
        );
        for ((_, shape, span), mesh) in meshes.iter().zip(read_meshes) {
            match mesh {
                Ok((mesh, found)) => {
                    let wanted = attributes.iter().filter(|a| a.shape == *shape);
                    wanted.for_each(|a| a.store(desc, &mesh, &found, sink));
                    desc.shapes[shape.index()] = Shape::Mesh(mesh);
                }
                Err(error) => report(sink, *span, &error, "mesh"),
            }
        }
        for (request, image) in images.into_iter().zip(read_images) {
            match image {
                Ok((image, replaced)) => {
                    if let Some(replaced) = replaced {
                        report_replaced(sink, request.span, &request.path, &replaced);
                    }
                    distribute(desc, request.uses, image);
                }
                Err(error) => report(sink, request.span, &error, "image"),
            }
        }
    }
}

/// The mesh of a request, and its attributes if they are wanted.
fn read_mesh(
    request: &MeshRequest,
    attributes: bool,
) -> Result<(Mesh, Vec<MeshAttribute>), FileError> {
    let (mut mesh, attributes) = match &request.content {
        MeshContent::Mesh(format) => read_file(&request.path, *format, attributes)?,
        MeshContent::Curves(curves) => (curves.read(&request.path)?, Vec::new()),
    };
    if request.flip_v {
        mesh.uvs.iter_mut().for_each(|uv| uv.y = 1.0 - uv.y);
    }
    match request.normals {
        Normals::Faceted => mesh.normals = Vec::new(),
        Normals::Smooth { placement } if mesh.normals.is_empty() => {
            smooth_normals_placed(&mut mesh, &placement)
        }
        Normals::Smooth { .. } => {}
        Normals::Stored { mirrored } => orient_to_normals(&mut mesh, mirrored),
    }
    Ok((mesh, attributes))
}

/// The pixels of an image, all of them finite, and what was replaced for that.
fn read_pixels(&(path, decode): &(&Path, Decode)) -> Result<(Image, Option<NotFinite>), FileError> {
    let mut image = decoded(path, decode)?;
    let replaced = make_finite(&mut image);
    Ok((image, replaced))
}

fn decoded(path: &Path, decode: Decode) -> Result<Image, FileError> {
    match decode {
        Decode::Color(transfer) => read_image(path, transfer),
        Decode::Alpha => read_alpha(path),
        Decode::Float(transfer) => {
            let alpha = read_alpha(path)?;
            if alpha.data.iter().any(|&v| v != 1.0) {
                return Ok(alpha);
            }
            read_image(path, transfer).map(|image| mean_of_channels(&image))
        }
    }
}

/// The mean of the channels of every pixel.
fn mean_of_channels(image: &Image) -> Image {
    let pixels = image.data.chunks_exact(image.channels);
    let means = pixels.map(|pixel| pixel.iter().sum::<f32>() / pixel.len() as f32);
    of_size(image, 1, means.collect())
}

fn report_replaced(sink: &Sink, span: FileSpan, path: &Path, replaced: &NotFinite) {
    let message = format!("in the image file {}, {replaced}", path.display());
    let problem = Problem::new("scene::not_finite", span, message);
    sink.warn(problem.label("this image file".to_owned()));
}

fn report(sink: &Sink, span: FileSpan, error: &FileError, what: &str) {
    let message = format!("cannot use the {what} file {error}");
    let problem = Problem::new("scene::broken_file", span, message);
    let problem = problem.label(format!("this {what} file"));
    sink.error(problem.caused_by(error));
}

/// Stores an image for all of its uses, without copying it for the last one.
fn distribute(desc: &mut SceneDesc, mut uses: Vec<ImageUse>, image: Image) {
    let last = uses.pop();
    for image_use in uses {
        image_use(desc, image.clone());
    }
    if let Some(last) = last {
        last(desc, image);
    }
}

/// The channels that a texture uses.
fn select(image: Image, channel: Channel) -> Image {
    match (channel, image.channels) {
        (Channel::All | Channel::Alpha, _) => image,
        (Channel::Index(_), 1) => image,
        (Channel::Index(index), _) => pick(&image, &[index]),
    }
}
