//! Spheres whose own distance from the camera is lost beside their radius.

use super::{At, Body, Diagnostic, U, Worst, short};
use crate::shape::Hull;

/// The largest share of a sphere's distance from the camera by which that may be rounded.
const LARGEST_ERROR: f64 = 0.01;

/// A sphere with the camera near its surface.
struct Close {
    number: usize,
    radius: f64,
    height: f64,
    error: f64,
}

/// What is found of surfaces near the camera.
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

/// Whether the distance of a sphere from the camera is rounded by too large a share of it. The centre and the radius are rounded, and the length
/// between camera and centre by 2 u: 4 u (r + h) of the height h.
fn close(number: usize, body: &Body) -> Option<Close> {
    let Hull::Ball { center, radius } = body.hull else { return None };
    let height = (center.length() - radius).abs();
    let error = 4.0 * U * (radius + height);
    (body.shape.is_hull() && error > LARGEST_ERROR * height).then_some(Close { number, radius, height, error })
}

fn tell_close(Close { number, radius, height, error }: Close) -> Diagnostic {
    let consequence = match error < height {
        true => format!("{} % of that", short(100.0 * error / height)),
        false => "so that the picture may be wrong: f32 does not tell on which side of it the camera is".to_string(),
    };
    let message = format!(
        "a sphere with a radius of {}, and the camera is {} from its surface: f32 rounds distances to it by up to {}, {consequence}: move \
         the camera farther from it than {}, or write a quad where it looks flat",
        short(radius),
        short(height),
        short(error),
        short(4.0 * U / LARGEST_ERROR * radius)
    );
    Diagnostic::of(At::Primitive(number), "radius", message)
}
