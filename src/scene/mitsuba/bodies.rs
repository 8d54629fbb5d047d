//! What is inside of something else, by boxes around both: there Mitsuba differs.

use super::reader::{Body, Reader};
use crate::shape::Aabb;

fn holds(outer: &Aabb, inner: &Aabb) -> bool {
    outer.min.cmple(inner.min).all() && outer.max.cmpge(inner.max).all()
}

/// So many pairs are compared.
const MOST_PAIRS: usize = 100_000_000;

/// Tells what may be inside of something else.
pub fn tell(reader: &mut Reader) {
    let bodies = std::mem::take(&mut reader.bodies);
    let those = |fits: fn(&Body) -> bool| bodies.iter().filter(|body| fits(body)).collect::<Vec<&Body>>();
    let (glass, lamps, media) = (those(|body| body.is_glass), those(|body| body.emits), those(|body| body.has_medium));
    let mut tell = |inner: &[&Body], outer: &[&Body], message: &str| {
        if let Some(first) = outer.first().filter(|_| inner.len().saturating_mul(outer.len()) > MOST_PAIRS) {
            return reader.lose(first.node, "too many shapes to search for those inside of it");
        }
        let is_inside = |a: &&&Body| outer.iter().any(|b| !std::ptr::eq(**a, *b) && holds(&b.around, &a.around));
        inner.iter().filter(is_inside).for_each(|body| reader.lose(body.node, message));
    };
    tell(&lamps, &glass, "it seems to be inside of glass, where Mitsuba scales its light by the square of the index");
    let of_media =
        "its medium seems to be inside of another: here their densities add, in Mitsuba it takes the other's place";
    tell(&media, &media, of_media);
    let seen = |at| media.iter().any(|body| holds(&body.around, &Aabb { min: at, max: at }));
    if let Some((node, _)) = reader.outside.take().filter(|(_, at)| seen(*at)) {
        reader.lose(
            node,
            "it seems to be inside of a medium that it does not name, and which Mitsuba therefore leaves out",
        );
    }
}
