//! Similarity transforms in f64. All transforms of a scene compose to one.

use glam::{DMat3, DVec3};

/// A uniform scaling, then a rotation, then a translation.
#[derive(Clone, Copy, Debug)]
pub struct Similarity {
    pub scale: f64,
    pub rotation: DMat3,
    pub translation: DVec3,
}

impl Similarity {
    pub const IDENTITY: Similarity = Similarity { scale: 1.0, rotation: DMat3::IDENTITY, translation: DVec3::ZERO };

    pub fn translation(translation: DVec3) -> Similarity {
        Similarity { translation, ..Similarity::IDENTITY }
    }

    pub fn scale(scale: f64) -> Similarity {
        Similarity { scale, ..Similarity::IDENTITY }
    }

    /// Right-handed, by Rodrigues' formula. Quarter turns are exact, because sines and cosines are of degrees, not of
    /// rounded radians.
    pub fn rotation(axis: DVec3, degrees: f64) -> Similarity {
        Similarity { rotation: rotation_about(axis, degrees), ..Similarity::IDENTITY }
    }

    pub fn point(&self, p: DVec3) -> DVec3 {
        self.vector(p) + self.translation
    }

    pub fn vector(&self, v: DVec3) -> DVec3 {
        self.scale * (self.rotation * v)
    }

    pub fn inverse(&self) -> Similarity {
        let (scale, rotation) = (1.0 / self.scale, self.rotation.transpose());
        Similarity { scale, rotation, translation: -scale * (rotation * self.translation) }
    }

    /// First `inner`, then this.
    pub fn after(&self, inner: &Similarity) -> Similarity {
        Similarity {
            scale: self.scale * inner.scale,
            rotation: self.rotation * inner.rotation,
            translation: self.point(inner.translation),
        }
    }
}

fn rotation_about(axis: DVec3, degrees: f64) -> DMat3 {
    // Divided by its largest component first, because the squares of a short axis would underflow.
    let axis = (axis / axis.abs().max_element()).normalize();
    let degrees = degrees.rem_euclid(360.0);
    let (quarter, rest) = ((degrees / 90.0).floor(), degrees % 90.0);
    let (s, c) = rest.to_radians().sin_cos();
    let (s, c) = match quarter as i32 {
        1 => (c, -s),
        2 => (-s, -c),
        3 => (-c, s),
        _ => (s, c),
    };
    let column = |v: DVec3| v * c + axis.cross(v) * s + axis * (axis.dot(v) * (1.0 - c));
    DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
}
