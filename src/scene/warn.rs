//! Warnings about values that are allowed but likely to disappoint.

use std::collections::HashSet;

use super::image_files::visit_images;
use super::model::Scene;
use super::types::*;
use crate::printable::and_more;
use crate::source::ValuePath;

impl Scene {
    /// Warnings about values that are allowed but likely to disappoint. Each names file:line:column, the number and a
    /// remedy, in the file's order. Warnings that depend on the positions of placed objects come from flattening.
    pub fn warnings(&self) -> Vec<String> {
        let top = self.top();
        let mut used = HashSet::new();
        self.visit_objects(&mut |_, object| used.extend(object.material()));
        used.extend(self.materials.iter().flat_map(|(_, material)| material.parts().map(|(_, name)| name)));
        let mut warnings = self.notes.clone();
        warnings.extend(radians(&top.field("camera").field("vertical_fov")));
        let mut cleaned = HashSet::new();
        visit_images(self, &mut |at, path, decoding, _, _| {
            let bitmap = self.bitmaps.get(path, decoding);
            if let Some(warning) =
                bitmap.and_then(|bitmap| bitmap.warning.as_ref()).filter(|_| cleaned.insert(path.to_owned()))
            {
                warnings.push(at.warning(&format!("{path}: {warning}")));
            }
        });
        for (name, material) in &self.materials {
            let materials = top.field("materials");
            let at = materials.key(name);
            if !used.contains(name.as_str()) {
                warnings.push(at.warning("no object uses this material: use it or remove it"));
            }
            warnings.extend(material.warnings(&at, &self.bitmaps));
        }
        if self.objects.is_empty() {
            let message = "there are 0 objects, so that the image shows only the background: add objects";
            warnings.push(top.field("objects").warning(message));
        }
        let camera = top.field("camera");
        let focus = self.camera.focus_distance.unwrap_or((self.camera.look_at - self.camera.look_from).length());
        let radius = 0.5 * self.camera.aperture;
        if focus < radius {
            let message = format!(
                "the focus distance of {focus} is less than the lens radius of {radius}, so that nothing is sharp: write the distance to \
                 what should be sharp, or an aperture below {}",
                2.0 * focus
            );
            warnings.push(camera.field("focus_distance").warning(&message));
        }
        let moving = camera.field("moving");
        warnings.extend(self.no_motion(&moving, &self.camera.moving));
        let mut at_rest: Vec<String> = Vec::new();
        let mut reported = HashSet::new();
        self.visit_objects(&mut |at, object| match object {
            Object::Medium { density, .. } if density.scale() == 0.0 => {
                let message = "a density of 0 means that the medium has no effect: remove it or raise its density";
                warnings.push(at.field("density").warning(message));
            }
            Object::Medium { density, .. } => {
                let field = at.field("density");
                warnings.extend(self.grid_of(density.grid()).and_then(|grid| grid.warning()).map(|text| field.warning(&text)));
            }
            Object::Mesh { path, .. } if reported.insert(path) => {
                let flat = ["none of its faces has an area: it is left out".to_owned()];
                let about = self.meshes.get(path).map_or(&flat[..], |mesh| &mesh.warnings);
                warnings.extend(about.iter().map(|text| at.field("path").warning(&format!("{path}: {text}"))));
            }
            Object::Gltf { frame: Some(_), .. } if self.camera.shutter.0 < self.camera.shutter.1 => {
                let message = "a frame is one pose, so that nothing in it moves while the shutter is open: put it into Moving(..) to move \
                               it as a whole";
                warnings.push(at.field("frame").warning(message));
            }
            Object::Transformed { by, .. } => warnings.extend(angles(&at.field("by"), by)),
            Object::Moving { keys, .. } => {
                let keys_field = at.field("keys");
                for (index, (_, by)) in keys.iter().enumerate() {
                    warnings.extend(angles(&keys_field.index(index).index(1), by));
                }
                at_rest.extend(self.no_motion(&keys_field, keys));
            }
            _ => warnings.extend(object.delta_light().and_then(|light| light.warning(at))),
        });
        let more = and_more(at_rest.len().saturating_sub(1));
        warnings.extend(at_rest.into_iter().next().map(|first| first + &more));
        warnings
    }

