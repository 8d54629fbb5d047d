//! Materials.

use std::cell::Cell;

use super::params::{Params, Spectrum};
use super::reader::{AS_THEY_ARE, Reader};
use super::texture::{baked, number_or, texture_or};
use crate::error::{Result, require};
use crate::printable::quote;
use crate::scene::imported::surface::{self, Facets, lambertian};
use crate::scene::imported::tables;
use crate::scene::types::*;

const KNOWN: &str =
    "diffuse, dielectric, thindielectric, conductor, coateddiffuse, diffusetransmission, mix, interface";

/// The thickness of a layer up to which its absorption is off by a percent at most where light grazes it.
const THICKEST: f64 = 0.03;

/// The material of a directive; nothing for an interface.
pub fn material(kind: &str, params: &Params, reader: &mut Reader) -> Result<Option<Material>> {
    params.ignore(&["type"]);
    reader.mapping = None;
    for name in ["displacement", "normalmap"] {
        if params.has(name) {
            params.ignore(&[name]);
            reader.lose(params, name, &format!("its {name} is left out: the surface is smooth"));
        }
    }
    let found = match kind {
        "" | "none" | "interface" => None,
        "diffuse" => Some(lambertian(texture_or(params, "reflectance", 0.5, reader)?, false)),
        "coateddiffuse" => Some(coated(params, reader)?),
        "diffusetransmission" => Some(translucent(params, reader)?),
        "dielectric" => {
            let (ior, facets) = (index(params, reader)?, facets(params, reader)?);
            Some(match facets.roughness == 0.0 && facets.anisotropy == 0.0 {
                true => Material::Dielectric(Dielectric { ior, ..Dielectric::default() }),
                false => Material::RoughDielectric(RoughDielectric { ior, ..facets.dielectric() }),
            })
        }
        "thindielectric" => Some(Material::ThinDielectric(ThinDielectric {
            ior: index(params, reader)?,
            inner_reflections: true,
            ..ThinDielectric::default()
        })),
        "conductor" => Some(conductor(params, reader)?),
        "mix" => Some(mix(params, reader)?),
        "coatedconductor" => {
            reader.lose(params, "", "its coat is left out");
            Some(conductor(&params.of_part("conductor"), reader)?)
        }
        "hair" | "measured" | "subsurface" => {
            reader.lose(params, "", "it becomes a matt surface");
            let albedo = texture_or(params, "reflectance", 0.5, reader)?;
            params.ignore_all();
            Some(lambertian(albedo, false))
        }
        _ => return Err(params.error(format!("this material is not read: expected one of {KNOWN}"))),
    };
    reader.end(params);
    Ok(found)
}

/// A matt body under a layer. Ours lets all light pass, so that what the layer of pbrt absorbs is taken from the body.
fn coated(params: &Params, reader: &mut Reader) -> Result<Material> {
    if params.number_or("g", 0.0)? != 0.0 || params.colour("albedo")?.is_some_and(|albedo| albedo != Colour::ZERO) {
        reader.lose(params, "", "its albedo and g are not used: its layer scatters nothing");
    }
    params.ignore(&["nsamples"]);
    let facets = facets(params, reader)?;
    require(facets.anisotropy == 0.0, || params.error("expected one roughness for u and v"))?;
    let message = match facets.roughness > 0.0 {
        false => "its random walk is a closed form here, which differs by up to 0.5 %",
        true => {
            "its random walk is a closed form here: the light that pbrt samples at lamps is up to 10 % brighter than what its paths find"
        }
    };
    reader.lose(params, "", message);
    let (ior, thickness) = (index(params, reader)?, params.number_or("thickness", 0.01)?.max(0.0));
    if thickness > THICKEST {
        reader.lose(params, "thickness", "its layer is as dark in all directions here");
    }
    let layer = Plastic { ior, roughness: facets.roughness, nonlinear: true, ..Plastic::default() };
    let inner = 1.0 - layer.layer().0 / (ior * ior);
    // By the mean of 1 / cos: of light that enters or leaves, and of light that is reflected inside, which passes twice.
    let cos = (1.0 - 1.0 / (ior * ior)).max(0.0).sqrt();
    let [passes, returns] = [2.0 * ior * ior * (1.0 - cos), 4.0 / cos.max(0.1)].map(|way| (-thickness * way).exp());
    let rounds = params.integer_or("maxdepth", 10)?.clamp(0, 1 << 20) as f64 / 2.0;
    let darker = |albedo: f64| {
        let again = albedo * inner * returns;
        let leaves = albedo * passes * passes * (1.0 - again.powf(rounds)) / (1.0 - again);
        // The model is good for fewer digits.
        (1e9 * leaves / (1.0 + leaves * inner)).round() / 1e9
    };
    let albedo = texture_or(params, "reflectance", 0.5, reader)?;
    let is_image = albedo.decoded().is_some();
    if is_image {
        reader.lose(params, "", "its layer darkens all texels by one factor here");
    }
    let diffuse = albedo.map(|own| if is_image { 2.0 * darker(0.5) * own } else { own.map(darker) });
    Ok(Material::Plastic(Plastic { diffuse, ..layer }))
}

