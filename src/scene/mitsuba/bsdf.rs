//! BSDFs and textures as materials.

use std::path::Path;

use glam::{DAffine3, DVec3};

use super::document::{DEEPEST, Node};
use super::properties::{Properties, unknown};
use super::reader::Reader;
use super::values::colour;
use crate::bitmap::Channel;
use crate::error::{Result, require};
use crate::material::LobeWidth;
use crate::printable::{counted, quote};
use crate::scene::gltf_path::has_ending;
use crate::scene::imported::surface::{self, Facets};
use crate::scene::imported::tables;
use crate::scene::types::*;

const KNOWN: &str = "diffuse, dielectric, roughdielectric, thindielectric, conductor, roughconductor, plastic, roughplastic, principled, \
                     twosided, mask, blendbsdf, bumpmap, normalmap, null";

/// A BSDF: nothing if it is `null`.
pub fn material<'a>(node: &'a Node, two_sided: bool, reader: &mut Reader<'a, '_>) -> Result<Option<Material>> {
    require(reader.depth <= DEEPEST, || node.error("expected a bsdf that is not inside itself"))?;
    reader.depth += 1;
    let found = of_kind(node, two_sided, reader);
    reader.depth -= 1;
    found
}

fn of_kind<'a>(node: &'a Node, two_sided: bool, reader: &mut Reader<'a, '_>) -> Result<Option<Material>> {
    let own = Properties::of(node);
    let kind = own.kind()?;
    let found = match kind {
        "null" => None,
        "blendbsdf" => Some(mix(&own, two_sided, reader)?),
        "twosided" => {
            let [inner] = inner(&own, reader)?;
            material(inner, true, reader)?
        }
        "bumpmap" | "normalmap" => {
            own.take(|child| child.tag == "texture");
            own.ignore(&["scale"]);
            reader.lose(node, &format!("the {kind} is left out: the surface is smooth"));
            let [inner] = inner(&own, reader)?;
            material(inner, two_sided, reader)?
        }
        "mask" => {
            let alpha = share(&own, "opacity", 0.5, reader)?;
            let [inner] = inner(&own, reader)?;
            let mut found = material(inner, two_sided, reader)?;
            if let Some(found) = &mut found {
                let wrong = || inner.error("only diffuse, plastic and blendbsdf can be inside a mask here");
                *surface::alpha_of(found).ok_or_else(wrong)? = alpha;
            }
            found
        }
        "diffuse" => {
            // Scenes before 2 may have either name.
            let name = if own.has("diffuse_reflectance") { "diffuse_reflectance" } else { "reflectance" };
            Some(surface::lambertian(texture_or(&own, name, 0.5, reader)?, !two_sided))
        }
        "conductor" | "roughconductor" => Some(conductor(&own, kind == "roughconductor", !two_sided, reader)?),
        "dielectric" | "roughdielectric" | "thindielectric" => Some(dielectric(&own, kind, reader)?),
        "plastic" | "roughplastic" => {
            let ior = index(&own, "polypropylene")?;
            let facets = if kind == "plastic" { smooth() } else { facets(&own, reader)? };
            no_tint(&own, "specular_reflectance")?;
            if facets.roughness > 0.0 {
                let message =
                    "its body is brighter by up to 3 % here: Mitsuba integrates its inner reflections by 64 points";
                reader.lose(node, message);
            }
            Some(Material::Plastic(Plastic {
                diffuse: texture_or(&own, "diffuse_reflectance", 0.5, reader)?,
                ior,
                roughness: facets.roughness,
                distribution: facets.distribution,
                nonlinear: own.flag_or("nonlinear", false)?,
                one_sided: !two_sided,
                ..Plastic::default()
            }))
        }
        "principled" => Some(principled(&own, !two_sided, reader)?),
        _ => return Err(unknown(node, KNOWN)),
    };
    own.end(reader);
    Ok(found)
}

