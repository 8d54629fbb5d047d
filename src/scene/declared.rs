//! The parts of a scene as its file writes them, but for materials and textures: in f64 and in scene units, before flattening.

use std::collections::BTreeMap;

use clap::ValueEnum;
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::animation_frame::FPS;
use super::projection::Projection;
use crate::delta_light::{DeltaLight, Falloff};
use crate::error::{Error, Result};
use crate::material::LIGHT_GROUP;
use crate::shape::mesh::MeshShape;
use crate::shape::{self, Shape, ShapeKind};
use crate::source::declare::declare;
use crate::source::form::{Checked, Field, Form, PATH, colour, flag, integer, number, other, point, texture, vector};
use crate::source::{DEGREES, NO_UNIT, Range, SCENE_UNITS, ValuePath};
use crate::texture::{Colour, Texture, Use};
use crate::volume::{ANY_DENSITY, ANY_EMISSION, Density, Emission};

/// The most pixels of an image.
pub const LARGEST_AREA: u64 = 1 << 30;

const SIDE: Field = integer(1, 1 << 16);
const RADIANCE: Field = colour(Use::Radiance.range());
const ANGLE: Field = number(Range::from_to(0.0, 180.0), DEGREES);
const TURN: Field = number(Range::ANY, DEGREES);
const LENGTH: Field = number(Range::POSITIVE, SCENE_UNITS);

declare! {
    /// The size of the image: 2^30 pixels at most. `--size` overrides it.
    #[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
    #[serde(deny_unknown_fields)]
    pub struct ImageSize: image, "(width: 1200, height: 675)" {
        /// In pixels.
        width: u32 = SIDE;
        /// In pixels.
        height: u32 = SIDE;
    }
}

declare! {
    /// A camera with a thin lens.
    #[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
    #[serde(deny_unknown_fields)]
    pub struct Camera: camera,
        "(look_from: (13, 2, 3), look_at: (0, 0, 0), vertical_fov: 20, aperture: 0.1, focus_distance: 10)"
    {
        /// Where the camera is.
        look_from: DVec3 = point();
        /// What is in the middle of the image.
        look_at: DVec3 = point();
        /// The direction that is up in the image; not parallel to the view.
        #[serde(default = "up")]
        up: DVec3 = vector().or("(0, 1, 0)");
        /// The angle between the upper and the lower edge of the image: short for the projection `Perspective`.
        @default vertical_fov: Option<f64> = number(Range::between(0.0, 180.0), DEGREES).or("that of the projection");
        /// How directions are laid out on the image.
        @default projection: Option<Projection> = other(PROJECTION).or("`Perspective`, with `vertical_fov`");
        /// Whether the image is flipped left to right.
        @default mirror: bool = flag().or("false");
        /// The diameter of the lens; 0 is a pinhole, which shows everything sharp.
        #[serde(default)]
        aperture: f64 = number(Range::NOT_NEGATIVE, SCENE_UNITS).or("0");
        /// The distance from the lens to the plane that is sharp.
        #[serde(default)]
        focus_distance: Option<f64> = LENGTH.or("the distance to `look_at`");
        /// When the shutter opens and closes. What moves between these times is blurred.
        @default shutter: (f64, f64) = other("two numbers of seconds: (open, close)").or("(0, 0)");
        /// Where the camera is at which times, in place of `look_from` and `look_at`. Both points move straight from key to key. The times do
        /// not decrease; before the first key and behind the last one the camera rests.
        @default moving: Vec<(f64, CameraKey)> = other("a list of keys: [(seconds, (look_from: .., look_at: ..)), ..]").or("[]");
        ..
        /// The shares of the image's width and height around its middle that are rendered, if not all.
        #[serde(skip)]
        middle: Option<DVec2>
    }
}

