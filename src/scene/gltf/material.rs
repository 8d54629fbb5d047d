//! The materials of a glTF file, in terms of ours. What has no counterpart is named, once for each material.

mod reader;

use std::borrow::Cow;
use std::path::Path;

use glam::{DVec3, Vec2};
use gltf::json::extensions::material::{Specular, Volume};
use gltf::json::extensions::texture;
use gltf::json::material::{AlphaMode, Material as Given};
use gltf::json::texture::{Info, MagFilter, WrappingMode};
use gltf::json::validation::Checked;

use super::lobes;
use super::{File, GltfError, Result, decimal, path_of_uri};
use crate::material::{MOST_ABSORPTION, MOST_IOR};
use crate::scene::gltf_path::Part;
use crate::scene::types::{Colour, Pbr, Texture};
use crate::texture::{LARGEST_RADIANCE, SMALLEST_RADIANCE};

/// How the texture coordinates of a mesh become those of its material's image: the set, and KHR_texture_transform.
#[derive(Clone, Debug, PartialEq)]
pub struct UvTransform {
    pub set: u32,
    offset: [f64; 2],
    scale: [f64; 2],
    /// Radians.
    rotation: f64,
}

impl Default for UvTransform {
    fn default() -> UvTransform {
        UvTransform { set: 0, offset: [0.0; 2], scale: [1.0; 2], rotation: 0.0 }
    }
}

impl UvTransform {
    fn from_info(info: &Info) -> UvTransform {
        let mut placing = UvTransform { set: info.tex_coord, ..UvTransform::default() };
        if let Some(transform) = info.extensions.as_ref().and_then(|found| found.texture_transform.as_ref()) {
            placing.set = transform.tex_coord.unwrap_or(info.tex_coord);
            placing.offset = transform.offset.0.map(f64::from);
            placing.scale = transform.scale.0.map(f64::from);
            placing.rotation = f64::from(transform.rotation.0);
        }
        placing
    }

    /// Texture coordinates of the file, whose v runs down from the top, as a mesh has them.
    pub fn in_mesh(&self, uv: [f64; 2]) -> Vec2 {
        let [u, v] = self.applied(uv);
        Vec2::new(u as f32, (1.0 - v) as f32)
    }

    /// Texture coordinates with v down. The rotation is counter-clockwise as the image is seen.
    fn applied(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.rotation.sin_cos();
        let (u, v) = (u * self.scale[0], v * self.scale[1]);
        [cos * u + sin * v + self.offset[0], cos * v - sin * u + self.offset[1]]
    }
}

/// What a material becomes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Model {
    Light,
    /// It shows its base colour in any light (KHR_materials_unlit).
    Unlit,
    Glass,
    Surface,
}

/// What the vertices of a material's meshes have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OfVertices {
    /// Colours other than white.
    pub colors: bool,
    /// Alphas other than 1, which its alphaMode does not ignore.
    pub alpha: bool,
}

/// What glass is on a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Glass {
    /// Whether it is a solid, and no pane.
    pub is_solid: bool,
    /// Whether the shape of the mesh says so, because the file gives no thickness.
    pub by_shape: bool,
    /// Whether the base colour is what light through all of the body keeps, and not what it keeps at each surface.
    pub colour_of_body: bool,
}

/// Whether a material is glass, or has a share of it.
pub fn is_glass(given: &Given) -> bool {
    model(given) == Model::Glass || has_a_share_of_glass(given)
}

fn has_a_share_of_glass(given: &Given) -> bool {
    model(given) == Model::Surface && transmission(given) > 0.0
}

/// The factor of its transmission, cut to 0..1.
fn transmission(given: &Given) -> f64 {
    let transmission = given.extensions.as_ref().and_then(|found| found.transmission.as_ref());
    transmission.map_or(0.0, |transmission| decimal(transmission.transmission_factor.0).clamp(0.0, 1.0))
}

/// The thickness that KHR_materials_volume gives, if it is there. 0 stands for a pane.
pub fn thickness(given: &Given) -> Option<f32> {
    Some(given.extensions.as_ref()?.volume.as_ref()?.thickness_factor.0)
}

/// What a primitive without a material has: by the standard a white metal that is as rough as can be; in files by Blender its default, a
/// Principled BSDF with the values of a new one.
pub fn default_material(of_blender: bool, vertex_colors: bool) -> Pbr {
    let (base_color, metallic, roughness) = if of_blender { (0.8, 0.0, 0.5) } else { (1.0, 1.0, 1.0) };
    let [base_color, metallic, roughness] = [base_color, metallic, roughness].map(Texture::grey);
    Pbr { base_color, metallic, roughness, vertex_colors, ..Pbr::default() }
}