/// A blend of two BSDFs, which become materials with names.
fn mix<'a>(own: &Properties<'a>, two_sided: bool, reader: &mut Reader<'a, '_>) -> Result<Material> {
    let share = share(own, "weight", 0.5, reader)?;
    let [a, b] = inner(own, reader)?;
    let mut name_of = |part: &'a Node| {
        let found = material(part, two_sided, reader)?;
        let found =
            surface::mixed(found, "null cannot be mixed here: write a mask").map_err(|message| part.error(message))?;
        if found.model().widths.contains(&LobeWidth::Specular) {
            reader.lose(
                part,
                "its mirror image is brighter here: Mitsuba 3.9.1 loses light of smooth surfaces in a blend",
            );
        }
        let index = reader.add_material(found, part);
        let name = reader.made.parts.materials[index].0.clone();
        reader.parts.insert(name.clone(), index);
        Ok(name)
    };
    Ok(Material::Mix(Mix { a: name_of(a)?, b: name_of(b)?, share, alpha: Texture::grey(1.0) }))
}

/// Burley's material as that of glTF, which is near to it.
fn principled<'a>(own: &Properties<'a>, one_sided: bool, reader: &mut Reader<'a, '_>) -> Result<Material> {
    reader.lose(own.node, "it becomes glTF's material, whose matt body, sheen and coat differ");
    for name in ["anisotropic", "flatness", "spec_tint", "sheen_tint"] {
        if own.number_or(name, 0.0)? != 0.0 {
            reader.lose(own.find(name).unwrap_or(own.node), "it is left out");
        }
    }
    let rates = ["diffuse_reflectance", "main_specular", "clearcoat"].map(|lobe| format!("{lobe}_sampling_rate"));
    own.ignore(&rates.each_ref().map(String::as_str));
    let specular = own.number_or("specular", 0.5)?;
    let ior = own.number_or("eta", 2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0)?;
    let (sheen, gloss) = (own.number_or("sheen", 0.0)?, own.number_or("clearcoat_gloss", 0.0)?);
    let transmission = share(own, "spec_trans", 0.0, reader)?;
    Ok(Material::Pbr(Pbr {
        base_color: texture_or(own, "base_color", 0.5, reader)?,
        metallic: share(own, "metallic", 0.0, reader)?,
        roughness: share(own, "roughness", 0.5, reader)?,
        ior,
        // Glass has two sides.
        one_sided: one_sided && transmission == Texture::grey(0.0),
        transmission,
        solid: true,
        coat: Texture::grey(0.25 * own.number_or("clearcoat", 0.0)?),
        coat_roughness: Texture::grey((0.1 - 0.099 * gloss).sqrt()),
        sheen: Texture::grey(sheen),
        sheen_roughness: Texture::grey(if sheen > 0.0 { 0.5 } else { 0.0 }),
        ..Pbr::default()
    }))
}

/// The BSDFs that another is made of.
fn inner<'a, const N: usize>(own: &Properties<'a>, reader: &Reader<'a, '_>) -> Result<[&'a Node; N]> {
    let all = own.elements("bsdf", reader)?;
    let wrong = |all: Vec<_>| format!("expected {} in it, found {}", counted(N as u64, "bsdf"), all.len());
    all.try_into().map_err(|all| own.node.error(wrong(all)))
}

fn conductor<'a>(
    own: &Properties<'a>,
    is_rough: bool,
    one_sided: bool,
    reader: &mut Reader<'a, '_>,
) -> Result<Material> {
    let node = own.node;
    let facets = if is_rough { facets(own, reader)? } else { smooth() };
    let tint = texture_or(own, "specular_reflectance", 1.0, reader)?;
    let name = own.word("material")?.filter(|name| *name != "none");
    let outside = own.number_or("ext_eta", 1.0)?;
    let index = match (name, own.has("eta") || own.has("k")) {
        (Some(_), true) => return Err(node.error("expected a material, or eta and k")),
        (Some(name), false) => {
            let unknown = || {
                let message = format!("the metal {} is not known here: give its eta and k as <rgb>", quote(name));
                own.find("material").unwrap_or(node).error_at("value", message)
            };
            tables::metal(name).ok_or_else(unknown)?
        }
        (None, true) => [own.colour_or("eta", 0.0)?, own.colour_or("k", 1.0)?],
        (None, false) if !is_rough => return Ok(Material::Metal(Metal { albedo: tint, fuzz: 0.0, one_sided })),
        (None, false) => {
            if tint != Texture::grey(1.0) {
                reader.lose(node, "its reflectance rises to 1 at grazing angles here");
            }
            return Ok(Material::Conductor(Conductor { albedo: Some(tint), one_sided, ..facets.conductor() }));
        }
    };
    let [eta, k] = index.map(|own| Some(own / outside));
    let wrong = || {
        let message = "expected one number for the specular_reflectance beside eta and k";
        own.find("specular_reflectance").unwrap_or(node).error(message)
    };
    let reflectance = tint.plain().filter(|tint| *tint == Colour::splat(tint.x)).ok_or_else(wrong)?.x;
    Ok(Material::Conductor(Conductor { one_sided, reflectance, eta, k, ..facets.conductor() }))
}

