//! The material of glTF 2.0: a matt body under a glossy layer, or a metal.

use super::declared::pbr::FIELDS;
use super::declared::{Pbr, is_zero};
use super::model::{
    ANY_LOBE, Along, Coat, ExtensionKind, Film, Lobe, MaterialKind, Model, Slot, lobes_of_roughness, varying,
};
use super::{conductor, dielectric, rough_dielectric};
use crate::bitmap::Bitmaps;
use crate::data;
use crate::texture::{Texture, Use};

pub const KIND: MaterialKind = MaterialKind {
    shader: "pbr",
    lobes: ANY_LOBE,
    is_transmissive: false,
    is_pane: false,
    emits: false,
    extensions: &[
        ExtensionKind::Emission,
        ExtensionKind::Alpha,
        ExtensionKind::VertexColours,
        ExtensionKind::VertexAlpha,
        ExtensionKind::Roughness,
        ExtensionKind::Metallic,
        ExtensionKind::Multiscatter,
        ExtensionKind::Normal,
        ExtensionKind::Specular,
        ExtensionKind::SpecularShare,
        ExtensionKind::Transmission,
        ExtensionKind::Coat,
        ExtensionKind::CoatRoughness,
        ExtensionKind::CoatNormal,
        ExtensionKind::Sheen,
        ExtensionKind::SheenRoughness,
        ExtensionKind::Anisotropy,
        ExtensionKind::Iridescence,
        ExtensionKind::IridescenceThickness,
        ExtensionKind::DiffuseTransmission,
        ExtensionKind::DiffuseTransmissionShare,
        ExtensionKind::Dispersion,
    ],
    has_second_part: false,
};

impl Default for Pbr {
    /// A white metal that is as rough as can be, as glTF has it.
    fn default() -> Pbr {
        let (white, black) = (|| Texture::grey(1.0), || Texture::grey(0.0));
        Pbr {
            base_color: white(),
            metallic: white(),
            roughness: white(),
            ior: 1.5,
            specular: white(),
            specular_color: white(),
            transmission: black(),
            solid: false,
            absorption: None,
            dispersion: 0.0,
            diffuse_transmission: black(),
            diffuse_transmission_color: white(),
            iridescence: black(),
            iridescence_ior: 1.3,
            iridescence_thickness: 400.0,
            iridescence_thickness_min: 100.0,
            iridescence_thickness_texture: white(),
            coat: black(),
            coat_roughness: black(),
            coat_ior: 1.5,
            coat_normal: None,
            coat_normal_scale: 1.0,
            sheen: black(),
            sheen_roughness: black(),
            multiscatter: false,
            emission: None,
            alpha: white(),
            alpha_cutoff: None,
            vertex_colors: false,
            vertex_alpha: false,
            anisotropy: 0.0,
            anisotropy_rotation: 0.0,
            anisotropy_texture: None,
            normal: None,
            normal_scale: 1.0,
        }
    }
}

