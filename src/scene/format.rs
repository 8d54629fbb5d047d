//! The forms of the scene file by what they are.

use super::declared::{camera, camera_key, image, render};
use super::projection::{Distortion, Projection};
use super::types::{Background, Material, Object, Texture, Transform};
use crate::source::form::{Form, other};
use crate::volume::{Heat, Varying};

pub const SCENE: Form = Form {
    name: "Scene",
    about: "The whole file.",
    fields: &[
        other("(width: .., height: ..)").named("image", "The size of the image."),
        other("(look_from: .., look_at: .., vertical_fov: ..)").named("camera", "Where the camera is, and its lens."),
        other("a background: Solid((r, g, b)), Gradient(bottom: .., top: ..) or Image(path: ..)")
            .named("background", "The radiance of rays that hit nothing."),
        other("a map of materials: {\"name\": Lambertian(..), ..}")
            .named("materials", "The materials, by the names that objects give.")
            .or("{}"),
        other("a list of objects: [..]").named("objects", "What is in the scene."),
        other("(samples: .., max_depth: ..)")
            .named("render", "Settings that the command line overrides.")
            .or("(samples: 100, max_depth: 50)"),
    ],
    in_order: false,
    example: "Scene(
    image: (width: 320, height: 180),
    camera: (look_from: (0, 2, 8), look_at: (0, 1, 0), vertical_fov: 30),
    background: Solid((0.5, 0.7, 1)),
    materials: { \"matt\": Lambertian(albedo: Rgb(0.7, 0.3, 0.2)) },
    objects: [ Sphere(center: (0, 1, 0), radius: 1, material: \"matt\") ],
)",
};

/// All forms by what they are, in the order of docs/scene.md. A name may stand for two of them, which are written alike.
pub fn groups() -> [(&'static str, &'static [Form]); 10] {
    [
        ("Scene", &[SCENE, image::FORM, camera::FORM, render::FORM, camera_key::FORM]),
        ("Projections", Projection::FORMS),
        ("Distortions", Distortion::FORMS),
        ("Backgrounds", Background::FORMS),
        ("Materials", Material::FORMS),
        ("Textures", Texture::FORMS),
        ("Objects", Object::FORMS),
        ("Densities", Varying::FORMS),
        ("Emissions", Heat::FORMS),
        ("Transforms", Transform::FORMS),
    ]
}
