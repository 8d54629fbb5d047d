//! The material of glTF 2.0: a matt body under a glossy layer, or a metal.

use super::{
    ALPHA, ALPHA_CUTOFF, ANY_LOBE, EMISSION, ExtensionKind, Lobe, MOST_IOR, MULTISCATTER, MaterialKind, Model, NORMAL,
    NORMAL_SCALE, Number, SPECULAR, SPECULAR_COLOR, Slot, VERTEX_ALPHA, VERTEX_COLORS, conductor, varying,
};
use crate::data;
use crate::source::form::{Field, Form, Takes};
use crate::source::{NO_UNIT, Range};
use crate::texture::{Texture, Use};

const BASE_COLOR: Field =
    Field::new("base_color", Takes::Texture(Use::Albedo.range()), "The colour of the body, or of the metal.")
        .or("Rgb(1, 1, 1)");
const METALLIC: Field =
    Field::new("metallic", Takes::Varying(Range::SHARE), "1 is a metal, 0 is none, and between is a mixture.").or("1");
const ROUGHNESS: Field = Field::new(
    "roughness",
    Takes::Varying(Range::SHARE),
    "The perceptual roughness of the metal or the layer: the α of the microfacets is its square. Below 1/1024 it counts as 0, a perfect mirror.",
)
.or("1");
const IOR: Field =
    Field::new("ior", Takes::Number(Range::from_to(1.0, MOST_IOR), NO_UNIT), "The index of refraction of the layer.")
        .or("1.5");

pub const KIND: MaterialKind = MaterialKind {
    form: Form {
        name: "Pbr",
        about: "The metallic-roughness material of glTF 2.0, as its appendix B defines it: a matt body under a glossy layer, or a metal. Its names \
                and defaults are those of glTF.",
        fields: &[
            BASE_COLOR,
            METALLIC,
            ROUGHNESS,
            IOR,
            SPECULAR,
            SPECULAR_COLOR,
            MULTISCATTER,
            EMISSION,
            ALPHA,
            ALPHA_CUTOFF,
            VERTEX_COLORS,
            VERTEX_ALPHA,
            NORMAL,
            NORMAL_SCALE,
        ],
        in_order: false,
        example: "Pbr(base_color: Rgb(0.8, 0.2, 0.1), metallic: 0, roughness: 0.4)",
    },
    shader: "pbr",
    lobes: ANY_LOBE,
    is_transmissive: false,
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
    ],
    has_second_part: false,
};

pub fn model<'a>(base_color: &'a Texture, metallic: &'a Texture, roughness: &'a Texture, ior: f64) -> Model<'a> {
    let (metallic, number_of_metallic, varying_metallic) = varying(&METALLIC, ExtensionKind::Metallic, metallic);
    let (roughness, number_of_roughness, varying_roughness) = varying(&ROUGHNESS, ExtensionKind::Roughness, roughness);
    // Where nothing says that all of it is a metal, it has a matt body too.
    let is_metal = metallic == 1.0 && varying_metallic.is_none();
    let lobes = if is_metal { vec![conductor::lobe(roughness)] } else { vec![Lobe::Wide, conductor::lobe(roughness)] };
    let ior_number = Number { field: &IOR, value: ior, warning: None };
    Model {
        slot: Some(Slot { field: &BASE_COLOR, usage: Use::Albedo, texture: base_color }),
        lobes,
        two_sided: None,
        numbers: number_of_metallic.into_iter().chain(number_of_roughness).chain([ior_number]).collect(),
        colours: Vec::new(),
        lacks: None,
        extensions: varying_roughness.into_iter().chain(varying_metallic).collect(),
        absorption: None,
        on_device: data::Material {
            parameter: roughness as f32,
            // The reflectance of the layer for light straight on it, and the metallic share.
            contrast_outside: ((ior - 1.0) / (ior + 1.0)).powi(2) as f32,
            contrast_inside: metallic as f32,
            ..data::Material::default()
        },
        second_part: None,
    }
}