fn dielectric<'a>(own: &Properties<'a>, kind: &str, reader: &mut Reader<'a, '_>) -> Result<Material> {
    let ior = index(own, "bk7")?;
    no_tint(own, "specular_reflectance")?;
    let passes = texture_or(own, "specular_transmittance", 1.0, reader)?;
    let transmittance = (passes != Texture::grey(1.0)).then_some(passes);
    Ok(match kind {
        "dielectric" => Material::Dielectric(Dielectric { ior, transmittance, ..Dielectric::default() }),
        "thindielectric" => Material::ThinDielectric(ThinDielectric {
            ior,
            transmittance,
            inner_reflections: true,
            ..ThinDielectric::default()
        }),
        _ => {
            let facets = facets(own, reader)?;
            Material::RoughDielectric(RoughDielectric { ior, transmittance, ..facets.dielectric() })
        }
    })
}

fn no_tint(own: &Properties, name: &str) -> Result<()> {
    let is_white = own.colour_or(name, 1.0)? == Colour::ONE;
    let at = own.find(name).unwrap_or(own.node);
    require(is_white, || at.error(format!("expected {name} of 1: others are not read")))
}

/// The index of the inside over that of the outside.
fn index(own: &Properties, default: &str) -> Result<f64> {
    let of = |property: &str, default: &str| {
        let Some(child) = own.find(property) else { return by_name(own.node, default) };
        match child.tag.as_str() {
            "string" => by_name(child, child.required("value")?),
            _ => own.number_or(property, 1.0),
        }
    };
    let ior = of("int_ior", default)? / of("ext_ior", "air")?;
    require(ior > 0.0 && ior.is_finite(), || own.node.error("expected positive indices of refraction"))?;
    Ok(ior)
}

fn by_name(node: &Node, name: &str) -> Result<f64> {
    let known = tables::row(tables::INDICES, &name.to_ascii_lowercase());
    let missing = || node.error_at("value", format!("no index of refraction of {} is known", quote(name)));
    known.and_then(|numbers| numbers.first().copied()).ok_or_else(missing)
}

fn smooth() -> Facets {
    Facets::of(0.0, 0.0, Distribution::Ggx)
}

/// The microfacets of a BSDF.
fn facets(own: &Properties, reader: &mut Reader) -> Result<Facets> {
    let node = own.node;
    own.ignore(&["sample_visible"]);
    let alpha = own.number_or("alpha", 0.1)?;
    let (u, v) = (own.number_or("alpha_u", alpha)?, own.number_or("alpha_v", alpha)?);
    require(u.min(v) >= 0.0, || node.error(format!("expected an alpha of 0 or more, found {}", u.min(v))))?;
    if u.max(v) > 1.0 {
        reader.lose(node, &format!("its alpha {} counts as 1", u.max(v)));
    }
    let distribution = match own.word("distribution")?.unwrap_or("beckmann").to_ascii_lowercase().as_str() {
        "ggx" => Distribution::Ggx,
        "beckmann" => Distribution::Beckmann,
        other => {
            let message = format!("expected beckmann or ggx, found {}", quote(other));
            return Err(own.find("distribution").unwrap_or(node).error_at("value", message));
        }
    };
    reader.lose(node, "its masking and shadowing are correlated by height here, unlike in Mitsuba: it is brighter at grazing angles, by up to 4 %");
    Ok(Facets::of(u, v, distribution))
}