declare! {
    /// Where a moving camera is at a time.
    #[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
    #[serde(deny_unknown_fields)]
    pub struct CameraKey: camera_key, "(look_from: (13, 2, 3), look_at: (0, 0, 0))" {
        look_from: DVec3 = camera::FIELDS.look_from;
        look_at: DVec3 = camera::FIELDS.look_at;
    }
}

/// What a projection is.
const PROJECTION: &str = "Perspective(..), Orthographic(..), Equirectangular(..), Fisheye(..) or Calibrated(..)";

impl Camera {
    /// How directions are laid out on the image. Checked cameras have a projection or the angle of one.
    pub fn projection(&self) -> Projection {
        let vertical_fov = self.vertical_fov.unwrap_or(DEFAULT_FOV);
        self.projection.clone().unwrap_or(Projection::Perspective { vertical_fov })
    }

    /// A pinhole that rests.
    pub fn pinhole(look_from: DVec3, look_at: DVec3, up: DVec3, vertical_fov: f64) -> Camera {
        Camera { look_from, look_at, up, vertical_fov: Some(vertical_fov), ..Camera::default() }
    }

    /// The camera whose shutter opens and closes so many seconds later.
    pub fn later(&self, seconds: f64) -> Camera {
        let (open, close) = self.shutter;
        Camera { shutter: (open + seconds, close + seconds), ..self.clone() }
    }

    /// The camera as it stands at a time, in seconds.
    pub fn at(&self, seconds: f64) -> Camera {
        let mut camera = self.clone();
        if let Some((before, after, share)) = keys_around(&self.moving, seconds) {
            camera.look_from = before.look_from.lerp(after.look_from, share);
            camera.look_at = before.look_at.lerp(after.look_at, share);
        }
        camera
    }
}

/// The keys before and after a time, and the share of the way from the first to the second. Before the first key and behind the last one,
/// both are that key. Of keys at one time, the last one counts from then on.
pub fn keys_around<T>(keys: &[(f64, T)], seconds: f64) -> Option<(&T, &T, f64)> {
    keys_beside(keys, keys.partition_point(|(time, _)| *time <= seconds), seconds)
}

/// As [`keys_around`], but of keys at this very time only the first one counts: where values jump, it is what they jump from.
pub fn keys_up_to<T>(keys: &[(f64, T)], seconds: f64) -> Option<(&T, &T, f64)> {
    keys_beside(keys, keys.partition_point(|(time, _)| *time < seconds), seconds)
}

/// The key of this index and the one before it, with the share of the way from the first to the second.
fn keys_beside<T>(keys: &[(f64, T)], next: usize, seconds: f64) -> Option<(&T, &T, f64)> {
    match (next.checked_sub(1).and_then(|last| keys.get(last)), keys.get(next)) {
        (Some((start, before)), Some((end, after))) => Some((before, after, (seconds - start) / (end - start))),
        (Some((_, only)), None) | (None, Some((_, only))) => Some((only, only, 0.0)),
        (None, None) => None,
    }
}

/// The angle of what is no camera of a file, in degrees.
const DEFAULT_FOV: f64 = 45.0;

fn up() -> DVec3 {
    DVec3::Y
}

declare! {
    #[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
    #[serde(deny_unknown_fields)]
    pub enum Background {
        /// A radiance that does not depend on the direction.
        Solid: solid, "Solid((0, 0, 0))" (
            /// The radiance.
            colour: Colour = RADIANCE;
        )
        /// A blend from straight down to straight up, by 0.5 (y + 1) of the ray's unit direction.
        Gradient: gradient, "Gradient(bottom: (1, 1, 1), top: (0.5, 0.7, 1))" {
            /// The radiance straight down.
            bottom: Colour = RADIANCE;
            /// The radiance straight up.
            top: Colour = RADIANCE;
        }
        /// A sky all around: an image of latitude and longitude, with +y at the top and -z in the middle.
        Image: sky, "Image(path: \"sky.exr\")" {
            /// A file of the same formats as the texture `Image`.
            path: String = other(PATH);
            /// What its colours are multiplied by.
            #[serde(default = "crate::texture::white", skip_serializing_if = "is_white")]
            tint: Colour = RADIANCE.or("(1, 1, 1)");
            /// How it is turned: rotations, applied in the order listed.
            @default by: Vec<Transform> = other("a list of transforms: [..]").or("[]");
            /// Octahedral: the square that pbrt-v4 has, with +z in the middle, +x at the right and +y below; texels are not blended.
            @default layout: SkyLayout = other("LatitudeLongitude or Octahedral").or("LatitudeLongitude");
        }
    }
}

