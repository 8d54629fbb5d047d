//! The materials of OBJ files (MTL): the statements of Wavefront's format, and those of its extension for physically based materials.
//!
//! The reader is our own: names of files have spaces and options, and errors and notes name their line.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use super::input::{Input, number, rest_of, words};
use super::obj::{Lines, Named};
use crate::bitmap::Channel;
use crate::material::MOST_IOR;
use crate::printable::quote;
use crate::scene::file;
use crate::scene::gltf::{default_material, radiance};
use crate::scene::types::{Colour, Dielectric, Lambertian, Material, Pbr, Texture, Wrap};

/// The longest file, in bytes.
const LONGEST: u64 = 1 << 26;
/// Statements with numbers and with images that are read, and those that change nothing here.
const NUMBERS: [&str; 11] = ["Kd", "Ks", "Ke", "Tf", "Ns", "Ni", "d", "Tr", "Pr", "Pm", "illum"];
const IMAGES: [&str; 6] = ["map_Kd", "map_Ke", "map_d", "map_Pr", "map_Pm", "norm"];
const IGNORED: [&str; 3] = ["Ka", "map_Ka", "sharpness"];

/// A material as its file gives it.
#[derive(Default)]
pub struct Given {
    /// The place of its newmtl.
    pub place: String,
    numbers: HashMap<&'static str, Colour>,
    /// The places of images with their files.
    images: HashMap<&'static str, (String, PathBuf)>,
    unread: BTreeSet<String>,
}

/// The materials of a file by their names. An error has its line.
pub fn read(path: &Path) -> Result<HashMap<String, Given>, String> {
    let bytes = file::read(path, "file of materials", LONGEST)?;
    let mut tell = |_| {};
    let mut input = Input::new(&bytes, &mut tell);
    let mut lines = Lines::new(&mut input);
    let mut found: HashMap<String, Given> = HashMap::new();
    let mut current = None;
    while lines.advance() {
        let mut words = words(&lines.line);
        let Some(word) = words.next().filter(|word| !word.starts_with(b"#")) else { continue };
        let place = format!("{}:{}", path.display(), lines.number);
        if word == b"newmtl" {
            let name = rest_of(&lines.line);
            found.insert(name.clone(), Given { place, ..Given::default() });
            current = Some(name);
            continue;
        }
        let Some(given) = current.as_ref().and_then(|name| found.get_mut(name)) else { continue };
        let is = |name: &&&str| word.eq_ignore_ascii_case(name.as_bytes());
        if let Some(name) = NUMBERS.iter().find(is) {
            let values: Vec<&[u8]> = words.take_while(|word| !word.starts_with(b"#")).collect();
            if values.first().is_some_and(|first| [&b"spectral"[..], b"xyz"].contains(first)) {
                given.unread.insert(format!("{name} {}", String::from_utf8_lossy(values[0])));
                continue;
            }
            // Options, such as -halo of d, come before the number.
            let values = values.iter().filter(|word| !word.starts_with(b"-") || number::<f64>(word).is_some());
            let numbers: Option<Vec<f64>> =
                values.map(|word| number(word).filter(|number: &f64| number.is_finite())).collect();
            let value = match numbers.as_deref() {
                Some([grey]) => Colour::splat(*grey),
                Some([r, g, b, ..]) => Colour::new(*r, *g, *b),
                _ => {
                    return Err(format!(
                        "line {}: {name}: expected one number or three, found {}",
                        lines.number,
                        quote(rest_of(&lines.line).as_bytes())
                    ));
                }
            };
            given.numbers.insert(name, value);
        } else if let Some(name) = IMAGES.iter().find(is) {
            let (text, options) = without_options(&rest_of(&lines.line));
            given.unread.extend(options.into_iter().map(|option| format!("{option} of {name}")));
            given.images.insert(name, (place, image(path, &text)));
        } else if !IGNORED.iter().any(|name| is(&name)) {
            given.unread.insert(String::from_utf8_lossy(word).chars().take(40).collect());
        }
    }
    Ok(found)
}

/// The name of an image, which may have spaces, and the options before it.
fn without_options(text: &str) -> (String, Vec<String>) {
    let (mut rest, mut options) = (text, Vec::new());
    while rest.starts_with('-') {
        let (option, mut behind) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
        options.push(option.to_owned());
        behind = behind.trim_start();
        // The option's values: one word, or so many numbers at most.
        let words = ["-blendu", "-blendv", "-cc", "-clamp", "-imfchan", "-texres", "-type", "-colorspace"];
        let is_word = words.contains(&option);
        let mut left = if is_word || ["-bm", "-boost"].contains(&option) { 1 } else { 3 };
        while let Some((value, more)) = behind.split_once(char::is_whitespace)
            && left > 0
            && (is_word || value.parse::<f64>().is_ok())
        {
            (behind, left) = (more.trim_start(), left - 1);
        }
        rest = behind;
    }
    (rest.to_owned(), options)
}

/// The file of an image: beside the file of materials by its path, by its path with Windows' separators, or by its name alone.
fn image(library: &Path, text: &str) -> PathBuf {
    let slashed = text.replace('\\', "/");
    let name = slashed.rsplit('/').next().unwrap_or_default().to_owned();
    let beside = |path: &str| library.with_file_name("").join(path);
    let known = [text, &slashed, &name].map(beside);
    let found = known.iter().find(|path| path.is_file()).unwrap_or(&known[0]);
    found.clone()
}