/// A number that may be a texture.
fn share<'a>(own: &Properties<'a>, name: &str, default: f64, reader: &mut Reader<'a, '_>) -> Result<Texture> {
    match slot(own, name, default, true, reader)? {
        Texture::Rgb(r, g, b) if r != g || g != b => {
            Err(own.find(name).unwrap_or(own.node).error(format!("expected one number for {name}, found a colour")))
        }
        other => Ok(other),
    }
}

/// Whether the texels of an image are linear.
fn is_linear(path: &str) -> bool {
    has_ending(Path::new(path), &["exr", "hdr"])
}

/// A colour or a texture.
pub fn texture_or<'a>(own: &Properties<'a>, name: &str, default: f64, reader: &mut Reader<'a, '_>) -> Result<Texture> {
    slot(own, name, default, false, reader)
}

fn slot<'a>(
    own: &Properties<'a>,
    name: &str,
    default: f64,
    is_number: bool,
    reader: &mut Reader<'a, '_>,
) -> Result<Texture> {
    let Some(child) = own.find(name) else { return Ok(Texture::grey(default)) };
    if ["texture", "ref"].contains(&child.tag.as_str()) {
        let found = reader.follow(child, "texture")?;
        return texture(found, is_number, reader);
    }
    Ok(colour(child)?.into())
}

fn texture<'a>(node: &'a Node, is_number: bool, reader: &mut Reader<'a, '_>) -> Result<Texture> {
    let own = Properties::of(node);
    // Scenes before 2 have numbers in place of to_uv.
    let scale = DVec3::new(own.number_or("uscale", 1.0)?, own.number_or("vscale", 1.0)?, 1.0);
    let offset = DVec3::new(own.number_or("uoffset", 0.0)?, own.number_or("voffset", 0.0)?, 0.0);
    let to_uv = own.transform("to_uv")? * DAffine3::from_scale(scale) * DAffine3::from_translation(offset);
    let is_same = reader.to_uv.replace(to_uv).is_none_or(|other| other.abs_diff_eq(to_uv, 1e-9));
    require(is_same, || node.error("expected one to_uv in all textures of a surface, found another"))?;
    if own.kind_among(&["bitmap", "checkerboard"])? == "checkerboard" {
        // Theirs has v downwards, ours upwards, so that squares which were equal are not. Mitsuba 3.9.1 gives numbers the other way round.
        let [odd, even] =
            if is_number { [("color1", 0.2), ("color0", 0.4)] } else { [("color0", 0.4), ("color1", 0.2)] };
        let [odd, even] = [own.colour_or(odd.0, odd.1)?, own.colour_or(even.0, even.1)?];
        own.end(reader);
        return Ok(Texture::Checker { scale: 0.5, even, odd, uv: true });
    }
    let path = own.word("filename")?.ok_or_else(|| node.error("expected its filename"))?;
    own.ignore(&["accel", "format"]);
    let path = reader.path(path, node);
    let is_raw = own.flag_or("raw", is_linear(&path))?;
    if is_number && !is_raw && !is_linear(&path) {
        reader.lose(node, "its codes count as linear here: write raw as true");
    }
    let channel = (is_raw && !is_linear(&path) && !is_number).then_some(Channel::Rgb);
    if own.word("filter_type")?.is_some_and(|filter| filter == "nearest") {
        reader.lose(node, "its texels are blended here, not the nearest taken");
    }
    let wrap = match own.word("wrap_mode")?.unwrap_or("repeat") {
        "repeat" => Wrap::Repeat,
        "mirror" => Wrap::Mirror,
        "clamp" => Wrap::Clamp,
        _ => return Err(node.error("expected a wrap_mode of repeat, mirror or clamp")),
    };
    own.end(reader);
    Ok(Texture::Image { path, tint: Colour::ONE, channel, uv_set: 0, wrap })
}