/// How directions lie in the image of a sky.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum SkyLayout {
    #[default]
    LatitudeLongitude,
    Octahedral,
}

impl Checked for SkyLayout {}

declare! {
    #[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
    #[serde(deny_unknown_fields)]
    pub enum Transform {
        /// A shift.
        Translate: translate, "Translate((265, 0, 295))" (
            /// The shift, in scene units.
            by: DVec3 = vector();
        )
        /// A change of size around the origin.
        Scale: scale, "Scale(2)" (
            /// The factor, the same along all axes.
            scale: f64 = number(Range::POSITIVE, NO_UNIT);
        )
        /// A turn around the x axis: 90 takes +y to +z.
        RotateX: rotate_x, "RotateX(90)" (
            /// The angle.
            degrees: f64 = TURN;
        )
        /// A turn around the y axis: 90 takes +z to +x.
        RotateY: rotate_y, "RotateY(15)" (
            /// The angle.
            degrees: f64 = TURN;
        )
        /// A turn around the z axis: 90 takes +x to +y.
        RotateZ: rotate_z, "RotateZ(-18)" (
            /// The angle.
            degrees: f64 = TURN;
        )
        /// A turn around any axis through the origin, right-handed.
        Rotate: rotate, "Rotate(axis: (1, 1, 0), degrees: 45)" {
            /// The axis, of any length but 0.
            axis: DVec3 = vector();
            /// The angle.
            degrees: f64 = TURN;
        }
    }
}

/// The material of a shape, which is absent only on the boundary of a `Medium`.
const MATERIAL: Field = other("a material's name in quotes")
    .named("", "One of the scene's materials.")
    .or("none; only the boundary of a medium may leave it out");