pub fn colour(rgb: [f32; 3]) -> Colour {
    DVec3::from_array(rgb.map(decimal))
}

/// Cut to the range of radiance.
pub fn radiance(light: Colour) -> Colour {
    light.map(|x| if x < SMALLEST_RADIANCE { 0.0 } else { x.min(LARGEST_RADIANCE) })
}

fn emission(given: &Given) -> Colour {
    let strength = given.extensions.as_ref().and_then(|found| found.emissive_strength.as_ref());
    let strength = strength.map_or(1.0, |strength| decimal(strength.emissive_strength.0));
    strength * colour(given.emissive_factor.0)
}

fn model(given: &Given) -> Model {
    let pbr = &given.pbr_metallic_roughness;
    let [r, g, b, _] = pbr.base_color_factor.0;
    let of_glass = given.extensions.as_ref().and_then(|found| found.transmission.as_ref());
    let varies = of_glass.is_some_and(|transmission| transmission.transmission_texture.is_some());
    if given.extensions.as_ref().is_some_and(|found| found.unlit.is_some()) {
        Model::Unlit
    } else if lobes::has_own_lobes(given) {
        Model::Surface
    } else if emission(given).max_element() > 0.0 && [r, g, b] == [0.0; 3] {
        Model::Light
    } else if transmission(given) == 1.0 && !varies {
        Model::Glass
    } else {
        Model::Surface
    }
}

/// A texture of a material, with the field that names it.
type Named<'a> = (Cow<'static, str>, Cow<'a, Info>);

fn base_texture(given: &Given) -> Option<Named<'_>> {
    let info = given.pbr_metallic_roughness.base_color_texture.as_ref();
    // That of a lamp is read for its alpha.
    let info = info.filter(|_| model(given) != Model::Light || !is_opaque(given));
    info.map(|info| ("pbrMetallicRoughness.baseColorTexture".into(), Cow::Borrowed(info)))
}

fn emissive_texture(given: &Given) -> Option<Named<'_>> {
    let is_read = !matches!(model(given), Model::Glass | Model::Unlit) && emission(given) != Colour::ZERO;
    given.emissive_texture.as_ref().filter(|_| is_read).map(|info| ("emissiveTexture".into(), Cow::Borrowed(info)))
}

/// The texture of its numbers: the roughness in green, and how metallic it is in blue.
fn number_texture(given: &Given) -> Option<Named<'_>> {
    let info = given.pbr_metallic_roughness.metallic_roughness_texture.as_ref();
    let is_read = numbers(given) != [0.0; 2] && !matches!(model(given), Model::Light | Model::Unlit);
    info.filter(|_| is_read).map(|info| ("pbrMetallicRoughness.metallicRoughnessTexture".into(), Cow::Borrowed(info)))
}

/// The factors of the roughness and of how metallic it is, each cut to 0..1. Glass is no metal.
fn numbers(given: &Given) -> [f64; 2] {
    let pbr = &given.pbr_metallic_roughness;
    let [roughness, metallic] = [pbr.roughness_factor, pbr.metallic_factor].map(|x| decimal(x.0).clamp(0.0, 1.0));
    [roughness, if model(given) == Model::Glass { 0.0 } else { metallic }]
}

/// The normal map, which the crate reads as a type of its own.
fn normal_texture(given: &Given) -> Option<Named<'_>> {
    let is_read = !matches!(model(given), Model::Light | Model::Unlit);
    let map = given.normal_texture.as_ref().filter(|_| is_read)?;
    let others = map.extensions.as_ref().map(|extensions| extensions.others.clone()).unwrap_or_default();
    let transform = others.get("KHR_texture_transform").cloned();
    let transform = transform.and_then(|transform| serde_json::from_value(transform).ok());
    let extensions = texture::Info { texture_transform: transform, others };
    let info =
        Info { index: map.index, tex_coord: map.tex_coord, extensions: Some(extensions), extras: Default::default() };
    Some(("normalTexture".into(), Cow::Owned(info)))
}

/// A texture of an extension that `Pbr` alone reads.
fn lobe_texture<'a>(given: &Given, field: &'static str, info: Option<&'a Info>) -> Option<Named<'a>> {
    info.filter(|_| model(given) == Model::Surface).map(|info| (field.into(), Cow::Borrowed(info)))
}

fn specular_texture(given: &Given) -> Option<Named<'_>> {
    let specular = given.extensions.as_ref()?.specular.as_ref().filter(|it| it.specular_factor.0 > 0.0)?;
    lobe_texture(given, "extensions.KHR_materials_specular.specularTexture", specular.specular_texture.as_ref())
}

