//! Materials as the scene file writes them. A field that several materials have is described by the first of them.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::source::declare::declare;
use crate::source::form::{Checked, Field, Form, colour, flag, number, other, texture, varying};
use crate::source::{NO_UNIT, Range, ValuePath};
use crate::texture::{Colour, Texture, Use, normal_map, number};

/// The largest index of refraction of a surface that reflects from microfacets.
pub const MOST_IOR: f64 = 1e3;
/// The most that a clear solid absorbs per unit.
pub const MOST_ABSORPTION: f64 = 1e9;

/// The largest dispersion of glass: an Abbe number of 1.
pub const MOST_DISPERSION: f64 = 20.0;
/// The largest thickness of a film, in nm. One of some 30,000 no longer has a colour.
pub const MOST_THICKNESS: f64 = 1e6;

const ALBEDO: Field = texture(Use::Albedo.range());
const RADIANCE: Field = texture(Use::Radiance.range());
const NAME: Field = other("a material's name in quotes");
const SHARE: Field = varying(Range::SHARE);
/// The light group of a material, or of a light without size.
pub const LIGHT_GROUP: Field = other("a name in quotes").or("no group");

declare! {
    /// A material as the scene file writes it.
    #[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
    #[serde(from = "Written", into = "Written")]
    #[expect(clippy::large_enum_variant, reason = "a scene has few materials")]
    pub enum Material of structs,
    #[derive(Deserialize, Serialize)]
    #[serde(rename = "Material", deny_unknown_fields)]
    #[expect(clippy::large_enum_variant, reason = "a scene has few materials")]
    enum Written {
        /// A matt surface: it looks equally bright from all directions.
        Lambertian: lambertian, "Lambertian(albedo: Rgb(0.7, 0.3, 0.2))" {
            /// The reflected share of light.
            albedo: Texture = ALBEDO;
            /// The radiance that it emits beside what it reflects, on both sides.
            @default emission: Option<Texture> = RADIANCE.or("none: it emits nothing");
            /// Whether it emits from its front alone, and reflects on both sides.
            @default one_sided_emission: bool = flag().or("false");
            /// The group of its light: [`--aov lights`](compositing.md#light-groups).
            @default light_group: Option<String> = LIGHT_GROUP;
            /// The share of light that it stops; the rest passes straight on, as if the surface were not there.
            #[serde(default = "white", with = "number", skip_serializing_if = "is_white")]
            alpha: Texture = SHARE.or("1");
            /// With it, the surface stops all light where its alpha is at least this, and none elsewhere.
            @default alpha_cutoff: Option<f64> = number(Range::NOT_NEGATIVE, NO_UNIT).or("no cutoff");
            /// Whether the colours of a mesh's vertices multiply its colour. Those of .ply and glTF files (`COLOR_0`) are read.
            @default vertex_colors: bool = flag().or("false");
            /// Whether the alpha of a mesh's vertices multiplies its alpha. That of glTF files is read (`COLOR_0`) where the file's own
            /// material has the alphaMode MASK or BLEND.
            @default vertex_alpha: bool = flag().or("false");
            /// Whether the colours of a mesh's vertices multiply its `emission`.
            @default vertex_emission: bool = flag().or("false");
            /// A normal map: an image whose red, green and blue are the x, y and z of the normal, each from -1 at 0 to 1 at its largest
            /// code. x is along u, y along v, and z is the normal of the surface. Its codes are linear.
            #[serde(default, deserialize_with = "normal_map", skip_serializing_if = "Option::is_none")]
            normal: Option<Texture> = other("an image: Image(path: ..)").or("none: the normal is that of the surface");
            /// What x and y of the normal map are multiplied by.
            #[serde(default = "one", skip_serializing_if = "is_one")]
            normal_scale: f64 = number(Range::from_to(-1e3, 1e3), NO_UNIT).or("1");
            /// Whether its back is black: the side that a one-sided `DiffuseLight` does not light.
            @default one_sided: bool = flag().or("false");
        }
        /// A mirror, perfect or rough. It has no Fresnel term. Rays that would go below the surface are absorbed.
        Metal: metal, "Metal(albedo: Rgb(0.8, 0.6, 0.2), fuzz: 0.1)" {
            albedo: Texture = lambertian::FIELDS.albedo;
            /// Roughness. A random vector of at most this length is added to the reflected direction, which has the length 1.
            @default fuzz: f64 = number(Range::SHARE, NO_UNIT).or("0");
            @default one_sided: bool = lambertian::FIELDS.one_sided;
        }
        /// A clear solid, such as glass or water. It reflects and refracts.
        Dielectric: dielectric, "Dielectric(ior: 1.5)" {
            /// Index of refraction, relative to what is outside: 1.5 for glass, 1.33 for water, 0.667 for air in glass.
            ior: f64 = number(Range::POSITIVE, NO_UNIT);
            /// The share of the refracted light that each surface lets pass. Light through a body passes two surfaces.
            @default transmittance: Option<Texture> = ALBEDO.or("all of it");
            /// What the inside absorbs per scene unit: exp(-absorption · distance) is left of light that reaches the body's surface from
            /// inside. The surface must be closed. Light that ends on another object inside the body keeps all.
            @default absorption: Option<Colour> = colour(Range::from_to(0.0, MOST_ABSORPTION)).or("none: it is clear");
            /// How much the index of refraction depends on the colour: 20 over the Abbe number, as glTF has it; 0.36 for common glass, 0.8 for
            /// flint. Red, green and blue have an index each, (ior - 1) / 40 of this apart. Light that it bends is followed in one of the
            /// three channels, with about three times its weight, which is noisier. The index must be at least 1.
            @default dispersion: f64 = number(Range::from_to(0.0, MOST_DISPERSION), NO_UNIT).or("0");
        }
        /// A lamp: it emits the same radiance in all directions, and reflects nothing.
        DiffuseLight: diffuse_light, "DiffuseLight(emit: Rgb(15, 15, 15), two_sided: false)" {
            /// The emitted radiance.
            emit: Texture = RADIANCE;
            /// Whether both sides emit. `false` emits on one side alone: u × v of a quad, the outside of a sphere, box or mesh. The other
            /// side is black.
            #[serde(default = "yes")]
            two_sided: bool = flag().or("true");
            @default light_group: Option<String> = lambertian::FIELDS.light_group;
        }
        /// A metal, polished or rough, with microfacets. Its colour is an `albedo`, or the measured `eta` and `k` of a real
        /// metal. Light that microfacets would reflect more than once is lost, unless `multiscatter` is true.
        Conductor: conductor, "Conductor(albedo: Rgb(0.95, 0.64, 0.54), roughness: 0.3)" {
            /// The reflected share of light that falls straight on it. At grazing angles it rises to 1 by Schlick's formula.
            @default albedo: Option<Texture> = ALBEDO.or("none if `eta` and `k` are given");
            /// The index of refraction for red, green and blue, with `k` instead of `albedo`: the reflection is exact.
            @default eta: Option<Colour> = colour(Range::from_to(1e-3, 1e3)).or("none if `albedo` is given");
            /// The extinction coefficient for red, green and blue.
            @default k: Option<Colour> = colour(Range::from_to(0.0, 1e3)).or("none if `albedo` is given");
            /// What the reflection by `eta` and `k` is multiplied by.
            #[serde(default = "one", skip_serializing_if = "is_one")]
            reflectance: f64 = number(Range::from_to(1e-6, 1.0), NO_UNIT).or("1");
            /// 0 is a perfect mirror. It is the perceptual roughness of glTF: the α of the microfacets is its square. Below 1/1024 it
            /// counts as 0.
            #[serde(default = "zero", with = "number")]
            roughness: Texture = SHARE.or("0");
            /// How the slopes of its microfacets are distributed.
            @default distribution: Distribution = other("Ggx or Beckmann").or("Ggx");
            /// Whether it makes up for the light that its microfacets would reflect more than once, by Turquin's factor. Otherwise that
            /// light is lost.
            @default multiscatter: bool = flag().or("false");
            /// How much rougher microfacets are along a direction than across it: α there is mix(α, 1, anisotropy²). With it, they are
            /// never smooth.
            @default anisotropy: f64 = number(Range::SHARE, NO_UNIT).or("0");
            /// The angle of that direction with u, towards v. Objects need texture coordinates for it.
            @default anisotropy_rotation: f64 = number(Range::ANY, "degrees").or("0");
            /// An image whose red and green are the direction in the axes of u and v, each from -1 at 0 to 1 at its largest code, and
            /// whose blue multiplies the strength. Its codes are linear.
            #[serde(default, deserialize_with = "normal_map", skip_serializing_if = "Option::is_none")]
            anisotropy_texture: Option<Texture> = other("an image: Image(path: ..)").or("none: along u");
            #[serde(default, deserialize_with = "normal_map", skip_serializing_if = "Option::is_none")]
            normal: Option<Texture> = lambertian::FIELDS.normal;
            #[serde(default = "one", skip_serializing_if = "is_one")]
            normal_scale: f64 = lambertian::FIELDS.normal_scale;
            @default one_sided: bool = lambertian::FIELDS.one_sided;
        }
        /// A clear solid with a rough surface, such as frosted glass. It reflects and refracts by microfacets. Light that they
        /// would scatter more than once is lost.
        RoughDielectric: rough_dielectric, "RoughDielectric(ior: 1.5, roughness: 0.3)" {
            ior: f64 = dielectric::FIELDS.ior;
            /// 0 is a `Dielectric`. The α of the microfacets is its square.
            #[serde(default = "zero", with = "number")]
            roughness: Texture = SHARE.or("0");
            @default distribution: Distribution = conductor::FIELDS.distribution;
            @default transmittance: Option<Texture> = dielectric::FIELDS.transmittance;
            @default absorption: Option<Colour> = dielectric::FIELDS.absorption;
            @default dispersion: f64 = dielectric::FIELDS.dispersion;
            @default anisotropy: f64 = conductor::FIELDS.anisotropy;
            @default anisotropy_rotation: f64 = conductor::FIELDS.anisotropy_rotation;
            #[serde(default, deserialize_with = "normal_map", skip_serializing_if = "Option::is_none")]
            anisotropy_texture: Option<Texture> = conductor::FIELDS.anisotropy_texture;
            #[serde(default, deserialize_with = "normal_map", skip_serializing_if = "Option::is_none")]
            normal: Option<Texture> = lambertian::FIELDS.normal;
            #[serde(default = "one", skip_serializing_if = "is_one")]
            normal_scale: f64 = lambertian::FIELDS.normal_scale;
        }
        /// The metallic-roughness material of glTF 2.0, as its appendix B defines it: a matt body under a glossy layer, or a metal. Its
        /// names and defaults are those of glTF.
        Pbr: pbr, "Pbr(base_color: Rgb(0.8, 0.2, 0.1), metallic: 0, roughness: 0.4)" {
            /// The colour of the body, or of the metal.
            #[serde(default = "white")]
            base_color: Texture = ALBEDO.or("Rgb(1, 1, 1)");
            /// 1 is a metal, 0 is none, and between is a mixture.
            #[serde(default = "white", with = "number")]
            metallic: Texture = SHARE.or("1");
            /// The roughness of the metal or the layer: the α of the microfacets is its square. Below 1/1024 it counts as 0.
            #[serde(default = "white", with = "number")]
            roughness: Texture = SHARE.or("1");
            /// The index of refraction of the layer.
            #[serde(default = "index_of_glass")]
            ior: f64 = number(Range::from_to(1.0, MOST_IOR), NO_UNIT).or("1.5");
            /// All that the layer reflects is multiplied by this.
            #[serde(default = "white", with = "number", skip_serializing_if = "is_white")]
            specular: Texture = SHARE.or("1");
            /// What the layer reflects of light straight on it is multiplied by this colour; grazing light keeps its own.
            #[serde(default = "white", skip_serializing_if = "is_white")]
            specular_color: Texture = ALBEDO.or("Rgb(1, 1, 1)");
            /// The share of glass in what is no metal: it reflects and refracts as a `ThinDielectric`, or as a `RoughDielectric` if it is
            /// `solid`, of this roughness and index. What passes has the base colour.
            #[serde(default = "zero", with = "number", skip_serializing_if = "is_zero")]
            transmission: Texture = SHARE.or("0");
            /// Whether the glass is a body, which bends light. Otherwise it is a thin pane. Unlike a smooth `ThinDielectric`, it scatters the
            /// light that passes straight on, so that lights behind it are not sampled where it is smooth.
            @default solid: bool = flag().or("false");
            @default absorption: Option<Colour> = dielectric::FIELDS.absorption;
            @default dispersion: f64 = dielectric::FIELDS.dispersion;
            /// The share of the light which the matt body scatters that leaves it on the far side, as through leaves and paper.
            #[serde(default = "zero", with = "number", skip_serializing_if = "is_zero")]
            diffuse_transmission: Texture = SHARE.or("0");
            /// The colour of that light, in place of the base colour.
            #[serde(default = "white", skip_serializing_if = "is_white")]
            diffuse_transmission_color: Texture = ALBEDO.or("Rgb(1, 1, 1)");
            /// The share of a thin film on the base, as on soap bubbles and oil: what it reflects by interference stands in place of what the
            /// layer, the metal and the glass reflect.
            #[serde(default = "zero", with = "number", skip_serializing_if = "is_zero")]
            iridescence: Texture = SHARE.or("0");
            /// The index of refraction of the film.
            #[serde(default = "index_of_film", skip_serializing_if = "is_index_of_film")]
            iridescence_ior: f64 = number(Range::from_to(1.0, MOST_IOR), NO_UNIT).or("1.3");
            /// The thickness of the film.
            #[serde(default = "thickness_of_film", skip_serializing_if = "is_thickness_of_film")]
            iridescence_thickness: f64 = number(Range::from_to(0.0, MOST_THICKNESS), "nm").or("400");
            /// The thickness where its texture is 0.
            #[serde(default = "least_thickness_of_film", skip_serializing_if = "is_least_thickness_of_film")]
            iridescence_thickness_min: f64 = number(Range::from_to(0.0, MOST_THICKNESS), "nm").or("100");
            /// How thick the film is between both.
            #[serde(default = "white", with = "number", skip_serializing_if = "is_white")]
            iridescence_thickness_texture: Texture = SHARE.or("1");
            /// The share of a clear coat around all else, such as varnish. What lies below it, emission too, loses what the coat
            /// reflects to the viewer.
            #[serde(default = "zero", with = "number", skip_serializing_if = "is_zero")]
            coat: Texture = SHARE.or("0");
            /// The perceptual roughness of the coat.
            #[serde(default = "zero", with = "number", skip_serializing_if = "is_zero")]
            coat_roughness: Texture = SHARE.or("0");
            /// The index of refraction of the coat.
            #[serde(default = "index_of_glass", skip_serializing_if = "is_index_of_glass")]
            coat_ior: f64 = number(Range::from_to(1.0, MOST_IOR), NO_UNIT).or("1.5");
            /// The normal map of the coat, which does not have that of the base.
            #[serde(default, deserialize_with = "normal_map", skip_serializing_if = "Option::is_none")]
            coat_normal: Option<Texture> = other("an image: Image(path: ..)").or("none: the normal is that of the surface");
            /// What x and y of that map are multiplied by.
            #[serde(default = "one", skip_serializing_if = "is_one")]
            coat_normal_scale: f64 = number(Range::from_to(-1e3, 1e3), NO_UNIT).or("1");
            /// The colour of a sheen, which fibres such as those of velvet reflect at grazing angles. It lies under the coat.
            #[serde(default = "zero", skip_serializing_if = "is_zero")]
            sheen: Texture = ALBEDO.or("Rgb(0, 0, 0)");
            /// The perceptual roughness of the sheen. Below 0.07 it counts as 0.07.
            #[serde(default = "zero", with = "number", skip_serializing_if = "is_zero")]
            sheen_roughness: Texture = SHARE.or("0");
            @default multiscatter: bool = conductor::FIELDS.multiscatter;
            @default emission: Option<Texture> = lambertian::FIELDS.emission;
            @default one_sided_emission: bool = lambertian::FIELDS.one_sided_emission;
            @default light_group: Option<String> = lambertian::FIELDS.light_group;
            #[serde(default = "white", with = "number", skip_serializing_if = "is_white")]
            alpha: Texture = lambertian::FIELDS.alpha;
            @default alpha_cutoff: Option<f64> = lambertian::FIELDS.alpha_cutoff;
            @default vertex_colors: bool = lambertian::FIELDS.vertex_colors;
            @default vertex_alpha: bool = lambertian::FIELDS.vertex_alpha;
            @default anisotropy: f64 = conductor::FIELDS.anisotropy;
            @default anisotropy_rotation: f64 = conductor::FIELDS.anisotropy_rotation;
            #[serde(default, deserialize_with = "normal_map", skip_serializing_if = "Option::is_none")]
            anisotropy_texture: Option<Texture> = conductor::FIELDS.anisotropy_texture;
            #[serde(default, deserialize_with = "normal_map", skip_serializing_if = "Option::is_none")]
            normal: Option<Texture> = lambertian::FIELDS.normal;
            #[serde(default = "one", skip_serializing_if = "is_one")]
            normal_scale: f64 = lambertian::FIELDS.normal_scale;
            @default one_sided: bool = lambertian::FIELDS.one_sided;
        }
        /// A pane that is thin: one surface stands for both of its sides, and what passes is not bent. It reflects as one surface
        /// does, as glTF has it for transmission without a volume. A smooth pane lets light pass straight on, which is no scattering
        /// event: lights behind it are sampled. A rough pane spreads what passes as it spreads what it reflects.
        ThinDielectric: thin_dielectric, "ThinDielectric(transmittance: Rgb(0.6, 0.9, 0.7))" {
            /// Index of refraction, of which the reflectance follows.
            #[serde(default = "index_of_glass")]
            ior: f64 = number(Range::from_to(1.0, MOST_IOR), NO_UNIT).or("1.5");
            /// 0 is clear. The α of the microfacets is its square.
            #[serde(default = "zero", with = "number")]
            roughness: Texture = SHARE.or("0");
            /// Whether it reflects as both sides of a slab do, with all reflections between them: 2R / (1 + R) instead of R.
            @default inner_reflections: bool = flag().or("false");
            @default transmittance: Option<Texture> = dielectric::FIELDS.transmittance;
            #[serde(default, deserialize_with = "normal_map", skip_serializing_if = "Option::is_none")]
            normal: Option<Texture> = lambertian::FIELDS.normal;
            #[serde(default = "one", skip_serializing_if = "is_one")]
            normal_scale: f64 = lambertian::FIELDS.normal_scale;
        }
        /// A matt body under a clear layer, such as plastic or varnished wood. The layer reflects the light of the body back to it, until
        /// it is absorbed or leaves.
        Plastic: plastic, "Plastic(diffuse: Rgb(0.7, 0.1, 0.1), roughness: 0.3)" {
            /// The share of light that the body scatters each time.
            diffuse: Texture = ALBEDO;
            /// Index of refraction of the layer.
            #[serde(default = "index_of_glass")]
            ior: f64 = number(Range::from_to(1.0, MOST_IOR), NO_UNIT).or("1.5");
            /// 0 is a smooth layer. The α of the microfacets is its square.
            @default roughness: f64 = number(Range::SHARE, NO_UNIT).or("0");
            @default distribution: Distribution = conductor::FIELDS.distribution;
            /// Whether light that comes back to the body takes its colour each time, which is more saturated. Otherwise it takes it once.
            @default nonlinear: bool = flag().or("false");
            @default emission: Option<Texture> = lambertian::FIELDS.emission;
            @default one_sided_emission: bool = lambertian::FIELDS.one_sided_emission;
            @default light_group: Option<String> = lambertian::FIELDS.light_group;
            #[serde(default = "white", with = "number", skip_serializing_if = "is_white")]
            alpha: Texture = lambertian::FIELDS.alpha;
            @default one_sided: bool = lambertian::FIELDS.one_sided;
        }
        /// A surface of two materials. Each ray that meets it finds one of them at random.
        Mix: mix, "Mix(a: \"paint\", b: \"rust\", share: 0.3)" {
            /// A name among the materials. It is no Mix, DiffuseLight or ThinDielectric, and has no emission, alpha or absorption.
            a: String = NAME;
            /// The other one.
            b: String = NAME;
            /// The share of rays that find `b`.
            #[serde(with = "number")]
            share: Texture = SHARE;
            #[serde(default = "white", with = "number", skip_serializing_if = "is_white")]
            alpha: Texture = lambertian::FIELDS.alpha;
        }
    }
}

