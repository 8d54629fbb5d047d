//! Reads one material of a glTF file: its textures and numbers, and the material of ours that they make.

use std::borrow::Cow;

use gltf::json::extensions::material::{Material as Extensions, Specular, Volume};
use gltf::json::material::Material as Given;

use super::{
    Glass, Model, Named, OfVertices, UvTransform, absorption, alpha, base_texture, changes_the_layer, colour, emission,
    emissive_texture, is_opaque, layer, model, normal_texture, number_texture, numbers, placings, radiance, root_of,
    share, specular_color_texture, specular_texture, transmission, transmission_texture,
};
use crate::bitmap::Channel;
use crate::lobe::To;
use crate::material::MOST_IOR;
use crate::printable::quote;
use crate::scene::gltf::light::light_group;
use crate::scene::gltf::lobes;
use crate::scene::gltf::{File, Result, decimal};
use crate::scene::types::{
    Colour, Conductor, Dielectric, DiffuseLight, Lambertian, Material, Pbr, RoughDielectric, Texture, ThinDielectric,
    Wrap,
};

/// Reads one material.
struct Reader<'a> {
    file: &'a File,
    given: &'a Given,
    /// Its path in the JSON.
    at: String,
    /// The file as the scene names it.
    path: &'a str,
    placings: Vec<UvTransform>,
    /// The properties that are approximated.
    found: Vec<String>,
}

/// The path of an image, and which of the sets of texture coordinates it has.
type Image = Option<(String, u32)>;

/// The parts that several of our materials have.
struct Common {
    /// With all but its layer and its glass.
    pbr: Pbr,
    /// The emitted radiance, which is black where there is none.
    light: Texture,
    /// Whether no light passes straight on.
    is_opaque: bool,
}

fn texture(image: Image, tint: Colour, channel: Option<Channel>) -> Texture {
    match image {
        Some((path, uv_set)) => Texture::Image { path, tint, channel, uv_set, wrap: Wrap::Repeat },
        None => Texture::Rgb(tint.x, tint.y, tint.z),
    }
}

/// A number in a channel of an image. A factor of 0 leaves nothing of the image.
fn share_of(image: Image, factor: f64, channel: Channel) -> Texture {
    texture(image.filter(|_| factor != 0.0), Colour::splat(factor), Some(channel))
}

/// The map that an image is.
fn map_of(image: Image) -> Option<Texture> {
    image.map(|path| texture(Some(path), Colour::ONE, Some(Channel::Rgb)))
}

impl File {
    /// A material in terms of ours. `path` is the file as the scene names it; a note is added if the material is not as the file says.
    pub fn material(
        &self,
        (index, given): (usize, &Given),
        path: &str,
        of_vertices: OfVertices,
        glass: Glass,
        notes: &mut Vec<String>,
    ) -> Result<Material> {
        let at = format!("materials[{index}]");
        lobes::check(given, &at)?;
        let mut reader = Reader { file: self, given, at, path, placings: placings(given), found: Vec::new() };
        let common = reader.common(of_vertices)?;
        let is_dark = common.pbr.emission.is_none();
        let has_colours = of_vertices.colors;
        let light_group = light_group(&given.extras);
        let material = match model(given) {
            Model::Light if common.is_opaque => {
                Material::DiffuseLight(DiffuseLight { emit: common.light, two_sided: given.double_sided, light_group })
            }
            // Other surfaces have two sides, whatever doubleSided says.
            Model::Unlit if common.is_opaque && !has_colours && !is_dark => {
                Material::DiffuseLight(DiffuseLight { emit: common.light, two_sided: true, light_group })
            }
            Model::Glass => reader.glass(common, glass, has_colours),
            // Of a metal nothing is glass.
            Model::Surface
                if common.pbr.metallic == Texture::grey(1.0)
                    && is_dark
                    && common.is_opaque
                    && !has_colours
                    && !lobes::has_own_lobes(given) =>
            {
                let pbr = common.pbr;
                Material::Conductor(Conductor {
                    albedo: Some(pbr.base_color),
                    roughness: pbr.roughness,
                    multiscatter: pbr.multiscatter,
                    anisotropy: pbr.anisotropy,
                    anisotropy_rotation: pbr.anisotropy_rotation,
                    anisotropy_texture: pbr.anisotropy_texture,
                    normal: pbr.normal,
                    normal_scale: pbr.normal_scale,
                    ..Conductor::default()
                })
            }
            // A DiffuseLight has no alpha.
            Model::Light | Model::Unlit => reader.matt(common, of_vertices),
            Model::Surface if reader.is_matt(&common) => reader.matt(common, of_vertices),
            Model::Surface => reader.pbr(common, glass)?,
        };
        reader.tell_unread(glass);
        let Reader { found, at, .. } = reader;
        if !found.is_empty() {
            let name = given.name.as_ref().map_or(String::new(), |name| format!(" ({})", quote(name)));
            notes.push(format!("{at}{name} is approximated: {}", found.join("; ")));
        }
        Ok(material)
    }
}