fn specular_color_texture(given: &Given) -> Option<Named<'_>> {
    let specular = given.extensions.as_ref()?.specular.as_ref().filter(|it| it.specular_factor.0 > 0.0)?;
    let field = "extensions.KHR_materials_specular.specularColorTexture";
    lobe_texture(given, field, specular.specular_color_texture.as_ref())
}

fn transmission_texture(given: &Given) -> Option<Named<'_>> {
    let transmission = given.extensions.as_ref()?.transmission.as_ref();
    let transmission = transmission.filter(|it| it.transmission_factor.0 > 0.0)?;
    let field = "extensions.KHR_materials_transmission.transmissionTexture";
    lobe_texture(given, field, transmission.transmission_texture.as_ref())
}

/// The textures that a material of ours has.
fn textures(given: &Given) -> impl Iterator<Item = Named<'_>> {
    let of_colour = base_texture(given).into_iter().chain(emissive_texture(given));
    let of_base = of_colour.chain(number_texture(given)).chain(normal_texture(given));
    let of_layer = specular_texture(given).into_iter().chain(specular_color_texture(given));
    let of_lobes = lobes::textures(given).filter(|_| model(given) != Model::Unlit);
    let of_lobes = of_lobes.map(|(place, info)| (place.into(), Cow::Owned(info)));
    of_base.chain(of_layer).chain(transmission_texture(given)).chain(of_lobes)
}

/// The sets of texture coordinates that the meshes of a material have: each placing of its textures once, in their order.
fn placings(given: &Given) -> Vec<UvTransform> {
    let mut found = Vec::new();
    for (_, info) in textures(given) {
        let placing = UvTransform::from_info(&info);
        if !found.contains(&placing) {
            found.push(placing);
        }
    }
    found
}

/// What the inside absorbs per unit, of which the share `attenuationColor` is left after `attenuationDistance`.
fn absorption(volume: &Volume) -> Option<Colour> {
    let distance = f64::from(volume.attenuation_distance.0);
    let left = colour(volume.attenuation_color.0).clamp(Colour::ZERO, Colour::ONE);
    let absorbed = (-left.map(f64::ln) / distance).min(Colour::splat(MOST_ABSORPTION));
    (distance > 0.0 && distance.is_finite() && absorbed != Colour::ZERO).then_some(absorbed)
}

fn changes_the_layer(specular: &Specular) -> bool {
    specular.specular_factor.0 != 1.0 || specular.specular_color_factor.0 != [1.0; 3]
}

/// The share and the colour of a layer, and the index of refraction that goes with them: a colour above 1 counts as a larger index.
fn layer(specular: &Specular, ior: f64) -> (f64, f64, Colour) {
    let share = decimal(specular.specular_factor.0).clamp(0.0, 1.0);
    let color = colour(specular.specular_color_factor.0).max(Colour::ZERO);
    let most = color.max_element();
    if most <= 1.0 {
        return (share, ior, color);
    }
    // Straight on, the layer reflects ((ior - 1) / (ior + 1))².
    let root = most.sqrt() * (ior - 1.0) / (ior + 1.0);
    let ior = if root < 1.0 { (1.0 + root) / (1.0 - root) } else { MOST_IOR };
    (share, ior.min(MOST_IOR), color / most)
}

impl File {
    pub fn material_of(&self, mesh: usize, primitive: usize) -> Result<Option<&Given>> {
        let material = self.primitive(mesh, primitive)?.material;
        Ok(material.and_then(|material| self.root().materials.get(material.value())))
    }

    /// How the texture coordinates of a primitive become those of its material's images: each way once. None where it has no image.
    pub fn uv_placings(&self, mesh: usize, primitive: usize) -> Result<Vec<UvTransform>> {
        Ok(self.material_of(mesh, primitive)?.map(placings).unwrap_or_default())
    }

    /// Whether a primitive's material has a normal map.
    pub fn has_normal_map(&self, mesh: usize, primitive: usize) -> Result<bool> {
        let has_map = |given: &Given| normal_texture(given).is_some() || lobes::needs_tangents(given);
        Ok(self.material_of(mesh, primitive)?.is_some_and(has_map))
    }

