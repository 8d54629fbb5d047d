//! Transforms: each is applied after those above it.

use glam::{DAffine3, DMat3, DVec3};

use super::document::Node;
use super::values::{number, numbers, point, vector};
use crate::error::{Result, require};
use crate::scene::imported::transform::look_at;

/// The transform of an element.
pub fn of(node: &Node) -> Result<DAffine3> {
    let mut all = DAffine3::IDENTITY;
    for step in &node.children {
        all = one(step)? * all;
    }
    require(all.is_finite(), || node.error("expected finite numbers in the product of its transforms"))?;
    Ok(all)
}

fn one(step: &Node) -> Result<DAffine3> {
    match step.tag.as_str() {
        "translate" => Ok(DAffine3::from_translation(vector(step, 0.0)?)),
        "scale" => Ok(DAffine3::from_scale(vector(step, 1.0)?)),
        "rotate" => {
            let axis = vector(step, 0.0)?;
            // Mitsuba does not make the axis a unit vector: about others this is no turn.
            let ((sin, cos), cross) = (number(step, "angle")?.to_radians().sin_cos(), |v: DVec3| axis.cross(v));
            let column = |unit: DVec3| cos * unit + sin * cross(unit) + (1.0 - cos) * axis.dot(unit) * axis;
            Ok(DAffine3::from_mat3(DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))))
        }
        "lookat" => {
            let (origin, target) = (point(step, "origin")?, point(step, "target")?);
            let forward = (target - origin).normalize_or_zero();
            let up = if step.attribute("up").is_some() { point(step, "up")? } else { DVec3::ZERO };
            // Without one Mitsuba takes an axis of a frame around the view (Duff et al., JCGT 6(1), 2017).
            let sign = 1f64.copysign(forward.z);
            let b = -forward.x / (sign + forward.z);
            let any = DVec3::new(1.0 + sign * forward.x * b, sign * forward.y * b, -sign * forward.x);
            look_at(origin, target, if up == DVec3::ZERO { any } else { up }).map_err(|message| step.error(message))
        }
        "matrix" => match numbers(step, "value")?[..] {
            [a, b, c, d, e, f, g, h, i] => Ok(rows([a, b, c, d, e, f, g, h, i], DVec3::ZERO)),
            [a, b, c, x, d, e, f, y, g, h, i, z, 0.0, 0.0, 0.0, 1.0] => {
                Ok(rows([a, b, c, d, e, f, g, h, i], DVec3::new(x, y, z)))
            }
            ref all if all.len() == 16 => Err(step.error_at("value", "expected 0 0 0 1 in the last row")),
            ref all => Err(step.error_at("value", format!("expected 9 or 16 numbers, found {}", all.len()))),
        },
        _ => Err(step.error("expected translate, rotate, scale, lookat or matrix")),
    }
}

fn rows(numbers: [f64; 9], translation: DVec3) -> DAffine3 {
    DAffine3 { matrix3: DMat3::from_cols_array(&numbers).transpose(), translation }
}
