//! A metal with microfacets: its surface is smooth or rough, and it reflects by Fresnel's equations.

use super::{
    ANY_LOBE, ExtensionKind, LEAST_ROUGHNESS, Lobe, MULTISCATTER, MaterialKind, Model, NORMAL, NORMAL_SCALE, Slot,
    varying,
};
use crate::data::{self, f32s};
use crate::source::Range;
use crate::source::form::{Field, Form, Takes};
use crate::texture::{Colour, Texture, Use};

const ALBEDO: Field = Field::new(
    "albedo",
    Takes::Texture(Use::Albedo.range()),
    "The reflected share of light that falls straight on it. At grazing angles it rises to 1 by Schlick's formula.",
)
.or("none if `eta` and `k` are given");
const ETA: Field = Field::new(
    "eta",
    Takes::Colour(Range::from_to(1e-3, 1e3)),
    "The index of refraction for red, green and blue, with `k` instead of `albedo`: the reflection is exact.",
)
.or("none if `albedo` is given");
const K: Field =
    Field::new("k", Takes::Colour(Range::from_to(0.0, 1e3)), "The extinction coefficient for red, green and blue.")
        .or("none if `albedo` is given");
const ROUGHNESS: Field = Field::new(
    "roughness",
    Takes::Varying(Range::SHARE),
    "0 is a perfect mirror. It is the perceptual roughness of glTF: the α of the microfacets is its square. Below 1/1024 it counts as 0.",
)
.or("0");

pub const KIND: MaterialKind = MaterialKind {
    form: Form {
        name: "Conductor",
        about: "A metal, polished or rough, with microfacets of GGX. Its colour is an `albedo`, or the measured `eta` and `k` of a real \
                metal. Light that microfacets would reflect more than once is lost, unless `multiscatter` is true.",
        fields: &[ALBEDO, ETA, K, ROUGHNESS, MULTISCATTER, NORMAL, NORMAL_SCALE],
        in_order: false,
        example: "Conductor(albedo: Rgb(0.95, 0.64, 0.54), roughness: 0.3)",
    },
    shader: "conductor",
    lobes: ANY_LOBE,
    is_transmissive: false,
    emits: false,
    extensions: &[ExtensionKind::Roughness, ExtensionKind::Multiscatter, ExtensionKind::Normal],
    has_second_part: true,
};

/// The lobe that its microfacets reflect where it has this roughness, as width_of_reflection (shaders/lib/microfacet).
pub fn lobe(roughness: f64) -> Lobe {
    let roughness = roughness as f32;
    if roughness < LEAST_ROUGHNESS { Lobe::Specular } else { Lobe::of_width(2.0 * roughness * roughness) }
}

pub fn model<'a>(
    albedo: Option<&'a Texture>,
    eta: Option<Colour>,
    k: Option<Colour>,
    roughness: &'a Texture,
) -> Model<'a> {
    let (roughness, number, extension) = varying(&ROUGHNESS, ExtensionKind::Roughness, roughness);
    let on_device = data::Material {
        // Instead of the albedo, which a slot writes over it. Less 1, because f32 would round an index near 1 by more than what it reflects.
        colour: f32s(eta.map_or(Colour::ZERO, |eta| eta - 1.0)),
        parameter: roughness as f32,
        ..data::Material::default()
    };
    let whole = albedo.is_some() && eta.is_none() && k.is_none() || albedo.is_none() && eta.is_some() && k.is_some();
    let is_measured = f32::from(u8::from(eta.is_some()));
    Model {
        slot: albedo.map(|texture| Slot { field: &ALBEDO, usage: Use::Albedo, texture }),
        lobes: vec![lobe(roughness)],
        two_sided: None,
        numbers: number.into_iter().collect(),
        colours: [(&ETA, eta), (&K, k)].into_iter().filter_map(|(field, colour)| Some((field, colour?))).collect(),
        lacks: (!whole).then_some("either an albedo, or both eta and k"),
        extensions: extension.into_iter().collect(),
        absorption: None,
        on_device,
        second_part: Some(data::Material {
            colour: f32s(k.unwrap_or_default()),
            parameter: is_measured,
            texture: data::NO_TEXTURE,
            ..data::Material::default()
        }),
    }
}