/// A matt body that lets light pass.
fn translucent(params: &Params, reader: &mut Reader) -> Result<Material> {
    let scale = params.number_or("scale", 1.0)?;
    let mut share = |name| texture_or(params, name, 0.25, reader);
    let parts = [share("reflectance")?, share("transmittance")?];
    let most = Cell::new(0.0_f64);
    let mut part = |is_colour, of: fn([Colour; 2]) -> Colour| {
        let kept = |parts: [Colour; 2]| {
            let parts = parts.map(|part| (scale * part).min(Colour::ONE));
            let sum: f64 = parts.map(Colour::max_element).iter().sum();
            most.set(most.get().max(sum));
            of(parts.map(|part| part / sum.max(1.0))).min(Colour::ONE)
        };
        baked(params, is_colour, parts.clone(), kept, reader)
    };
    let diffuse_transmission = part(false, |parts| Colour::splat(share_of(parts)))?;
    let base_color = part(true, |parts| over(parts[0], 1.0 - share_of(parts)))?;
    let diffuse_transmission_color = part(true, |parts| over(parts[1], share_of(parts)))?;
    let (sum, images) = (most.get(), parts.iter().filter(|part| part.decoded().is_some()).count());
    let wrong = || params.error(format!("expected a reflectance and transmittance of 1 at most, found {sum}"));
    require(sum <= 1.0 || images > 0, wrong)?;
    if sum > 1.0 {
        reader.lose(params, "", "where it would scatter more light than it gets, both parts are less here");
    }
    // Where both are images, `baked` tells it.
    if images == 1 {
        reader.lose(params, "", "its parts are divided at texels here: between them they differ");
    }
    let (metallic, specular) = (Texture::grey(0.0), Texture::grey(0.0));
    let own = Pbr { base_color, diffuse_transmission, diffuse_transmission_color, ..Pbr::default() };
    Ok(Material::Pbr(Pbr { metallic, specular, ..own }))
}

/// The share of its scattered light that a body passes, by the colours that it reflects and passes.
fn share_of([reflected, passed]: [Colour; 2]) -> f64 {
    let (reflected, passed) = (reflected.max_element(), passed.max_element());
    if passed > 0.0 { passed / (reflected + passed) } else { 0.0 }
}

fn over(colour: Colour, share: f64) -> Colour {
    if share > 0.0 { colour / share } else { Colour::ZERO }
}

fn conductor(params: &Params, reader: &mut Reader) -> Result<Material> {
    let facets = facets(params, reader)?;
    let (eta, k) = match params.has("reflectance") {
        true if params.has("eta") || params.has("k") => {
            return Err(params.error("expected a reflectance, or eta and k, found both"));
        }
        true => {
            let wrong = || params.error_at("reflectance", "a texture of a conductor is not read");
            let own = texture_or(params, "reflectance", 0.5, reader)?.plain().ok_or_else(wrong)?;
            // As pbrt makes them of a reflectance.
            let reflectance = own.clamp(Colour::ZERO, Colour::splat(0.9999));
            (Colour::ONE, reflectance.map(|r| 2.0 * r.sqrt() / (1.0 - r).sqrt()))
        }
        false => (of_metal(params, "eta", 0)?, of_metal(params, "k", 1)?),
    };
    Ok(Material::Conductor(Conductor { eta: Some(eta), k: Some(k), ..facets.conductor() }))
}