impl Given {
    /// The material in terms of ours, on a mesh that has texture coordinates or not. `seen` gives a file's path as the scene names it.
    pub fn material(
        &self,
        name: &str,
        has_uvs: bool,
        seen: &dyn Fn(&Path) -> String,
        notes: &mut Vec<String>,
    ) -> Material {
        let given = |name: &str| self.numbers.get(name).copied();
        let share = |name: &str, default: f64| given(name).map_or(default, |value| value.x.clamp(0.0, 1.0));
        let mut image = |name: &str| -> Option<&PathBuf> {
            let (place, path) = self.images.get(name)?;
            let reason = match (path.is_file(), has_uvs) {
                (true, true) => return Some(path),
                (true, false) => "some of its faces have no texture coordinates".to_owned(),
                (false, _) => format!("there is no file {}", path.display()),
            };
            notes.push(format!("{place}: {name}: {reason}: it is left out"));
            None
        };
        let texture = |image: Option<&PathBuf>, tint: Colour, channel| match image {
            Some(path) => Texture::Image { path: seen(path), tint, channel, uv_set: 0, wrap: Wrap::Repeat },
            None => Texture::Rgb(tint.x, tint.y, tint.z),
        };
        // Some programs write black beside an image, which is meant to be seen.
        let factor = |name: &str, has_image: bool, default: Colour| match given(name) {
            Some(Colour::ZERO) | None if has_image => Colour::ONE,
            value => value.unwrap_or(default),
        };
        let [of_base, of_light, of_alpha] = [image("map_Kd"), image("map_Ke"), image("map_d")];
        let base = factor("Kd", of_base.is_some(), Colour::splat(0.8)).clamp(Colour::ZERO, Colour::ONE);
        let light = radiance(factor("Ke", of_light.is_some(), Colour::ZERO).max(Colour::ZERO));
        let color = texture(of_base, base, None);
        let emission = (light != Colour::ZERO).then(|| texture(of_light, light, None));
        let opacity = given("d").or(given("Tr").map(|transparency| Colour::ONE - transparency));
        let opacity = opacity.unwrap_or(Colour::ONE).clamp(Colour::ZERO, Colour::ONE);
        // An image of colours that is also that of the opacity has it in its alpha.
        let channel = if of_alpha == of_base { Channel::A } else { Channel::R };
        let alpha = texture(of_alpha, opacity, of_alpha.map(|_| channel));
        let ior = given("Ni").map_or(1.5, |ior| if ior.x > 1.0 { ior.x.min(MOST_IOR) } else { 1.5 });
        // The α of microfacets as narrow as Phong's lobe (Walter et al., "Microfacet Models for Refraction", EGSR 2007, 5.2), whose root
        // is the roughness.
        let of_exponent = given("Ns").map(|exponent| (2.0 / (exponent.x.max(0.0) + 2.0)).powf(0.25));
        let number =
            |image: Option<&PathBuf>, value: f64| texture(image, Colour::splat(value), image.map(|_| Channel::R));
        let of_roughness = image("map_Pr");
        let roughness =
            number(of_roughness, share("Pr", if of_roughness.is_some() { 1.0 } else { of_exponent.unwrap_or(0.5) }));
        let of_metal = image("map_Pm");
        let metallic = number(of_metal, share("Pm", if of_metal.is_some() { 1.0 } else { 0.0 }));
        let normal = image("norm").map(|path| texture(Some(path), Colour::ONE, Some(Channel::Rgb)));
        let is_physical = ["Pr", "Pm"].iter().any(|name| given(name).is_some()) || of_roughness.or(of_metal).is_some();
        let refracts = given("illum").is_some_and(|model| [6.0, 7.0].contains(&model.x));
        let material = if refracts {
            let transmittance =
                given("Tf").map(|through| through.clamp(Colour::ZERO, Colour::ONE)).filter(|it| *it != Colour::ONE);
            let transmittance = transmittance.map(|through| texture(None, through, None));
            Material::Dielectric(Dielectric { ior, transmittance, ..Dielectric::default() })
        } else if !is_physical && given("Ks").is_none_or(|specular| specular == Colour::ZERO) {
            Material::Lambertian(Lambertian { albedo: color, emission, alpha, normal, ..Lambertian::default() })
        } else {
            let default = default_material(true, false);
            Material::Pbr(Pbr { base_color: color, metallic, roughness, ior, emission, alpha, normal, ..default })
        };
        let lost = (refracts && light != Colour::ZERO).then(|| "Ke of clear glass".to_owned());
        let found: Vec<String> = self.unread.iter().cloned().chain(lost).collect();
        if !found.is_empty() {
            notes.push(format!("{}: {}: not read: {}", self.place, quote(name), found.join(", ")));
        }
        material
    }
}

/// The files of materials that an OBJ file names: of each line one with spaces in its name, or several.
pub fn libraries(obj: &Path, named: &[Named]) -> Vec<(PathBuf, u64)> {
    let beside = |name: &str| obj.with_file_name("").join(name.replace('\\', "/"));
    let of_line = |(name, line): &Named| match beside(name).is_file() {
        true => vec![(beside(name), *line)],
        false => name.split_whitespace().map(|name| (beside(name), *line)).collect(),
    };
    named.iter().flat_map(of_line).collect()
}
