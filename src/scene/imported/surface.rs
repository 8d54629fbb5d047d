//! Parts of surfaces that Mitsuba and pbrt have alike.

use glam::{DAffine3, DMat3, DVec3};

use super::transform::moved;
use crate::scene::types::*;

/// The poles of their spheres lie on z, those of ours on y: this takes ours to theirs.
const POLES: DMat3 = DMat3::from_cols(DVec3::NEG_X, DVec3::Z, DVec3::Y);

/// The sphere that the unit sphere becomes, if it is one of ours. `textures`: whether they lie as they are, if there are any.
pub fn sphere(by: &DAffine3, material: &Option<String>, textures: Option<bool>) -> Option<Object> {
    let mirrors = by.matrix3.determinant() < 0.0;
    // A mirror image of a sphere is a sphere.
    let round = if mirrors { *by * DAffine3::from_scale(DVec3::NEG_ONE) } else { *by };
    moved(&round, Object::Group(Vec::new()))?;
    let material = material.clone();
    let radius = by.matrix3.determinant().abs().cbrt();
    match textures {
        None => Some(Object::Sphere { center: by.translation, radius, material }),
        Some(true) if !mirrors => {
            let sphere = Object::Sphere { center: DVec3::ZERO, radius: 1.0, material };
            moved(&(*by * DAffine3::from_mat3(POLES)), sphere)
        }
        Some(_) => None,
    }
}

/// The disk of a radius around a point that the disk around the z axis becomes, if it stays round.
pub fn disk(by: &DAffine3, center: DVec3, radius: f64, flips: bool, material: &Option<String>) -> Option<Object> {
    let (x, y) = (by.matrix3.x_axis, by.matrix3.y_axis);
    let is_even = (x.length() - y.length()).abs() <= 1e-6 * x.length() && x.dot(y).abs() <= 1e-6 * x.length_squared();
    let normal = by.matrix3.inverse().transpose().z_axis.normalize_or(DVec3::Z);
    let normal = if flips { -normal } else { normal };
    let (radius, material) = (radius * x.length(), material.clone());
    is_even.then_some(Object::Disk { center: by.transform_point3(center), normal, radius, material })
}

/// The same shape as the boundary of a medium.
pub fn without_material(mut object: Object) -> Object {
    let inner = if let Object::Transformed { object, .. } = &mut object { &mut **object } else { &mut object };
    if let Object::Sphere { material, .. }
    | Object::Quad { material, .. }
    | Object::Box { material, .. }
    | Object::Disk { material, .. }
    | Object::Mesh { material, .. } = inner
    {
        *material = None;
    }
    object
}

/// A homogeneous medium.
#[derive(Clone)]
pub struct Medium {
    pub extinction: Colour,
    pub albedo: Colour,
    pub anisotropy: f64,
}

impl Medium {
    pub fn inside(&self, boundary: Object) -> Object {
        Object::Medium {
            boundary: Some(Box::new(boundary)),
            density: Density::Constant(self.extinction.x),
            albedo: self.albedo.into(),
            anisotropy: self.anisotropy,
            emission: None,
        }
    }
}

pub fn lambertian(albedo: Texture, one_sided: bool) -> Material {
    Material::Lambertian(Lambertian { albedo, one_sided, ..Lambertian::default() })
}

/// The material that emits light too, if it can. A matt black without holes is a lamp.
pub fn emitting(mut material: Material, emit: Texture, two_sided: bool) -> Option<Material> {
    let (emission, one_sided) = match &mut material {
        Material::Lambertian(own) if own.albedo == Texture::grey(0.0) && own.alpha == Texture::grey(1.0) => {
            return Some(Material::DiffuseLight(DiffuseLight { emit, two_sided, light_group: None }));
        }
        Material::Lambertian(own) => (&mut own.emission, &mut own.one_sided_emission),
        Material::Plastic(own) => (&mut own.emission, &mut own.one_sided_emission),
        Material::Pbr(own) => (&mut own.emission, &mut own.one_sided_emission),
        _ => return None,
    };
    (*emission, *one_sided) = (Some(emit), !two_sided);
    Some(material)
}

pub fn alpha_of(material: &mut Material) -> Option<&mut Texture> {
    match material {
        Material::Lambertian(own) => Some(&mut own.alpha),
        Material::Plastic(own) => Some(&mut own.alpha),
        Material::Pbr(own) => Some(&mut own.alpha),
        Material::Mix(own) => Some(&mut own.alpha),
        _ => None,
    }
}

pub fn absorption_of(material: &mut Material) -> Option<&mut Option<Colour>> {
    match material {
        Material::Dielectric(own) => Some(&mut own.absorption),
        Material::RoughDielectric(own) => Some(&mut own.absorption),
        _ => None,
    }
}

/// The part of a mix, if a material can be one. `absent` says what is wrong without one.
pub fn mixed(material: Option<Material>, absent: &str) -> Result<Material, String> {
    let material = material.ok_or(absent)?;
    match material.not_mixed() {
        Some(reason) => Err(format!("it cannot be mixed here, because it {reason}")),
        None => Ok(material),
    }
}

/// Microfacets by our parameters.
pub struct Facets {
    /// The square root of the smaller alpha.
    pub roughness: f64,
    pub anisotropy: f64,
    /// In degrees, from u towards v.
    pub rotation: f64,
    pub distribution: Distribution,
}

impl Facets {
    /// Microfacets by the alphas along u and v.
    pub fn of(u: f64, v: f64, distribution: Distribution) -> Facets {
        let (least, most) = (u.min(v).min(1.0), u.max(v).min(1.0));
        Facets {
            roughness: least.sqrt(),
            anisotropy: if most > least { ((most - least) / (1.0 - least)).sqrt() } else { 0.0 },
            rotation: if v > u { 90.0 } else { 0.0 },
            distribution,
        }
    }

    /// A conductor of these facets, and of the usual index.
    pub fn conductor(self) -> Conductor {
        Conductor {
            roughness: Texture::grey(self.roughness),
            distribution: self.distribution,
            anisotropy: self.anisotropy,
            anisotropy_rotation: self.rotation,
            ..Conductor::default()
        }
    }

    /// A dielectric of these facets, and of the usual index.
    pub fn dielectric(self) -> RoughDielectric {
        RoughDielectric {
            roughness: Texture::grey(self.roughness),
            distribution: self.distribution,
            anisotropy: self.anisotropy,
            anisotropy_rotation: self.rotation,
            ..RoughDielectric::default()
        }
    }
}
