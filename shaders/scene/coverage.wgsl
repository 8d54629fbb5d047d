//@ use bind/extensions
//@ use bind/materials
//@ use scene/extensions
//@ use scene/surface_random
//@ use scene/surfaces
//@ use choice/vertex_alpha
//@ use choice/walker
// Cut-out and transparent surfaces. The coverage of a surface is the share of light that it stops; the rest passes straight on. So a ray
// passes such a surface with the probability 1 - coverage.

// The share of light that a surface stops at a hit.
fn coverage_at(hit: Hit, surface: Surface) -> f32 {
    let number = extensions[surface.material].alpha;
    if number == NO_EXTENSION {
        return 1.0;
    }
    let alpha = times_vertex_alpha(extension_colour(number, hit, surface).x, hit, surface);
    // The least alpha of a cut-out surface; negative for a transparent one.
    let cutoff = materials[number].${alpha.cutoff};
    return select(alpha, select(0.0, 1.0, alpha >= cutoff), cutoff >= 0.0);
}

// Whether a ray is stopped at a hit. `decision` is that of scene/surface_random.
fn is_stopped(hit: Hit, ray: Ray, decision: u32) -> bool {
    if extensions[material_index(hit)].alpha == NO_EXTENSION {
        return true;
    }
    let coverage = coverage_at(hit, surface_at(hit, ray));
    if coverage <= 0.0 || coverage >= 1.0 {
        return coverage > 0.0;
    }
    return random_of_surface(walker.pixel, walker.sample, walker.dimension, hit, decision) < coverage;
}
