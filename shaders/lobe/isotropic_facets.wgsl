//@ implements facets when !(anisotropy | beckmann)
// Microfacets of GGX that are as rough in all directions.

// A microfacet normal, from those that are visible.
fn sample_facet(hit: Interaction, cos_view: f32, alpha: f32, u: vec2<f32>) -> vec3<f32> {
    let basis = basis_around(hit.normal);
    let view = vec3<f32>(-in_basis(basis, hit.incoming).xy, cos_view);
    return from_basis(basis, sample_visible_normal(view, alpha, u));
}

// The density of the visible microfacet normals at the direction of `along` over their cosine with the view.
fn visible_facets(along: vec3<f32>, hit: Interaction, cos_view: f32, alpha: f32) -> f32 {
    return visible_density(microfacet_density(along, hit.normal, alpha), cos_view, alpha);
}

// The share of the visible microfacets that light from a direction reaches too. `cos_light` is not negative.
fn facet_shadowing(hit: Interaction, cos_view: f32, direction: vec3<f32>, cos_light: f32, alpha: f32) -> f32 {
    return smith_shadowing(cos_view, cos_light, alpha);
}

// The alpha of the widest section of the lobe.
fn widest_alpha(hit: Interaction, alpha: f32) -> f32 {
    return alpha;
}