declare! {
    /// An object of the scene.
    #[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
    #[serde(deny_unknown_fields)]
    pub enum Object {
        /// A sphere. Images on it have u = (atan2(-z, x) + π) / 2π and v = acos(-y) / π of the unit normal.
        Sphere: sphere, "Sphere(center: (0, 1, 0), radius: 1, material: \"matt\")" {
            /// The middle.
            center: DVec3 = point();
            /// The distance from the middle to the surface.
            radius: f64 = LENGTH;
            @default material: Option<String> = MATERIAL;
        }
        /// A parallelogram. Its normal is u × v.
        Quad: quad, "Quad(corner: (-1, 0, 0), u: (2, 0, 0), v: (0, 2, 0), material: \"matt\")" {
            /// One of its corners.
            corner: DVec3 = point();
            /// The edge from there to a neighbouring corner, in scene units; u of images.
            u: DVec3 = vector();
            /// The other edge, in scene units, not parallel to u; v of images.
            v: DVec3 = vector();
            @default material: Option<String> = MATERIAL;
        }
        /// A box along the axes; a transform turns it. Each face shows a whole image.
        Box: cuboid, "Box(min: (-1, 0, -1), max: (1, 2, 1), material: \"matt\")" {
            /// The corner with the lowest coordinates.
            min: DVec3 = point();
            /// The corner with the highest; each is above that of `min`.
            max: DVec3 = point();
            @default material: Option<String> = MATERIAL;
        }
        /// The triangles of a file. The outside of a triangle is where its corners run counter-clockwise. Without normals in the file it
        /// is flat-shaded. A file is read once, however many meshes name it.
        Mesh: mesh, "Mesh(path: \"meshes/star.ply\", material: \"matt\")" {
            /// A .ply, .obj, .stl, .gltf or .glb; materials in it are not used. Or a part of a file, such as
            /// `room.glb#meshes/0/primitives/1`, or `car.obj#materials/0`: the faces of one material.
            #[serde(skip_serializing)]
            path: String = other(PATH);
            @default material: Option<String> = MATERIAL;
        }
        /// A flat disk. Images fill the square around it: v is the direction that is nearest to +y, or -z where the normal is +y or -y,
        /// and u is v × normal.
        Disk: disk, "Disk(center: (0, 3, 0), normal: (0, -1, 0), radius: 0.5, material: \"matt\")" {
            /// The middle.
            center: DVec3 = point();
            /// The direction in which its front faces; of any length but 0.
            normal: DVec3 = vector();
            /// The distance from the middle to the edge.
            radius: f64 = LENGTH;
            @default material: Option<String> = MATERIAL;
        }
        /// A light without size that is equally bright in all directions. No ray can hit it, so the camera does not see it, nor does a
        /// mirror. Mirrors and glass stop its light, but smooth panes (`ThinDielectric`) let it pass: only light sampling finds it, and
        /// `--integrator bsdf` refuses it.
        PointLight: point_light, "PointLight(at: (0, 3, 1), intensity: (5, 5, 5))" {
            /// Where the light is.
            at: DVec3 = point();
            /// Power per solid angle. A surface that faces the light at a distance d gets the irradiance intensity / d². Transforms do not
            /// scale it.
            intensity: Colour = RADIANCE;
            /// The [group](compositing.md#light-groups) of its light.
            @default light_group: Option<String> = LIGHT_GROUP;
        }
        /// A `PointLight` with a beam.
        SpotLight: spot_light, "SpotLight(at: (0, 3, 1), towards: (0, 0, 0), intensity: (5, 5, 5), inner: 20, outer: 30)" {
            at: DVec3 = point_light::FIELDS.at;
            /// A point in the middle of its beam.
            towards: DVec3 = point();
            intensity: Colour = point_light::FIELDS.intensity;
            /// The angle from the middle of the beam up to which the light has its whole intensity; at most `outer`.
            @default inner: f64 = ANGLE.or("0");
            /// The angle from which on it has none.
            #[serde(default = "default_outer")]
            outer: f64 = ANGLE.or("45");
            /// `Gltf`: s², with s the share of the cosine between them. `Smooth`: s²(3 - 2s). `Linear`: the share of the angle.
            @default falloff: Falloff = other("Gltf, Linear or Smooth").or("Gltf");
            @default light_group: Option<String> = point_light::FIELDS.light_group;
        }
        /// A light so far away that it reaches everything from one direction, like a sun without size. What is said of a `PointLight`
        /// holds for it.
        DirectionalLight: directional_light, "DirectionalLight(direction: (1, -2, -1), irradiance: (3, 3, 3))" {
            /// Where the light goes, not where it comes from; of any length but 0.
            direction: DVec3 = vector();
            /// Power per area of a surface that faces the light, the same everywhere.
            irradiance: Colour = RADIANCE;
            @default light_group: Option<String> = point_light::FIELDS.light_group;
        }
        /// An object that is moved, turned or scaled.
        Transformed: transformed,
            "Transformed(
    by: [Scale(2), RotateY(15), Translate((265, 0, 295))],
    object: Box(min: (0, 0, 0), max: (1, 1, 1), material: \"matt\"),
)"
        {
            /// Applied in the order listed.
            by: Vec<Transform> = other("a list of transforms: [..]");
            /// Any object, also a group.
            object: Box<Object> = other("an object");
        }
        /// An object that moves. A propeller is a `RotateZ` from 0 to 3600.
        Moving: moving,
            "Moving(
    keys: [(0, [Translate((0, 0, 0))]), (1, [Translate((8, 0, 0))])],
    object: Sphere(center: (0, 1, 0), radius: 1, material: \"matt\"),
)"
        {
            /// Times in seconds, which do not decrease, each with the transforms of the object at that time, applied in the order listed. All keys
            /// have the same kinds of transforms in the same order. Each transform goes from its value in one key to that in the next at a
            /// constant pace: shifts, factors and degrees. A `Rotate` whose axes differ takes the shortest turn. Before the first key and
            /// behind the last one the object rests.
            keys: Vec<(f64, Vec<Transform>)> = other("a list of keys: [(seconds, [..]), ..]");
            /// Any object, also a group or one that moves.
            object: Box<Object> = other("an object");
        }
        /// Several objects as one.
        Group: group,
            "Group([
    Sphere(center: (0, 1, 0), radius: 1, material: \"matt\"),
    Sphere(center: (0, 2.5, 0), radius: 0.5, material: \"matt\"),
])"
        (
            /// The objects.
            objects: Vec<Object> = other("a list of objects: [..]").named("[..]", "");
        )
        /// An object with a name. The attribute `gpu-rt:objects` of an image lists the names, and a session of Python places objects by theirs.
        /// Several objects may have one name. Of an object inside another, the inner name counts.
        Named: named, "Named(name: \"ball\", object: Sphere(center: (0, 1, 0), radius: 1, material: \"matt\"))" {
            /// Its name.
            name: String = other("a name in quotes");
            /// Any object, also a group.
            object: Box<Object> = other("an object");
        }
        /// What the default scene of a glTF file has, with its materials and transforms, without its cameras. Its objects have the
        /// names of their nodes, and its materials the names `PATH#NAME` for other objects. [gltf.md](gltf.md) says what is read.
        Gltf: gltf, "Gltf(path: \"meshes/stool.glb\")" {
            /// A .gltf or .glb.
            #[serde(skip_serializing)]
            path: String = other(PATH);
            /// Whether its lights are in Blender's watts, which are divided by 683 lm/W.
            #[serde(default, skip_serializing)]
            watts: Option<bool> = flag().or("true for files by Blender, else false");
            /// Which glass is thin. Auto: glass of open meshes in files by Blender, as Blender renders it. Pane: glass without a
            /// thickness in the file, as glTF says.
            #[serde(default, skip_serializing)]
            thin: Thin = other("Auto or Pane").or("Auto");
            /// The frame of its animations, at frame / fps seconds.
            #[serde(default, skip_serializing)]
            frame: Option<f64> = number(Range::ANY, NO_UNIT).or("none: its rest pose");
            /// The frames of a second.
            #[serde(default = "default_fps", skip_serializing)]
            fps: f64 = number(Range::POSITIVE, NO_UNIT).or("24");
            .. #[serde(default, skip_deserializing)] objects: Vec<Object>
        }
        /// Fog, smoke, a cloud or fire inside a boundary, which itself is invisible. Where media overlap, their densities add. A
        /// medium whose boundary is also a glass surface fills the glass.
        Medium: medium,
            "Medium(boundary: Sphere(center: (0, 1, 0), radius: 5), density: 0.01, albedo: Rgb(1, 1, 1), anisotropy: 0)"
        {
            /// A Sphere, a Box or a closed Mesh, Transformed, Moving or not.
            @default boundary: Option<Box<Object>> = other("an object without a material").or("the box of a density that is a grid");
            /// The extinction coefficient: light falls to 1/e over a distance of 1 / density.
            density: Density = other(ANY_DENSITY);
            /// The scattered share of that light; the rest is absorbed. An `Image` is not allowed.
            albedo: Texture = texture(Use::Albedo.range());
            /// Henyey and Greenstein's g: above 0 most light is scattered forwards, below 0 back.
            @default anisotropy: f64 = number(Range::between(-1.0, 1.0), NO_UNIT).or("0");
            /// The radiance of what absorbs light there. Light sampling does not find it.
            @default emission: Option<Emission> = other(ANY_EMISSION).or("no emission");
        }
    }
}

