//! From the scene, in f64 and scene units, to the arrays that the kernels read, in f32 and render space.
//!
//! Render space has the camera at the origin and is scaled by a power of two to an extent near 1, so that a scene looks
//! the same to the kernels however large it is and wherever it stands. Emission is scaled by a power of two likewise.

use std::collections::HashMap;

use glam::{DMat3, DVec3, Vec3};

use crate::bvh::{self, Bounds};
use crate::data::{self, MAX_PRIMITIVES, NO_TEXTURE, PRIMITIVE_BIT, PRIMITIVE_KIND_SHIFT};
use crate::error::Result;
use crate::scene::{Background, Bitmap, Camera, Material, Object, Scene, Texture, Transform};

/// The kinds of primitive by number; each is a file of shaders/geometry.
pub const PRIMITIVES: &[&str] = &["sphere", "quad", "cuboid"];
/// The kinds of material by number; each is a file of shaders/material.
pub const MATERIALS: &[&str] = &["lambertian", "metal", "dielectric", "diffuse_light"];
/// The kinds of texture by number; each is a file of shaders/texture.
pub const TEXTURES: &[&str] = &["checker", "image", "noise", "marble"];

/// What of the renderer a scene requires, and for each thing the scene's object that asked first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Features {
    /// By the numbers of `PRIMITIVES`.
    pub primitives: [Option<String>; PRIMITIVES.len()],
    /// By the numbers of `MATERIALS`: of materials on objects, not of all that are defined.
    pub materials: [Option<String>; MATERIALS.len()],
    /// By the numbers of `TEXTURES`.
    pub textures: [Option<String>; TEXTURES.len()],
    /// A file of shaders/background.
    pub background: &'static str,
    /// Whether the lens has a diameter.
    pub thin_lens: bool,
    /// Codes that wait at most in a walk through the BVH.
    pub stack_size: u32,
}

/// A scene as the kernels see it.
#[derive(Clone, Debug)]
pub struct Flat {
    pub features: Features,
    /// The camera, the background and the BVH's root; the rest is the render's to fill in.
    pub settings: data::Settings,
    pub nodes: Vec<data::Node>,
    pub spheres: Vec<data::Sphere>,
    pub quads: Vec<data::Quad>,
    pub cuboids: Vec<data::Cuboid>,
    pub materials: Vec<data::Material>,
    pub textures: Vec<data::Texture>,
    pub frames: Vec<data::Frame>,
    pub texels: Vec<[f32; 3]>,
    /// Device radiance times 2 to this power is the scene's radiance.
    pub radiance_exponent: i32,
}

/// A uniform scaling, then a rotation, then a translation.
#[derive(Clone, Copy)]
struct Similarity {
    scale: f64,
    rotation: DMat3,
    translation: DVec3,
}

impl Similarity {
    const IDENTITY: Similarity = Similarity { scale: 1.0, rotation: DMat3::IDENTITY, translation: DVec3::ZERO };

    fn new(transform: &Transform) -> Similarity {
        let rotate = |rotation| Similarity { rotation, ..Similarity::IDENTITY };
        match *transform {
            Transform::Translate(translation) => Similarity { translation, ..Similarity::IDENTITY },
            Transform::Scale(scale) => Similarity { scale, ..Similarity::IDENTITY },
            Transform::RotateX(degrees) => rotate(rotation_about(DVec3::X, degrees)),
            Transform::RotateY(degrees) => rotate(rotation_about(DVec3::Y, degrees)),
            Transform::RotateZ(degrees) => rotate(rotation_about(DVec3::Z, degrees)),
            Transform::Rotate { axis, degrees } => rotate(rotation_about(axis, degrees)),
        }
    }

    fn point(&self, p: DVec3) -> DVec3 {
        self.vector(p) + self.translation
    }

    fn vector(&self, v: DVec3) -> DVec3 {
        self.scale * (self.rotation * v)
    }