/// The eta or the k of a metal: 0 or 1 says which.
fn of_metal(params: &Params, name: &str, number: usize) -> Result<Colour> {
    let of_name = |text: &str| {
        let metal = text.strip_prefix("metal-").and_then(|rest| rest.strip_suffix(&format!("-{name}")));
        let missing = || params.error_at(name, format!("the metal {} is not known here: give its rgb", quote(text)));
        Ok(metal.and_then(tables::metal).ok_or_else(missing)?[number])
    };
    match params.spectrum(name)? {
        None => of_name(&format!("metal-Cu-{name}")),
        Some(Spectrum::Named(text)) => of_name(&text),
        Some(Spectrum::Rgb(colour)) => Ok(colour),
        Some(Spectrum::Curve { .. }) => {
            Err(params.error_at(name, format!("{name} by wavelengths is not read: give its rgb")))
        }
    }
}

fn mix(params: &Params, reader: &mut Reader) -> Result<Material> {
    let names = params.words("materials")?;
    let [a, b] = names else {
        return Err(params.error_at("materials", format!("expected the names of two materials, found {}", names.len())));
    };
    let mut name_of = |name: &str| {
        let wrong = |message: &str| params.error_at("materials", format!("{}: {message}", quote(name)));
        let look = reader.named_looks.get(name).and_then(|look| reader.looks.get(*look));
        let look = look.ok_or_else(|| wrong("there is no material of this name above"))?;
        let (found, at, mapping) = (look.material.clone(), look.at.clone(), look.mapping);
        let is_one = mapping.is_none_or(|mapping| reader.has_mapping(mapping));
        require(is_one, || wrong("expected one mapping of all textures of a surface, found another"))?;
        let found = surface::mixed(found, "an interface cannot be mixed").map_err(|message| wrong(&message))?;
        Ok(reader.add_material(found, name, &at))
    };
    let (a, b) = (name_of(a)?, name_of(b)?);
    Ok(Material::Mix(Mix { a, b, share: number_or(params, "amount", 0.5, reader)?, alpha: Texture::grey(1.0) }))
}

/// The index of refraction inside.
fn index(params: &Params, reader: &mut Reader) -> Result<f64> {
    let ior = match params.spectrum("eta")? {
        None => 1.5,
        Some(Spectrum::Rgb(eta)) if eta == Colour::splat(eta.x) => eta.x,
        Some(Spectrum::Named(name)) => {
            let glass = Some(&name).filter(|name| name.starts_with("glass-"));
            let known = glass.and_then(|name| tables::row(tables::INDICES, name)?.first().copied());
            let unknown =
                || params.error_at("eta", format!("the glass {} is not known here: give a float", quote(&name)));
            let ior = known.ok_or_else(unknown)?;
            reader.lose(params, "eta", &format!("its index is {ior} for all colours here"));
            ior
        }
        Some(_) => return Err(params.error_at("eta", "expected one number, or the name of a glass")),
    };
    require(ior > 0.0, || params.error_at("eta", format!("expected an index above 0, found {ior}")))?;
    Ok(ior)
}

/// The microfacets of a material, from the roughness of u and v, whose root pbrt takes as alpha unless `remaproughness` is false.
fn facets(params: &Params, reader: &mut Reader) -> Result<Facets> {
    let remaps = params.flag_or("remaproughness", true)?;
    let usual = number_or(params, "roughness", 0.0, reader)?;
    let one = |name: &str, reader: &mut Reader| match params.has(name) {
        true => number_or(params, name, 0.0, reader),
        false => Ok(usual.clone()),
    };
    let (u, v) = (one("uroughness", reader)?, one("vroughness", reader)?);
    let [u, v] = [u, v].map(|own| match own {
        Texture::Rgb(x, ..) => x,
        Texture::Image { tint, .. } => 0.5 * tint.x,
        Texture::Checker { even, odd, .. } => 0.5 * (even.x + odd.x),
        _ => 0.5,
    });
    if ["roughness", "uroughness", "vroughness"].iter().any(|name| params.is_texture(name)) {
        reader.lose(params, "", &format!("its texture of roughness counts as {u} here"));
    }
    let [u, v] = [u, v].map(|x| if remaps { x.max(0.0).sqrt() } else { x.max(0.0) });
    if u.max(v) > 1.0 {
        reader.lose(params, "", &format!("its alpha {} counts as 1", u.max(v)));
    }
    // pbrt takes less as smooth.
    let is_smooth = u.max(v) < 1e-3;
    if u != v && !is_smooth {
        reader.mapping.get_or_insert(AS_THEY_ARE);
    }
    Ok(if is_smooth { Facets::of(0.0, 0.0, Distribution::Ggx) } else { Facets::of(u, v, Distribution::Ggx) })
}
