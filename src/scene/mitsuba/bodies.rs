//! What is inside of something else, by boxes around both: there Mitsuba differs.

use super::reader::Reader;
use crate::shape::Aabb;

fn holds(outer: &Aabb, inner: &Aabb) -> bool {
    outer.min.cmple(inner.min).all() && outer.max.cmpge(inner.max).all()
}

/// Tells what may be inside of something else.
pub fn tell(reader: &mut Reader) {
    let bodies = std::mem::take(&mut reader.bodies);
    let (glass, media): (Vec<_>, Vec<_>) =
        (bodies.iter().filter(|body| body.is_glass).collect(), bodies.iter().filter(|body| body.has_medium).collect());
    for lamp in bodies.iter().filter(|body| body.emits) {
        if glass.iter().any(|body| holds(&body.around, &lamp.around)) {
            reader.lose(
                lamp.node,
                "it seems to be inside of glass, where Mitsuba scales its light by the square of the index",
            );
        }
    }
    for (number, inner) in media.iter().enumerate() {
        let others = media.iter().enumerate().filter(|(other, _)| *other != number);
        if others.map(|(_, body)| body).any(|body| holds(&body.around, &inner.around)) {
            reader.lose(inner.node, "its medium seems to be inside of another: here their densities add, in Mitsuba it takes the other's place");
        }
    }
    let seen = |at| media.iter().any(|body| holds(&body.around, &Aabb { min: at, max: at }));
    if let Some((node, _)) = reader.outside.take().filter(|(_, at)| seen(*at)) {
        reader.lose(
            node,
            "it seems to be inside of a medium that it does not name, and which Mitsuba therefore leaves out",
        );
    }
}