    /// The warning that the motion between keys does not show, because the shutter is open for no time. From frame to frame it shows.
    fn no_motion<T: PartialEq>(&self, at: &ValuePath, keys: &[(f64, T)]) -> Option<String> {
        let ([(first, _), .., (last, _)], (open, close)) = (keys, self.camera.shutter) else { return None };
        let moves = keys.windows(2).any(|keys| keys[0].1 != keys[1].1);
        let message = format!(
            "the shutter opens and closes at {open}, so that the motion does not show in the image: write a camera.shutter such as \
             ({first}, {last})"
        );
        (open == close && moves && self.frame.is_none()).then(|| at.warning(&message))
    }
}

/// The warnings about the angles of transforms.
fn angles(at: &ValuePath, by: &[Transform]) -> Vec<String> {
    let angle = |(index, transform): (usize, &Transform)| {
        let at = at.index(index);
        match transform {
            Transform::RotateX(_) => radians(&at.variant("RotateX")),
            Transform::RotateY(_) => radians(&at.variant("RotateY")),
            Transform::RotateZ(_) => radians(&at.variant("RotateZ")),
            Transform::Rotate { .. } => radians(&at.variant("Rotate").field("degrees")),
            Transform::Translate(_) | Transform::Scale(_) => None,
        }
    };
    by.iter().enumerate().filter_map(angle).collect()
}

/// The warning that an angle is surely written in radians.
fn radians(at: &ValuePath) -> Option<String> {
    let text = at.text();
    let degrees = degrees_of_radians(text)?;
    let message = format!("{text} is {degrees} degrees in radians, and angles are in degrees: write {degrees}");
    Some(at.warning(&message))
}

/// The multiple of 5 degrees that a number is in radians, to all of its digits. Of fewer than five digits nothing is sure.
fn degrees_of_radians(text: &str) -> Option<i32> {
    let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let digits = mantissa.trim_start_matches(['+', '-', '0', '.']).chars().filter(char::is_ascii_digit).count();
    if digits < 5 {
        return None;
    }
    let decimals = mantissa.split_once('.').map_or(0, |(_, decimals)| decimals.len()) as i32;
    let last = 10f64.powi(exponent.parse::<i32>().ok()?.saturating_sub(decimals));
    let value: f64 = text.parse().ok()?;
    let degrees = 5.0 * (value.to_degrees() / 5.0).round();
    // Cut off or rounded. Numbers of more digits than f64 has are not exact.
    let near = (value - degrees.to_radians()).abs() <= last.max(1e-15 * value.abs());
    (near && degrees != 0.0 && degrees.abs() <= 360.0).then_some(degrees as i32)
}

#[cfg(test)]
mod tests {
    use super::degrees_of_radians;

    #[test]
    fn radians_are_known_by_their_digits() {
        for (text, degrees) in [
            ("1.5708", Some(90)),
            ("1.5707", Some(90)),
            ("1.57079632679489661923", Some(90)),
            ("-0.78540", Some(-45)),
            ("-0.785398", Some(-45)),
            ("6.98132e-1", Some(40)),
            ("0.0872665", Some(5)),
            ("+6.2832", Some(360)),
            // Too few digits, other digits, other angles, and degrees.
            ("1.571", None),
            ("0.785", None),
            ("1.5706", None),
            ("1.57080", Some(90)),
            ("1.57090", None),
            ("0.01745329", None),
            ("12.5664", None),
            ("90.000", None),
            ("0.00000", None),
            ("30", None),
            ("36.8699", None),
            ("x1.5708", None),
            ("1.5708e99999999999", None),
            ("", None),
        ] {
            assert_eq!(degrees_of_radians(text), degrees, "{text}");
        }
    }
}