impl Pbr {
    pub fn model(&self) -> Model<'_> {
        let model = self.base().emissive(&self.emission).cut_out(&self.alpha, self.alpha_cutoff, self.vertex_alpha);
        let model = model.coloured_by_vertices(self.vertex_colors).scattering_many_times(self.multiscatter);
        let model = model.bumped(&self.normal, self.normal_scale);
        let glass = dielectric::glass(self.ior).on_device;
        let model = model.layered(&self.specular, &self.specular_color, !is_zero(&self.iridescence)).transmitting(
            &self.transmission,
            &glass,
            self.solid,
        );
        let coat = Coat {
            share: &self.coat,
            roughness: &self.coat_roughness,
            ior: self.coat_ior,
            normal: &self.coat_normal,
            normal_scale: self.coat_normal_scale,
        };
        let model = model.coated(coat).sheened(&self.sheen, &self.sheen_roughness);
        let film = Film {
            share: &self.iridescence,
            ior: self.iridescence_ior,
            thickness: &self.iridescence_thickness_texture,
            least: self.iridescence_thickness_min,
            most: self.iridescence_thickness,
        };
        let model = model.filmed(film).translucent(&self.diffuse_transmission, &self.diffuse_transmission_color);
        let model = model.anisotropic(self.anisotropy, self.anisotropy_rotation, &self.anisotropy_texture);
        let has_inside = self.solid && !is_zero(&self.transmission);
        let model = model.dispersing(self.ior, if has_inside { self.dispersion } else { 0.0 });
        let lacks = (self.absorption.is_some() && !has_inside)
            .then_some("no absorption without `solid: true` and a transmission: it is of the inside of a body");
        let disperses_nothing = (self.dispersion != 0.0 && !has_inside)
            .then_some("no dispersion without `solid: true` and a transmission: it is of light that a body bends");
        Model { lacks: lacks.or(disperses_nothing), ..model.absorbing(self.absorption) }
    }

    /// Its lobes. Those of a roughness that varies are as narrow as its least number makes them, and wider.
    pub fn lobes(&self, bitmaps: &Bitmaps) -> Vec<Lobe> {
        let along = Along::new(self.anisotropy, &self.anisotropy_texture);
        let is = |texture: &Texture, number: f64| texture.plain().is_some_and(|grey| grey.x == number);
        let mut found = Vec::new();
        let has_base = !is(&self.transmission, 1.0) || !is(&self.metallic, 0.0);
        if has_base {
            // Where nothing says that all of it is a metal, it has a matt body too.
            found.extend((!is(&self.metallic, 1.0)).then_some(Lobe::Wide));
            let of_facets = |roughness: f64, along: f64| vec![conductor::lobe(roughness, along)];
            found.extend(lobes_of_roughness(&self.roughness, along, bitmaps, of_facets));
        }
        if !is(&self.transmission, 0.0) && !is(&self.metallic, 1.0) {
            let of_glass = |roughness: f64, along: f64| match self.solid {
                true => rough_dielectric::lobes(self.ior, roughness, along),
                false => vec![conductor::lobe(roughness, along)],
            };
            found.extend(lobes_of_roughness(&self.roughness, along, bitmaps, of_glass));
        }
        if !is(&self.coat, 0.0) {
            let of_coat = |roughness: f64, _| vec![conductor::lobe(roughness, 0.0)];
            found.extend(lobes_of_roughness(&self.coat_roughness, Along::NONE, bitmaps, of_coat));
        }
        found.extend((!is_zero(&self.sheen)).then_some(Lobe::Wide));
        [Lobe::Specular, Lobe::Narrow, Lobe::Wide].into_iter().filter(|lobe| found.contains(lobe)).collect()
    }

    /// The material without its lobes.
    fn base(&self) -> Model<'_> {
        let (metallic, varying_metallic) = varying(&FIELDS.metallic, ExtensionKind::Metallic, &self.metallic);
        let (roughness, varying_roughness) = varying(&FIELDS.roughness, ExtensionKind::Roughness, &self.roughness);
        // Where nothing says that all of it is a metal, it has a matt body too.
        let has_body = metallic != 1.0 || varying_metallic.is_some();
        let body = has_body.then_some(Lobe::Wide);
        Model {
            slot: Some(Slot { field: &FIELDS.base_color, usage: Use::Albedo, texture: &self.base_color }),
            lobes: body.into_iter().chain([conductor::lobe(roughness, 0.0)]).collect(),
            extensions: varying_roughness.into_iter().chain(varying_metallic).collect(),
            on_device: data::Material {
                parameter: roughness as f32,
                // The reflectance of the layer for light straight on it, and the metallic share.
                contrast_outside: ((self.ior - 1.0) / (self.ior + 1.0)).powi(2) as f32,
                contrast_inside: metallic as f32,
                ..data::Material::default()
            },
            ..Model::default()
        }
    }
}
