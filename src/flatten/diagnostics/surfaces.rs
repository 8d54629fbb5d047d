//! Finds large spheres whose surface is so near to the camera that f32 does not resolve the distance.

use super::{At, Body, Diagnostic, U, Worst, short};
use crate::shape::Hull;

/// The largest rounding of a sphere's distance from the camera, as a share of the distance.
const LARGEST_ERROR: f64 = 0.01;

/// A sphere with the camera near its surface.
struct Close {
    number: usize,
    radius: f64,
    height: f64,
    error: f64,
}

/// The worst of the spheres that are too near to the camera.
#[derive(Default)]
pub struct Surfaces {
    close: Worst<Close>,
}

impl Surfaces {
    pub fn see(&mut self, number: usize, body: &Body) {
        if let Some(close) = close(number, body) {
            self.close.note(close.error / close.height, close);
        }
    }

    pub fn diagnostics(self) -> Option<Diagnostic> {
        self.close.diagnostic(tell_close)
    }
}

/// The sphere, if the rounding of its distance from the camera is too large a share of the distance. The centre and the radius are
/// rounded, and the length between the camera and the centre by 2 u: together 4 u (r + h) for the height h.
fn close(number: usize, body: &Body) -> Option<Close> {
    let Hull::Ball { center, radius } = body.hull else { return None };
    let height = (center.length() - radius).abs();
    let error = 4.0 * U * (radius + height);
    (body.shape.is_hull() && error > LARGEST_ERROR * height).then_some(Close { number, radius, height, error })
}

fn tell_close(Close { number, radius, height, error }: Close) -> Diagnostic {
    let consequence = match error < height {
        true => format!("{} % of this distance", short(100.0 * error / height)),
        false => {
            "so that the image may be wrong: f32 does not tell on which side of the surface the camera is".to_string()
        }
    };
    let message = format!(
        "a sphere with a radius of {}, and the camera is {} from its surface: f32 rounds distances to it by up to {}, {consequence}: move \
         the camera farther from it than {}, or write a quad if the sphere looks flat",
        short(radius),
        short(height),
        short(error),
        short(4.0 * U / LARGEST_ERROR * radius)
    );
    Diagnostic::of(At::Primitive(number), "radius", message)
}