    /// The path of a texture's image, as the scene would write it. Nothing, with a note, where it is of a format that is not read.
    fn image_path(
        &self,
        material: &str,
        field: &str,
        info: &Info,
        path: &str,
        notes: &mut Vec<String>,
    ) -> Result<Option<String>> {
        let Some(source) = self.image_of(material, field, info, notes)? else { return Ok(None) };
        if let Some(sampler) = self.root().textures.get(info.index.value()).and_then(|texture| texture.sampler) {
            let number = sampler.value();
            let sampler = self.root().samplers.get(number);
            let sampler = sampler.ok_or_else(|| {
                let at = format!("textures[{}].sampler", info.index.value());
                GltfError::new(at, format!("there is no sampler {number}"))
            })?;
            let repeats = |wrap: &Checked<WrappingMode>| matches!(wrap, Checked::Valid(WrappingMode::Repeat));
            let is_cut = !repeats(&sampler.wrap_s) || !repeats(&sampler.wrap_t);
            notes.extend(is_cut.then(|| format!("{field} repeats")));
            let nearest = matches!(sampler.mag_filter, Some(Checked::Valid(MagFilter::Nearest)));
            notes.extend(nearest.then(|| format!("{field} is interpolated between texels")));
        }
        let image = self.root().images.get(source);
        match image.and_then(|image| image.uri.as_deref()).filter(|uri| !uri.starts_with("data:")) {
            Some(uri) => {
                let uri = path_of_uri(uri).map_err(|reason| GltfError::new(format!("images[{source}].uri"), reason))?;
                Ok(Some(Path::new(path).with_file_name(uri).to_string_lossy().into_owned()))
            }
            None => Ok(Some(format!("{path}#{}", Part::Image(source)))),
        }
    }

    /// The number of a texture's image. Nothing, with a note, where it is of a format that is not read.
    fn image_of(&self, material: &str, field: &str, info: &Info, notes: &mut Vec<String>) -> Result<Option<usize>> {
        let index = info.index.value();
        let texture = self.root().textures.get(index).ok_or_else(|| {
            GltfError::new(format!("{material}.{field}.index"), format!("there is no texture {index}"))
        })?;
        let at = format!("textures[{index}]");
        let there = |at: String, source: usize| match source < self.root().images.len() {
            true => Ok(Some(source)),
            false => Err(GltfError::new(at, format!("there is no image {source}"))),
        };
        // Their image is the one to use. The texture's own is for programs that do not read them.
        for name in ["KHR_texture_basisu", "EXT_texture_webp"] {
            let given = texture.extensions.as_ref().and_then(|found| found.others.get(name)?.get("source"));
            let Some(source) = given else { continue };
            let at = format!("{at}.extensions.{name}.source");
            let number = source.as_u64().and_then(|source| usize::try_from(source).ok());
            let number = number.ok_or_else(|| GltfError::new(&at, "expected the number of an image"))?;
            return there(at, number);
        }
        match texture.source.value() {
            // The crate's word for a source that is not given.
            source if source == u32::MAX as usize => {
                notes.push(format!("without {field}, because {at} has no image of a format that is read"));
                Ok(None)
            }
            source => there(format!("{at}.source"), source),
        }
    }
}

pub fn is_opaque(given: &Given) -> bool {
    !matches!(given.alpha_mode, Checked::Valid(AlphaMode::Mask | AlphaMode::Blend))
}

/// The factor of its alpha, and the cutoff that makes a cut-out surface of it.
fn alpha(given: &Given) -> (f64, Option<f64>) {
    let [_, _, _, factor] = given.pbr_metallic_roughness.base_color_factor.0;
    let factor = decimal(factor).clamp(0.0, 1.0);
    match given.alpha_mode {
        Checked::Valid(AlphaMode::Blend) => (factor, None),
        Checked::Valid(AlphaMode::Mask) => {
            (factor, Some(given.alpha_cutoff.map_or(0.5, |cutoff| decimal(cutoff.0).max(0.0))))
        }
        _ => (1.0, None),
    }
}

/// What each of two surfaces lets pass, so that both together let this colour pass.
fn root_of(colour: Texture, notes: &mut Vec<String>) -> Texture {
    if colour.decoded().is_some() {
        notes.push("the image of its colour tints light at both surfaces of the glass, so twice".to_owned());
    }
    colour.map(|tint| tint.map(f64::sqrt))
}

/// A share of light, cut to its range.
fn share(colour: Colour, name: &str, notes: &mut Vec<String>) -> Colour {
    let cut = colour.clamp(Colour::ZERO, Colour::ONE);
    notes.extend((cut != colour).then(|| format!("{name} is clamped to 0 .. 1")));
    cut
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the figures of KHR_texture_transform: the top left corner of the image turns to the left edge of the bottom.
    #[test]
    fn texture_coordinates_are_scaled_then_turned_then_moved() {
        let quarter_turn = UvTransform { rotation: std::f64::consts::FRAC_PI_2, ..UvTransform::default() };
        let near = |[a, b]: [f64; 2], [c, d]: [f64; 2]| (a - c).abs() + (b - d).abs() < 1e-12;
        assert!(near(quarter_turn.applied([1.0, 0.0]), [0.0, -1.0]));
        let all = UvTransform { offset: [0.5, 0.25], scale: [2.0, 3.0], ..quarter_turn };
        assert!(near(all.applied([1.0, 1.0]), [3.5, -1.75]));
    }
}