impl Object {
    /// Its kind of shape; none for lights without size and for objects that contain others.
    pub fn kind(&self) -> Option<&'static ShapeKind> {
        shape::kinds_in_files().find(|(name, _)| *name == self.name()).map(|(_, kind)| kind)
    }

    /// The object without the names around it.
    pub fn unnamed(&self) -> &Object {
        match self {
            Object::Named { object, .. } => object.unnamed(),
            _ => self,
        }
    }

    /// The light without size that it is, if it is one.
    pub fn delta_light(&self) -> Option<DeltaLight> {
        match *self {
            Object::PointLight { at, intensity, .. } => Some(DeltaLight::Point { at, intensity }),
            Object::SpotLight { at, towards, intensity, inner, outer, falloff, .. } => {
                Some(DeltaLight::Spot { at, towards, intensity, inner, outer, falloff })
            }
            Object::DirectionalLight { direction, irradiance, .. } => {
                Some(DeltaLight::Directional { direction, irradiance })
            }
            _ => None,
        }
    }

    /// The group of its light, if it is a light without size.
    pub fn light_group(&self) -> Option<&str> {
        match self {
            Object::PointLight { light_group, .. }
            | Object::SpotLight { light_group, .. }
            | Object::DirectionalLight { light_group, .. } => light_group.as_deref(),
            _ => None,
        }
    }

    /// Its shape; none for lights without size, for objects that contain others, and for a mesh that is not in `meshes`.
    pub fn shape<'a>(&self, meshes: &'a BTreeMap<&str, MeshShape<'a>>) -> Option<Shape<'a>> {
        match self {
            Object::Sphere { center, radius, .. } => {
                Some(Shape::Sphere(shape::Sphere { center: *center, radius: *radius }))
            }
            Object::Quad { corner, u, v, .. } => Some(Shape::Quad(shape::Quad { corner: *corner, u: *u, v: *v })),
            Object::Box { min, max, .. } => Some(Shape::Cuboid(shape::Cuboid { min: *min, max: *max })),
            Object::Disk { center, normal, radius, .. } => {
                Some(Shape::Disk(shape::Disk { center: *center, normal: *normal, radius: *radius }))
            }
            Object::Mesh { path, .. } => meshes.get(path.as_str()).map(Shape::Mesh),
            _ => None,
        }
    }

    /// The name of the object's own material. Lights without size and objects that contain others have none.
    pub fn material(&self) -> Option<&str> {
        match self {
            Object::Sphere { material, .. }
            | Object::Quad { material, .. }
            | Object::Box { material, .. }
            | Object::Disk { material, .. }
            | Object::Mesh { material, .. } => material.as_deref(),
            _ => None,
        }
    }
}

fn is_white(tint: &Colour) -> bool {
    *tint == Colour::ONE
}

fn default_outer() -> f64 {
    45.0
}

fn default_fps() -> f64 {
    FPS
}

/// Which glass of a glTF file is thin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, ValueEnum)]
pub enum Thin {
    /// In files by Blender, glass whose mesh is open, as Blender renders it; in others, as `pane`.
    #[default]
    Auto,
    /// Glass to which the file gives no thickness, as glTF says.
    Pane,
}

impl Checked for Thin {}

declare! {
    /// Settings that the command line overrides.
    #[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct RenderDefaults: render, "(samples: 500, max_depth: 50)" {
        /// Samples per pixel; `--spp` overrides it.
        samples: u32 = integer(1, 1 << 31).or("100");
        /// The most scattering events of a path, on surfaces and in media; `--max-depth` overrides it.
        max_depth: u32 = integer(0, 1_000_000).or("50");
    }
}

impl Default for RenderDefaults {
    fn default() -> Self {
        RenderDefaults { samples: 100, max_depth: 50 }
    }
}