impl<'a> Reader<'a> {
    fn image(&mut self, named: Option<Named<'_>>) -> Result<Image> {
        let Some((field, info)) = named else { return Ok(None) };
        let placing = UvTransform::from_info(&info);
        let uv_set = self.placings.iter().position(|known| *known == placing).unwrap_or_default() as u32;
        let image = self.file.image_path(&self.at, &field, &info, self.path, &mut self.found)?;
        Ok(image.map(|path| (path, uv_set)))
    }

    /// Reads the lobes that the material has.
    fn lobes(&mut self, pbr: &mut Pbr) -> Result<()> {
        let given = self.given;
        for (_, own) in lobes::present(given).filter(|_| model(given) != Model::Unlit) {
            for field in own.fields {
                let named = lobes::texture(given, own, field)
                    .map(|info| (lobes::place(own, field.texture).into(), Cow::Owned(info)));
                let image = self.image(named)?;
                match field.to {
                    To::Share(channel, to) => {
                        *to(pbr) = share_of(image, lobes::share(given, own, field.factor), channel)
                    }
                    To::Colour(default, to) => {
                        *to(pbr) = texture(image, lobes::colour(given, own, field.factor, default), None);
                    }
                    To::Number(set) => {
                        if let Some(number) = lobes::number(given, own, field.factor) {
                            set(pbr, number);
                        }
                    }
                    To::Map(to, scale) => {
                        if let Some(scale) = scale.filter(|_| image.is_some()) {
                            *scale(pbr) = lobes::scale(given, own, field);
                        }
                        *to(pbr) = map_of(image);
                    }
                }
            }
        }
        Ok(())
    }

