//! geometry/quad: which rays miss, and shared edges. What quads do at the extremes is in tests/extremes.

use glam::DVec3;
use gpu_rt::data::Quad;

use crate::common::kernel::Kernel;
use crate::common::quads::{assorted, quad_text, rays_at};
use crate::common::scenes::flat;
use crate::common::stats::Random;
use crate::common::trace::{In, NO_HIT, planted_tracer, trace, tracer};
use crate::common::vectors::{decades, exact, unit};

#[test]
fn quads_behind_the_ray_and_along_it_are_missed() {
    let mut random = Random(12);
    let quads = assorted(&mut random, 500, 6.0, (-2.0, 3.0));
    let mut rays = rays_at(&mut random, &quads, 5000, (-4.0, 0.0), (-1.0, 3.0));
    rays.iter_mut().for_each(|ray| ray.direction = ray.direction.map(|x| -x));
    let kernel = tracer("quad", &[]);
    assert!(trace(&kernel, &quads, &rays).iter().all(|out| out.t == NO_HIT));

    // Parallel to the plane: beside it the quotient is an infinity, within it 0/0.
    let square = Quad {
        normal: [0.0, 0.0, 1.0],
        u: [1.0, 0.0, 0.0],
        a_axis: [1.0, 0.0, 0.0],
        v: [0.0, 1.0, 0.0],
        b_axis: [0.0, 1.0, 0.0],
        ..Quad::default()
    };
    let mut parallel = Vec::new();
    for height in [0.0, -0.0, 1e-40, 1e-20, 0.5] {
        for z in [0.0, -0.0] {
            for (x, y) in [(1.0, 0.0), (0.0, 1.0), (-0.6, 0.8)] {
                let origin = [0.5, 0.5, height];
                parallel.push(In { origin, direction: [x, y, z], ..In::default() });
            }
        }
    }
    assert!(trace(&kernel, &[square], &parallel).iter().all(|out| out.t == NO_HIT));
}

/// Folds of two quads along a shared edge, 1 to 10 times as long as they are wide and up to 100 lengths from the origin,
/// and rays at that edge from up to 100 lengths away.
fn folds(random: &mut Random, general: bool) -> (Vec<Quad>, Vec<In>) {
    let mut texts = Vec::new();
    for i in 0..2000 {
        let (along, u, v) = if general {
            let along = unit(random);
            let u = along.cross(unit(random)).normalize();
            let v = if i % 2 == 0 { along.cross(unit(random)).normalize() } else { -u };
            (along, u, v)
        } else {
            (DVec3::Y, DVec3::X, if i % 2 == 0 { DVec3::NEG_X } else { DVec3::NEG_Z })
        };
        let size = decades(random, -4.0, 5.0);
        let corner = decades(random, -1.0, 2.0) * size * unit(random);
        let (along, u, v) =
            (along * size, u * size * decades(random, -1.0, 0.0), v * size * decades(random, -1.0, 0.0));
        // Each names the edge by another corner, or in the other sense.
        texts.push(quad_text(corner, along, u));
        texts.push(match i % 4 {
            0 => quad_text(corner, v, along),
            1 => quad_text(corner + along, -along, v),
            2 => quad_text(corner + v, -v, along),
            _ => quad_text(corner + v + along, -along, -v),
        });
    }
    let quads = flat(&texts).shapes.quads;
    let mut rays = Vec::new();
    for i in 0..100_000 {
        let left = 2 * (i % 2000);
        let quad = &quads[left];
        let edge = exact(quad.u);
        let target = exact(quad.corner) + random.uniform() * edge;
        let origin = target + decades(random, -1.0, 2.0) * edge.length() * unit(random);
        let direction = (target - origin).normalize();
        // The quads lie on both sides of the edge as the ray sees it, else it may pass the fold by; and neither is seen at
        // less than 1e-4 rad.
        let side = direction.cross(edge);
        let across = [quad, &quads[left + 1]].map(|quad| {
            let middle = exact(quad.corner) + 0.5 * (exact(quad.u) + exact(quad.v));
            (middle - target).dot(side)
        });
        let facing = [quad, &quads[left + 1]].map(|quad| exact(quad.normal).dot(direction).abs());
        if across[0] * across[1] < 0.0 && facing[0].min(facing[1]) > 1e-4 {
            rays.push(In::new(left, origin, direction));
            rays.push(In::new(left + 1, origin, direction));
        }
    }
    (quads, rays)
}

/// Folds of which a ray at their edge missed both quads.
fn gaps(kernel: &Kernel, quads: &[Quad], rays: &[In]) -> usize {
    let hits = trace(kernel, quads, rays);
    hits.chunks_exact(2).filter(|pair| pair[0].t == NO_HIT && pair[1].t == NO_HIT).count()
}

#[test]
fn no_ray_passes_between_quads_that_share_an_edge() {
    for general in [true, false] {
        let (quads, rays) = folds(&mut Random(13), general);
        assert!(rays.len() > 100_000);
        let missed = gaps(&tracer("quad", &[]), &quads, &rays);
        assert_eq!(missed, 0, "of {}", rays.len() / 2);
        // Edges tested as they are, without an allowance for rounding.
        let sharp = ("geometry/quad", "quad_slack(ray, t, quad)", "vec2<f32>(0.0)");
        assert!(gaps(&planted_tracer("quad", sharp), &quads, &rays) > 1000);
    }
}