/// The distribution of the slopes of microfacets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum Distribution {
    #[default]
    Ggx,
    Beckmann,
}

impl Checked for Distribution {}

/// The material of a file that gives these fields alone.
macro_rules! defaults_of_files {
    ($($kind:ident $text:literal;)*) => { $(
        impl Default for $kind {
            fn default() -> $kind {
                static OF_FILES: LazyLock<$kind> = LazyLock::new(|| match ron::from_str($text) {
                    Ok(Material::$kind(own)) => own,
                    other => panic!("a field of {} has no default: {other:?}", $text),
                });
                OF_FILES.clone()
            }
        }
    )* };
}

defaults_of_files! {
    Lambertian "Lambertian(albedo: Rgb(0, 0, 0))";
    Conductor "Conductor()";
    Dielectric "Dielectric(ior: 1.5)";
    RoughDielectric "RoughDielectric(ior: 1.5)";
    Pbr "Pbr()";
    ThinDielectric "ThinDielectric()";
    Plastic "Plastic(diffuse: Rgb(0, 0, 0))";
}

impl Pbr {
    /// Whether all of it is a metal.
    pub fn is_all_metal(&self) -> bool {
        self.metallic.plain().is_some_and(|metallic| metallic.x == 1.0)
    }

    /// Whether its glass is a body.
    pub fn has_inside(&self) -> bool {
        self.solid && !is_zero(&self.transmission)
    }
}

/// Declares defaults as serde calls them: the value, and whether a field has it.
macro_rules! defaults {
    ($($default:ident, $is_default:ident: $type:ty = $value:expr;)*) => { $(
        fn $default() -> $type {
            $value
        }

        pub fn $is_default(value: &$type) -> bool {
            *value == $default()
        }
    )* };
}

defaults! {
    white, is_white: Texture = Texture::grey(1.0);
    zero, is_zero: Texture = Texture::grey(0.0);
    one, is_one: f64 = 1.0;
    index_of_glass, is_index_of_glass: f64 = 1.5;
    index_of_film, is_index_of_film: f64 = 1.3;
    thickness_of_film, is_thickness_of_film: f64 = 400.0;
    least_thickness_of_film, is_least_thickness_of_film: f64 = 100.0;
}

fn yes() -> bool {
    true
}