    /// First `inner`, then this.
    fn after(&self, inner: &Similarity) -> Similarity {
        Similarity {
            scale: self.scale * inner.scale,
            rotation: self.rotation * inner.rotation,
            translation: self.point(inner.translation),
        }
    }
}

/// Right-handed, by Rodrigues' formula. Quarter turns are exact: sines and cosines of degrees, not of rounded radians.
fn rotation_about(axis: DVec3, degrees: f64) -> DMat3 {
    // Normalised by its largest component first: the squares of a short axis would vanish.
    let axis = (axis / axis.abs().max_element()).normalize();
    let turn = degrees.rem_euclid(360.0);
    let (quarter, rest) = ((turn / 90.0).floor(), turn % 90.0);
    let (s, c) = rest.to_radians().sin_cos();
    let (s, c) = match quarter as i32 {
        1 => (c, -s),
        2 => (-s, -c),
        3 => (-c, s),
        _ => (s, c),
    };
    let column = |v: DVec3| v * c + axis.cross(v) * s + axis * (axis.dot(v) * (1.0 - c));
    DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
}

/// A primitive in world space, and what its texture needs to know of its own space.
struct Placed {
    shape: Shape,
    /// From the object's own space to the world.
    to_world: Similarity,
    material: u32,
}

/// In the object's own space.
#[derive(Clone, Copy)]
enum Shape {
    Sphere { center: DVec3, radius: f64 },
    Quad { corner: DVec3, u: DVec3, v: DVec3 },
    Cuboid { min: DVec3, max: DVec3 },
}

impl Shape {
    /// Number among `PRIMITIVES`.
    fn kind(&self) -> usize {
        match self {
            Shape::Sphere { .. } => 0,
            Shape::Quad { .. } => 1,
            Shape::Cuboid { .. } => 2,
        }
    }
}

/// Flattens a scene for an image of `size` pixels.
///
/// # Errors
/// `Error::Scene` where there are more primitives than a code can name.
pub fn flatten(scene: &Scene, size: (u32, u32)) -> Result<Flat> {
    let numbers: HashMap<&str, u32> = (0..).zip(&scene.materials).map(|(i, (name, _))| (name.as_str(), i)).collect();
    let mut features = Features::default();
    let mut placed = Vec::new();
    for (i, object) in scene.objects.iter().enumerate() {
        let first = placed.len();
        place(object, &numbers, &Similarity::IDENTITY, &mut placed);
        for primitive in &placed[first..] {
            note(&mut features, scene, i, primitive);
        }
    }
    if placed.len() >= MAX_PRIMITIVES {
        return Err(scene.error(&[], format!("{} primitives, expected fewer than {MAX_PRIMITIVES}", placed.len())));
    }

    let camera = &scene.camera;
    let length_exponent = binary_exponent(extent(camera, &placed));
    let space = RenderSpace { eye: camera.look_from, scale: exp2(-length_exponent) };
    let radiance_exponent = binary_exponent(brightest(scene));
    let radiance_scale = exp2(-radiance_exponent);

    let mut flat = Flat {
        features,
        settings: data::Settings::default(),
        nodes: Vec::new(),
        spheres: Vec::new(),
        quads: Vec::new(),
        cuboids: Vec::new(),
        materials: Vec::new(),
        textures: Vec::new(),
        frames: Vec::new(),
        texels: Vec::new(),
        radiance_exponent,
    };
    flat.settings = camera_settings(camera, &space, size);
    flat.add_background(scene, radiance_scale);
    flat.add_materials(scene, radiance_scale);
    let mut bounds = Vec::with_capacity(placed.len());
    let mut codes = Vec::with_capacity(placed.len());
    for (order, primitive) in placed.iter().enumerate() {
        let index = flat.add_primitive(primitive, scene, &space, order as u32, &mut bounds);
        codes.push(PRIMITIVE_BIT | (primitive.shape.kind() as u32) << PRIMITIVE_KIND_SHIFT | index as u32);
    }
    let bvh = bvh::build(&bounds, &codes, bvh::Quality::default());
    flat.settings.root = bvh.root;
    flat.nodes = bvh.nodes;
    flat.features.stack_size = bvh.stack_size.max(1);
    flat.features.thin_lens = camera.aperture > 0.0;
    Ok(flat)
}

