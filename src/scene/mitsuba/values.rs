//! Numbers and colours of attributes.

use glam::DVec3;

use super::document::Node;
use crate::bitmap::light_of_srgb;
use crate::error::Result;
use crate::printable::quote;
use crate::scene::imported::spectrum;
use crate::scene::types::Colour;

pub fn number(node: &Node, name: &str) -> Result<f64> {
    let text = node.required(name)?;
    let found = text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    found.ok_or_else(|| node.error_at(name, format!("expected a number, found {}", quote(text))))
}

/// The numbers of an attribute, with spaces or commas between them.
pub fn numbers(node: &Node, name: &str) -> Result<Vec<f64>> {
    let text = node.required(name)?;
    let words = text.split([',', ' ', '\t', '\n', '\r']).filter(|word| !word.is_empty());
    let read = |word: &str| word.parse::<f64>().ok().filter(|number| number.is_finite());
    let all: Option<Vec<f64>> = words.map(read).collect();
    all.ok_or_else(|| node.error_at(name, format!("expected numbers, found {}", quote(text))))
}

/// The point of an attribute.
pub fn point(node: &Node, name: &str) -> Result<DVec3> {
    match numbers(node, name)?[..] {
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        ref other => Err(node.error_at(name, format!("expected three numbers, found {}", other.len()))),
    }
}

/// x, y and z of an element, or its `value`. What is left out has the default.
pub fn vector(node: &Node, default: f64) -> Result<DVec3> {
    if node.attribute("value").is_some() {
        return match numbers(node, "value")?[..] {
            [x] => Ok(DVec3::splat(x)),
            _ => point(node, "value"),
        };
    }
    let axis = |name: &str| if node.attribute(name).is_some() { number(node, name) } else { Ok(default) };
    Ok(DVec3::new(axis("x")?, axis("y")?, axis("z")?))
}

/// The colour of an element, linear Rec. 709.
pub fn colour(node: &Node) -> Result<Colour> {
    match (node.attribute("type"), &node.children[..]) {
        (None, _) => {}
        (Some("blackbody"), [kelvins]) if kelvins.attribute("name") == Some("temperature") => {
            let kelvins = Some(number(kelvins, "value")?).filter(|kelvins| *kelvins > 0.0);
            let kelvins = kelvins.ok_or_else(|| node.error("expected a temperature above 0 kelvins"))?;
            return Ok(spectrum::of_black_body(kelvins));
        }
        (Some("blackbody"), _) => return Err(node.error("expected a temperature in it, and nothing else")),
        (Some("d65" | "uniform" | "rgb" | "srgb"), [given]) => return colour(given),
        (Some("d65"), []) => return Ok(Colour::ONE),
        (Some("uniform"), []) if node.attribute("value").is_some() => {}
        (Some(name), _) => {
            return Err(node.error_at("type", format!("the spectrum {name} is not read: give an <rgb> instead")));
        }
    }
    let text = node.required("value")?.trim();
    if let Some(digits) = text.strip_prefix('#') {
        let code = u32::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 6);
        let code = code.ok_or_else(|| node.error_at("value", format!("expected #rrggbb, found {}", quote(text))))?;
        let channel = |shift: u32| light_of_srgb(f64::from(code >> shift & 255) / 255.0);
        return Ok(Colour::new(channel(16), channel(8), channel(0)));
    }
    if text.contains(':') {
        let name = node.attribute("name").unwrap_or_default();
        if ["eta", "k", "sigma_t", "int_ior", "ext_ior"].contains(&name) {
            return Err(node.error_at("value", format!("{name} by wavelengths is not read: give an <rgb> instead")));
        }
        let is_emission = ["radiance", "intensity", "irradiance"].contains(&name);
        return Ok(spectrum::of_pairs(&pairs(node, text)?, is_emission));
    }
    match numbers(node, "value")?[..] {
        [grey] => Ok(Colour::splat(grey)),
        [r, g, b] if node.tag == "rgb" => Ok(Colour::new(r, g, b)),
        _ => {
            Err(node
                .error_at("value", format!("expected one number{}", if node.tag == "rgb" { " or three" } else { "" })))
        }
    }
}

/// The values of a spectrum at wavelengths that rise.
fn pairs(node: &Node, text: &str) -> Result<Vec<(f64, f64)>> {
    let pair = |word: &str| {
        let (wavelength, value) = word.split_once(':')?;
        Some((wavelength.trim().parse().ok()?, value.trim().parse().ok()?))
    };
    let words = text.split([',', ' ', '\t', '\n', '\r']).filter(|word| !word.is_empty());
    let all: Option<Vec<_>> = words.map(pair).collect();
    all.filter(|pairs| spectrum::rise(pairs)).ok_or_else(|| {
        let expected = "expected WAVELENGTH:VALUE, .. with wavelengths that rise";
        node.error_at("value", format!("{expected}, found {}", quote(text)))
    })
}
