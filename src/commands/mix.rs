//! The light of an image whose groups of lights are brighter or darker: `gpu-rt develop --lights`.

use std::path::Path;

use crate::data::Rgb;
use crate::error::{Error, Result};
use crate::film::{Picture, UNKNOWN_VARIANCE, relative_error};
use crate::output::exr::{
    Attribute, StateFile, light_layers, of_image_alone, read_attributes, read_exr, read_layer, write_exr,
};

/// The factors of groups of lights, by their names.
#[derive(Clone, Debug, PartialEq)]
pub struct Factors(Vec<(String, Rgb<f64>)>);

impl Factors {
    /// Parses `key=1.5,sky=0.8:0.9:1`: a factor, or one each for red, green and blue.
    ///
    /// # Errors
    /// The expected form, in words.
    pub fn parse(text: &str) -> std::result::Result<Factors, String> {
        let factor = |text: &str| text.trim().parse::<f64>().ok().filter(|factor| factor.is_finite() && *factor >= 0.0);
        let one = |part: &str| {
            let (name, factors) = part.split_once('=')?;
            let factors: Option<Vec<f64>> = factors.split(':').map(factor).collect();
            let factors = match factors?.as_slice() {
                [all] => [*all; 3],
                [r, g, b] => [*r, *g, *b],
                _ => return None,
            };
            Some((name.trim().to_string(), factors))
        };
        let expected = |part: &str| {
            format!("expected NAME=FACTOR or NAME=RED:GREEN:BLUE with factors of 0 or more, found `{part}`")
        };
        let all = text.split(',').map(|part| one(part).ok_or_else(|| expected(part)));
        let all = all.collect::<std::result::Result<Vec<_>, _>>()?;
        let twice =
            all.iter().enumerate().find(|(index, (name, _))| all[..*index].iter().any(|(other, _)| other == name));
        twice.map_or(Ok(()), |(_, (name, _))| Err(format!("{name} has two factors")))?;
        Ok(Factors(all))
    }

    fn of(&self, group: &str) -> Rgb<f64> {
        self.0.iter().find(|(name, _)| name == group).map_or([1.0; 3], |(_, factor)| *factor)
    }
}

impl std::fmt::Display for Factors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let all: Vec<String> = self.0.iter().map(|(name, [r, g, b])| format!("{name}={r}:{g}:{b}")).collect();
        f.write_str(&all.join(","))
    }
}

/// A mix of the lights of an image.
pub struct Mix {
    pub picture: Picture,
    /// The relative error, by the halves of the mix; nothing where the file has no state.
    pub error: Option<f64>,
}

/// Mixes the lights of a file.
///
/// # Errors
/// `Error::Usage` if it has no lights apart, or none of such a name. `Error::File` if it cannot be read.
pub fn mixed(path: &Path, factors: &Factors) -> Result<Mix> {
    let layers = light_layers(path)?;
    let name = path.display();
    if layers.is_empty() {
        return Err(Error::Usage(format!("{name}: it has no lights apart: `gpu-rt render --aov lights` writes them")));
    }
    if let Some((unknown, _)) = factors.0.iter().find(|(name, _)| layers.iter().all(|(group, _)| group != name)) {
        let known: Vec<&str> = layers.iter().map(|(group, _)| group.as_str()).collect();
        return Err(Error::Usage(format!("--lights: {name} has no group {unknown}; it has {}", known.join(", "))));
    }
    let image = read_exr(path)?;
    let mut rgb = vec![[0.0; 3]; image.rgb.len()];
    for (group, layer) in &layers {
        let factor = factors.of(group);
        for (sum, light) in rgb.iter_mut().zip(read_layer(path, layer)?.rgb) {
            (0..3).for_each(|c| sum[c] += factor[c] * f64::from(light[c]));
        }
    }
    let variances = variances(path, factors)?;
    let error = variances.as_deref().and_then(|variances| relative_error(&rgb, variances));
    let counts = |counts: Option<Vec<u32>>| counts.unwrap_or_else(|| vec![0; rgb.len()]);
    let to_f32 = |v: Rgb<f64>| v.map(|v| (v as f32).clamp(f32::MIN, f32::MAX));
    let picture = Picture {
        width: image.width,
        height: image.height,
        variance: variances.map_or(vec![[UNKNOWN_VARIANCE; 3]; rgb.len()], |all| {
            all.into_iter().map(|v| v.map_or([UNKNOWN_VARIANCE; 3], to_f32)).collect()
        }),
        samples: counts(image.samples),
        rejected: counts(image.rejected),
        rgb: rgb.into_iter().map(to_f32).collect(),
    };
    Ok(Mix { picture, error })
}

/// The variance of each pixel of the mix, `None` where it is not known; nothing where the file has no state.
fn variances(path: &Path, factors: &Factors) -> Result<Option<Vec<Option<Rgb<f64>>>>> {
    let Some(file) = StateFile::open(path)? else { return Ok(None) };
    let groups = file.state.light_groups.iter().map(String::as_str).chain([crate::aov::REST]);
    let factors: Vec<Rgb<f64>> = groups.map(|group| factors.of(group)).collect();
    let mut film = file.state.film()?;
    file.add_to(&mut film)?;
    let film = &film.film;
    let pixels = film.width() as usize * film.height() as usize;
    Ok(Some((0..pixels).map(|index| film.variance_of_mix(index, &factors)).collect()))
}

/// Writes a mix as an EXR, with the header of the file that it is of. It has no state.
pub fn write(path: &Path, mix: &Mix, of: &Path, factors: &Factors) -> Result<()> {
    let mut attributes = read_attributes(of)?;
    attributes.retain(|(name, _)| of_image_alone(name));
    attributes.push(("gpu-rt:lights".to_string(), Attribute::Text(factors.to_string())));
    attributes.extend(mix.error.map(|error| ("gpu-rt:relative_error".to_string(), Attribute::Float(error))));
    write_exr(path, &mix.picture, &attributes)
}