/// Notes what a primitive requires.
fn note(features: &mut Features, scene: &Scene, object: usize, primitive: &Placed) {
    let (name, material) = &scene.materials[primitive.material as usize];
    let asked = |slot: &mut Option<String>, what: &dyn Fn() -> String| {
        if slot.is_none() {
            *slot = Some(what());
        }
    };
    let at_object = || scene.object_location(object).to_string();
    let at_material = || format!("\"{name}\" at {}", scene.material_location(name));
    asked(&mut features.primitives[primitive.shape.kind()], &at_object);
    asked(&mut features.materials[material_kind(material)], &at_material);
    if let Some(kind) = colour_texture(material).and_then(texture_kind) {
        asked(&mut features.textures[kind], &at_material);
    }
}

/// Appends the primitives of an object. Media and meshes have been refused when the scene was read.
fn place(object: &Object, numbers: &HashMap<&str, u32>, to_world: &Similarity, placed: &mut Vec<Placed>) {
    let mut push = |shape, material: &Option<String>| {
        let number = material.as_ref().and_then(|name| numbers.get(name.as_str()).copied());
        placed.extend(number.map(|material| Placed { shape, to_world: *to_world, material }));
    };
    match object {
        Object::Sphere { center, radius, material } => {
            push(Shape::Sphere { center: *center, radius: *radius }, material);
        }
        Object::Quad { corner, u, v, material } => {
            push(Shape::Quad { corner: *corner, u: *u, v: *v }, material);
        }
        Object::Box { min, max, material } => {
            push(Shape::Cuboid { min: *min, max: *max }, material);
        }
        Object::Transformed { by, object } => {
            let own = by.iter().fold(Similarity::IDENTITY, |done, next| Similarity::new(next).after(&done));
            place(object, numbers, &to_world.after(&own), placed);
        }
        Object::Group(objects) => {
            objects.iter().for_each(|object| place(object, numbers, to_world, placed));
        }
        Object::Mesh { .. } | Object::Medium { .. } => {}
    }
}

/// The farthest that anything reaches from the eye along an axis; 1 where there is nothing.
fn extent(camera: &Camera, placed: &[Placed]) -> f64 {
    let reach = |primitive: &Placed| {
        let Placed { to_world, .. } = primitive;
        let from_eye = |p: DVec3| (to_world.point(p) - camera.look_from).abs().max_element();
        match primitive.shape {
            Shape::Sphere { center, radius } => from_eye(center) + to_world.scale * radius,
            Shape::Quad { corner, u, v } => {
                [corner, corner + u, corner + v, corner + u + v].into_iter().fold(0.0, |far, p| from_eye(p).max(far))
            }
            Shape::Cuboid { min, max } => from_eye(0.5 * (min + max)) + to_world.scale * (0.5 * (max - min)).length(),
        }
    };
    let far = placed.iter().map(reach).fold(0.5 * camera.aperture, f64::max);
    if far > 0.0 { far } else { 1.0 }
}

/// The largest component of anything that shines; 1 where nothing does.
fn brightest(scene: &Scene) -> f64 {
    let bitmap = |path: &String| scene.bitmaps.get(path).map_or(0.0, brightest_texel);
    let sky = match &scene.background {
        Background::Solid(colour) => colour.max_element(),
        Background::Gradient { bottom, top } => bottom.max(*top).max_element(),
        Background::Image { path } => bitmap(path),
    };
    let light = |(_, material): &(String, Material)| match material {
        Material::DiffuseLight { emit, .. } => match emit {
            Texture::Rgb(r, g, b) => r.max(*g).max(*b),
            Texture::Checker { even, odd, .. } => even.max(*odd).max_element(),
            Texture::Image { path } => bitmap(path),
            Texture::Noise { .. } | Texture::Marble { .. } => 1.0,
        },
        _ => 0.0,
    };
    let most = scene.materials.iter().map(light).fold(sky, f64::max);
    if most > 0.0 { most } else { 1.0 }
}

