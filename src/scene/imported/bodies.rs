//! Lamps and media inside of other bodies, by boxes around both: there other renderers differ.

use super::{Body, Imported};
use crate::shape::Aabb;

fn holds(outer: &Aabb, inner: &Aabb) -> bool {
    outer.min.cmple(inner.min).all() && outer.max.cmpge(inner.max).all()
}

/// So many pairs are compared.
const MOST_PAIRS: usize = 100_000_000;

/// Tells what may be inside of something else, also the place of a camera that names no medium.
pub fn tell(renderer: &str, made: &mut Imported) {
    let bodies = std::mem::take(&mut made.bodies);
    let those = |fits: fn(&Body) -> bool| bodies.iter().filter(|body| fits(body)).collect::<Vec<&Body>>();
    let (glass, lamps, media) = (those(|body| body.is_glass), those(|body| body.emits), those(|body| body.has_medium));
    let mut tell = |inner: &[&Body], outer: &[&Body], message: String| {
        if let Some(first) = outer.first().filter(|_| inner.len().saturating_mul(outer.len()) > MOST_PAIRS) {
            return made.lose(&first.at, &first.title, "too many shapes to search for those inside of it");
        }
        let is_inside = |a: &&&Body| outer.iter().any(|b| !std::ptr::eq(**a, *b) && holds(&b.around, &a.around));
        inner.iter().filter(is_inside).for_each(|body| made.lose(&body.at, &body.title, &message));
    };
    let of_lamps =
        format!("it seems to be inside of glass, where {renderer} scales its light by the square of the index");
    tell(&lamps, &glass, of_lamps);
    let of_media = format!(
        "its medium seems to be inside of another: here their densities add, in {renderer} it takes the other's place"
    );
    tell(&media, &media, of_media);
    let seen = |at| media.iter().any(|body| holds(&body.around, &Aabb { min: at, max: at }));
    if let Some((place, title, _)) = made.outside.take().filter(|(.., at)| seen(*at)) {
        let message = format!(
            "it seems to be inside of a medium that it does not name, and which {renderer} therefore leaves out"
        );
        made.lose(&place, &title, &message);
    }
}