    /// Its extensions. What is unlit has its base colour and nothing else.
    fn extensions(&self) -> Option<&'a Extensions> {
        self.given.extensions.as_ref().filter(|_| model(self.given) != Model::Unlit)
    }

    fn specular(&self) -> Option<&'a Specular> {
        self.extensions()?.specular.as_ref()
    }

    fn volume(&self) -> Option<&'a Volume> {
        self.extensions()?.volume.as_ref()
    }

    fn common(&mut self, of_vertices: OfVertices) -> Result<Common> {
        let given = self.given;
        let [r, g, b, _] = given.pbr_metallic_roughness.base_color_factor.0;
        let base = share(colour([r, g, b]), "baseColorFactor", &mut self.found);
        let of_base = self.image(base_texture(given))?;
        let light = match model(given) {
            Model::Unlit => texture(of_base.clone(), radiance(base), None),
            _ => texture(self.image(emissive_texture(given))?, radiance(emission(given)), None),
        };
        let of_numbers = self.image(number_texture(given))?;
        let [roughness, metallic] = numbers(given);
        let of_transmission = self.image(transmission_texture(given))?;
        let normal = map_of(self.image(normal_texture(given))?);
        let scale = given.normal_texture.as_ref().map_or(1.0, |map| decimal(map.scale).clamp(-1e3, 1e3));
        let (factor, alpha_cutoff) = alpha(given);
        let of_alpha = of_base.clone().filter(|_| !is_opaque(given));
        let alpha = share_of(of_alpha, factor, Channel::A);
        // A cutoff that all of it reaches changes nothing.
        let is_opaque =
            alpha == Texture::grey(1.0) && !of_vertices.alpha && alpha_cutoff.is_none_or(|cutoff| cutoff <= 1.0);
        let ior = self.extensions().and_then(|found| found.ior.as_ref()).map_or(1.5, |ior| decimal(ior.ior.0));
        let has_ior = (1.0..=MOST_IOR).contains(&ior);
        self.found.extend((!has_ior).then(|| format!("its ior of {ior} is read as 1.5")));
        let mut pbr = Pbr {
            base_color: texture(of_base, base, None),
            emission: Some(light.clone()).filter(|light| light.plain() != Some(Colour::ZERO)),
            light_group: light_group(&given.extras),
            alpha,
            alpha_cutoff: alpha_cutoff.filter(|_| !is_opaque),
            vertex_colors: of_vertices.colors,
            vertex_alpha: of_vertices.alpha,
            roughness: share_of(of_numbers.clone(), roughness, Channel::G),
            metallic: share_of(of_numbers, metallic, Channel::B),
            ior: if has_ior { ior } else { 1.5 },
            transmission: share_of(of_transmission, transmission(given), Channel::R),
            multiscatter: lobes::multiscatter(given),
            normal_scale: if normal.is_some() { scale } else { 1.0 },
            normal,
            ..Pbr::default()
        };
        self.lobes(&mut pbr)?;
        Ok(Common { pbr, light, is_opaque })
    }

    fn glass(&mut self, common: Common, glass: Glass, has_colours: bool) -> Material {
        self.found.extend((!common.is_opaque).then(|| "without its alpha".to_owned()));
        self.found.extend(has_colours.then(|| "without vertex colours".to_owned()));
        let Pbr { ior, roughness, dispersion, anisotropy, anisotropy_rotation, .. } = common.pbr;
        let Pbr { anisotropy_texture, normal, normal_scale, base_color: color, .. } = common.pbr;
        let color = if glass.colour_of_body { root_of(color, &mut self.found) } else { color };
        let transmittance = Some(color).filter(|color| color.plain() != Some(Colour::ONE));
        let absorption = self.volume().and_then(absorption);
        let is_smooth = roughness == Texture::grey(0.0) && normal.is_none() && anisotropy == 0.0;
        match glass.is_solid {
            false => Material::ThinDielectric(ThinDielectric {
                ior,
                roughness,
                transmittance,
                normal,
                normal_scale,
                ..ThinDielectric::default()
            }),
            true if is_smooth => Material::Dielectric(Dielectric { ior, transmittance, absorption, dispersion }),
            true => Material::RoughDielectric(RoughDielectric {
                ior,
                roughness,
                transmittance,
                absorption,
                dispersion,
                anisotropy,
                anisotropy_rotation,
                anisotropy_texture,
                normal,
                normal_scale,
                ..RoughDielectric::default()
            }),
        }
    }

    /// Whether a surface has a matt body and nothing else.
    fn is_matt(&self, common: &Common) -> bool {
        let black = Texture::grey(0.0);
        self.specular().is_some_and(|specular| specular.specular_factor.0 == 0.0)
            && common.pbr.transmission == black
            && common.pbr.metallic == black
            && !lobes::has_own_lobes(self.given)
    }

    fn matt(&mut self, common: Common, of_vertices: OfVertices) -> Material {
        let (is_light, is_unlit) = (model(self.given) == Model::Light, model(self.given) == Model::Unlit);
        let pbr = common.pbr;
        Material::Lambertian(Lambertian {
            albedo: if is_unlit { Texture::grey(0.0) } else { pbr.base_color },
            emission: if is_light { Some(common.light) } else { pbr.emission },
            alpha: pbr.alpha,
            alpha_cutoff: pbr.alpha_cutoff,
            vertex_colors: of_vertices.colors && !is_unlit,
            vertex_alpha: of_vertices.alpha,
            vertex_emission: of_vertices.colors && is_unlit,
            normal: pbr.normal,
            normal_scale: pbr.normal_scale,
            one_sided: false,
            one_sided_emission: is_light && !self.given.double_sided,
            light_group: light_group(&self.given.extras),
        })
    }

    fn pbr(&mut self, common: Common, glass: Glass) -> Result<Material> {
        let (given, pbr) = (self.given, common.pbr);
        let [of_specular, of_specular_color] =
            [self.image(specular_texture(given))?, self.image(specular_color_texture(given))?];
        let (specular, ior, layer_color) = self.specular().map_or((1.0, pbr.ior, Colour::ONE), |it| layer(it, pbr.ior));
        let volume = self.volume();
        let is_glassy = pbr.transmission != Texture::grey(0.0);
        let solid = glass.is_solid && is_glassy;
        let is_tinted = pbr.base_color.plain() != Some(Colour::ONE);
        let passes = pbr.diffuse_transmission != Texture::grey(0.0);
        self.found.extend(
            (passes && volume.is_some() && !is_glassy)
                .then(|| "its volume is not read: light passes its surface as it passes paper".to_owned()),
        );
        self.found.extend(
            (is_glassy && glass.colour_of_body && is_tinted)
                .then(|| "the base colour tints light at both surfaces of the glass, so twice".to_owned()),
        );
        Ok(Material::Pbr(Pbr {
            ior,
            specular: share_of(of_specular, specular, Channel::A),
            specular_color: texture(of_specular_color, layer_color, None),
            solid,
            absorption: volume.filter(|_| solid).and_then(absorption),
            dispersion: if solid { pbr.dispersion } else { 0.0 },
            ..pbr
        }))
    }

    /// Notes the fields and the extensions that are not read.
    fn tell_unread(&mut self, glass: Glass) {
        let given = self.given;
        let model = model(given);
        let has = |it: bool, name: &str| it.then(|| name.to_owned());
        let emits = given.emissive_factor.0 != [0.0; 3];
        let is_brushed_pane = !glass.is_solid && lobes::has(given, "anisotropy");
        let is_lit = !matches!(model, Model::Light | Model::Unlit);
        let unread = [
            has(model == Model::Glass && emits, "emissiveFactor"),
            has(model == Model::Glass && is_brushed_pane, "KHR_materials_anisotropy on a pane"),
            has(model == Model::Glass && self.specular().is_some_and(changes_the_layer), "KHR_materials_specular"),
            has(is_lit && given.occlusion_texture.is_some(), "occlusionTexture"),
        ];
        let others = self.extensions().into_iter().flat_map(|found| found.others.keys());
        let others = others.filter(|name| !lobes::is_read(name)).map(quote);
        let unread: Vec<String> = unread.into_iter().flatten().chain(others).collect();
        self.found.extend((!unread.is_empty()).then(|| format!("not read: {}", unread.join(", "))));
    }
}