fn brightest_texel(bitmap: &Bitmap) -> f64 {
    bitmap.texels.iter().flatten().fold(0.0, |most, &x| f64::from(x).max(most))
}

/// The least e with x < 2^e, for a normal x > 0.
fn binary_exponent(x: f64) -> i32 {
    const BIAS: i32 = 1022;
    ((x.to_bits() >> 52) & 0x7ff) as i32 - BIAS
}

/// 2^e, exactly.
fn exp2(e: i32) -> f64 {
    2.0_f64.powi(e)
}

/// The camera at the origin and lengths scaled by a power of two.
struct RenderSpace {
    eye: DVec3,
    scale: f64,
}

impl RenderSpace {
    fn point(&self, p: DVec3) -> DVec3 {
        (p - self.eye) * self.scale
    }
}

fn f32s(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

fn camera_settings(camera: &Camera, space: &RenderSpace, (width, height): (u32, u32)) -> data::Settings {
    let unit = |v: DVec3| (v / v.abs().max_element()).normalize();
    let backward = unit(camera.look_from - camera.look_at);
    let right = unit(unit(camera.up).cross(backward));
    let up = backward.cross(right);
    let pixel = 2.0 * (0.5 * camera.vertical_fov).to_radians().tan() / f64::from(height);
    let focus = camera.focus_distance.unwrap_or((camera.look_at - camera.look_from).length());
    let lens_radius = 0.5 * camera.aperture * space.scale;
    data::Settings {
        forward: f32s(-backward),
        image_width: width,
        pixel_x: f32s(pixel * right),
        image_height: height,
        pixel_y: f32s(-pixel * up),
        lens_x: f32s(lens_radius * right),
        lens_y: f32s(lens_radius * up),
        inverse_focus: (1.0 / (focus * space.scale)) as f32,
        ..data::Settings::default()
    }
}

/// Number among `MATERIALS`.
fn material_kind(material: &Material) -> usize {
    match material {
        Material::Lambertian { .. } => 0,
        Material::Metal { .. } => 1,
        Material::Dielectric { .. } => 2,
        Material::DiffuseLight { .. } => 3,
    }
}

/// Number among `TEXTURES`; nothing for a plain colour, which is the material's own.
fn texture_kind(texture: &Texture) -> Option<usize> {
    match texture {
        Texture::Rgb(..) => None,
        Texture::Checker { .. } => Some(0),
        Texture::Image { .. } => Some(1),
        Texture::Noise { .. } => Some(2),
        Texture::Marble { .. } => Some(3),
    }
}

fn colour_texture(material: &Material) -> Option<&Texture> {
    match material {
        Material::Lambertian { albedo } | Material::Metal { albedo, .. } => Some(albedo),
        Material::DiffuseLight { emit, .. } => Some(emit),
        Material::Dielectric { .. } => None,
    }
}

impl Flat {
    fn add_background(&mut self, scene: &Scene, radiance_scale: f64) {
        let settings = &mut self.settings;
        match &scene.background {
            Background::Solid(colour) => {
                self.features.background = "solid";
                settings.background_bottom = f32s(radiance_scale * *colour);
            }
            Background::Gradient { bottom, top } => {
                self.features.background = "gradient";
                settings.background_bottom = f32s(radiance_scale * *bottom);
                settings.background_top = f32s(radiance_scale * *top);
            }
            Background::Image { path } => {
                self.features.background = "image";
                settings.background_bottom = [radiance_scale as f32; 3];
                if let Some(bitmap) = scene.bitmaps.get(path) {
                    settings.background_width = bitmap.width;
                    settings.background_height = bitmap.height;
                    self.texels.extend_from_slice(&bitmap.texels);
                }
            }
        }
    }

    fn add_materials(&mut self, scene: &Scene, radiance_scale: f64) {
        for (_, material) in &scene.materials {
            let brightness = match material {
                Material::DiffuseLight { .. } => radiance_scale,
                _ => 1.0,
            };
            let mut flat = data::Material {
                kind: material_kind(material) as u32,
                texture: NO_TEXTURE,
                ..data::Material::default()
            };
            match material {
                Material::Lambertian { .. } => {}
                Material::Metal { fuzz, .. } => flat.parameter = *fuzz as f32,
                Material::Dielectric { ior } => {
                    let inside = 1.0 / ior;
                    flat.parameter = *ior as f32;
                    flat.contrast_outside = ((ior - 1.0) * (ior + 1.0)) as f32;
                    flat.contrast_inside = ((inside - 1.0) * (inside + 1.0)) as f32;
                }
                Material::DiffuseLight { two_sided, .. } => flat.parameter = f32::from(u8::from(*two_sided)),
            }
            match colour_texture(material) {
                Some(Texture::Rgb(r, g, b)) => flat.colour = f32s(brightness * DVec3::new(*r, *g, *b)),
                Some(texture) => flat.texture = self.add_texture(scene, texture, brightness),
                None => {}
            }
            self.materials.push(flat);
        }
    }

    fn add_texture(&mut self, scene: &Scene, texture: &Texture, brightness: f64) -> u32 {
        let mut flat = data::Texture {
            first: f32s(DVec3::splat(brightness)),
            kind: texture_kind(texture).unwrap_or_default() as u32,
            ..data::Texture::default()
        };
        match texture {
            Texture::Checker { even, odd, .. } => {
                flat.first = f32s(brightness * *even);
                flat.second = f32s(brightness * *odd);
            }
            Texture::Marble { scale } => flat.parameter = *scale as f32,
            Texture::Image { path } => {
                if let Some(bitmap) = scene.bitmaps.get(path) {
                    flat.texel = self.texels.len() as u32;
                    flat.width = bitmap.width;
                    flat.height = bitmap.height;
                    self.texels.extend_from_slice(&bitmap.texels);
                }
            }
            Texture::Rgb(..) | Texture::Noise { .. } => {}
        }
        self.textures.push(flat);
        self.textures.len() as u32 - 1
    }

    /// Adds a primitive and its bounds; the result is its index among its kind.
    fn add_primitive(
        &mut self,
        primitive: &Placed,
        scene: &Scene,
        space: &RenderSpace,
        order: u32,
        bounds: &mut Vec<Bounds>,
    ) -> usize {
        let Placed { shape, to_world, material } = primitive;
        let texture = colour_texture(&scene.materials[*material as usize].1);
        let frame = texture.and_then(|texture| frame(texture, shape, &to_world.rotation)).map_or(0, |frame| {
            self.frames.push(frame);
            self.frames.len() as u32 - 1
        });
        let vector = |v: DVec3| to_world.vector(v) * space.scale;
        match *shape {
            Shape::Sphere { center, radius } => {
                let center = space.point(to_world.point(center)).as_vec3();
                let radius = (to_world.scale * radius * space.scale) as f32;
                bounds.push(padded(center - radius, center + radius, error_bound(&[center, Vec3::splat(radius)])));
                self.spheres.push(data::Sphere {
                    center: center.to_array(),
                    radius,
                    order,
                    material: *material,
                    frame,
                    padding: 0,
                });
                self.spheres.len() - 1
            }
            Shape::Quad { corner, u, v } => {
                let corner = space.point(to_world.point(corner));
                let (u, v) = (vector(u), vector(v));
                let (normal, a_axis, b_axis) = quad_axes(u, v);
                let corners = [corner, corner + u, corner + v, corner + u + v].map(|p| p.as_vec3());
                let low = corners.iter().fold(corners[0], |low, p| low.min(*p));
                let high = corners.iter().fold(corners[0], |high, p| high.max(*p));
                let error = error_bound(&[corner.as_vec3(), u.as_vec3(), v.as_vec3()]);
                bounds.push(padded(low, high, error));
                self.quads.push(data::Quad {
                    corner: f32s(corner),
                    order,
                    normal: f32s(normal),
                    material: *material,
                    a_axis: f32s(a_axis),
                    frame,
                    b_axis: f32s(b_axis),
                    error,
                    u: f32s(u),
                    v: f32s(v),
                    ..data::Quad::default()
                });
                self.quads.len() - 1
            }
            Shape::Cuboid { min, max } => {
                let center = space.point(to_world.point(0.5 * (min + max))).as_vec3();
                let half = (0.5 * (max - min) * to_world.scale * space.scale).as_vec3();
                let axes = to_world.rotation;
                let reach = half.x * axes.x_axis.as_vec3().abs()
                    + half.y * axes.y_axis.as_vec3().abs()
                    + half.z * axes.z_axis.as_vec3().abs();
                let error = error_bound(&[center, Vec3::splat(half.x + half.y + half.z)]);
                bounds.push(padded(center - reach, center + reach, error));
                self.cuboids.push(data::Cuboid {
                    center: center.to_array(),
                    order,
                    half_extent: half.to_array(),
                    material: *material,
                    x_axis: f32s(axes.x_axis),
                    frame,
                    y_axis: f32s(axes.y_axis),
                    error,
                });
                self.cuboids.len() - 1
            }
        }
    }
}

/// A bound of the rounding of a point that is a sum of such vectors, and of the tests made with it: eight roundings of
/// the largest coordinates that can occur on the way.
fn error_bound(summands: &[Vec3]) -> f32 {
    const UNIT_ROUNDOFF: f32 = f32::EPSILON / 2.0;
    8.0 * UNIT_ROUNDOFF * summands.iter().map(|v| v.abs().max_element()).sum::<f32>()
}

fn padded(min: Vec3, max: Vec3, by: f32) -> Bounds {
    Bounds { min: min - by, max: max + by }
}

/// The unit normal u × v, and the vectors whose products with a point's offset from the corner are the point's a and b.
/// Computed on u and v scaled to unit length, so that neither tiny nor needle-like quads lose digits.
fn quad_axes(u: DVec3, v: DVec3) -> (DVec3, DVec3, DVec3) {
    let (u_length, v_length) = (u.length(), v.length());
    let (u, v) = (u / u_length, v / v_length);
    let n = u.cross(v);
    let w = n / n.length_squared();
    (n.normalize(), v.cross(w) / u_length, w.cross(u) / v_length)
}

/// The frame of a texture on a shape: the point p(local) = base + columns · local in the object's own space, in the
/// texture's units, its base reduced by the texture's period in f64. A plain colour needs none.
fn frame(texture: &Texture, shape: &Shape, rotation: &DMat3) -> Option<data::Frame> {
    let to_object = rotation.transpose();
    let (base, columns) = match *shape {
        Shape::Sphere { center, radius } => (center, to_object * radius),
        Shape::Quad { corner, u, v } => (corner, DMat3::from_cols(u, v, DVec3::ZERO)),
        Shape::Cuboid { min, max } => (min, DMat3::from_diagonal(max - min)),
    };
    let (base, columns, phase) = match *texture {
        Texture::Rgb(..) => return None,
        Texture::Checker { scale, .. } => (reduce(base / scale, 2.0), columns * (1.0 / scale), 0.0),
        Texture::Noise { scale } => (reduce(base * scale, 256.0), columns * scale, 0.0),
        Texture::Marble { scale } => {
            (reduce(base, 256.0), columns, reduce(DVec3::splat(base.z * scale), std::f64::consts::TAU).z)
        }
        Texture::Image { .. } => (DVec3::ZERO, to_object, 0.0),
    };
    Some(data::Frame {
        x: f32s(columns.x_axis),
        phase: phase as f32,
        y: f32s(columns.y_axis),
        z: f32s(columns.z_axis),
        origin: f32s(base),
        ..data::Frame::default()
    })
}

/// Each coordinate less whole periods, within half a period of zero.
fn reduce(v: DVec3, period: f64) -> DVec3 {
    v - period * (v / period).round()
}
