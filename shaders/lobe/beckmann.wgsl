//@ implements distribution when beckmann
//@ use choice/facets
// The distribution of Beckmann, for the materials that have it.

// A microfacet normal, from those that are visible.
fn sample_facet(hit: Interaction, cos_view: f32, alpha: f32, u: vec2<f32>) -> vec3<f32> {
    if hit.beckmann == 0.0 {
        return sample_ggx(hit, cos_view, alpha, u);
    }
    let basis = facet_basis(hit);
    let view = vec3<f32>(-in_basis(basis, hit.incoming).xy, cos_view);
    return from_basis(basis, sample_beckmann_normal(view, alphas_of(hit, alpha), u));
}

// The density of the visible microfacet normals at the direction of `along` over their cosine with the view.
fn visible_facets(along: vec3<f32>, hit: Interaction, cos_view: f32, alpha: f32) -> f32 {
    if hit.beckmann == 0.0 {
        return visible_ggx(along, hit, cos_view, alpha);
    }
    let basis = facet_basis(hit);
    let alphas = alphas_of(hit, alpha);
    let view = vec3<f32>(in_basis(basis, hit.incoming).xy, cos_view);
    return 2.0 * beckmann_density(in_basis(basis, along), alphas) / (cos_view + beckmann_root(view, alphas));
}

// The share of the visible microfacets that light from a direction reaches too. `cos_light` is not negative.
fn facet_shadowing(hit: Interaction, cos_view: f32, direction: vec3<f32>, cos_light: f32, alpha: f32) -> f32 {
    if hit.beckmann == 0.0 {
        return ggx_shadowing(hit, cos_view, direction, cos_light, alpha);
    }
    let basis = facet_basis(hit);
    let alphas = alphas_of(hit, alpha);
    let root_view = beckmann_root(vec3<f32>(in_basis(basis, hit.incoming).xy, cos_view), alphas);
    let root_light = beckmann_root(vec3<f32>(in_basis(basis, direction).xy, cos_light), alphas);
    return cos_light * (cos_view + root_view) / (cos_light * root_view + cos_view * root_light);
}

//@ without
//@ use choice/facets
// All microfacets have that of GGX.
fn sample_facet(hit: Interaction, cos_view: f32, alpha: f32, u: vec2<f32>) -> vec3<f32> {
    return sample_ggx(hit, cos_view, alpha, u);
}

fn visible_facets(along: vec3<f32>, hit: Interaction, cos_view: f32, alpha: f32) -> f32 {
    return visible_ggx(along, hit, cos_view, alpha);
}

fn facet_shadowing(hit: Interaction, cos_view: f32, direction: vec3<f32>, cos_light: f32, alpha: f32) -> f32 {
    return ggx_shadowing(hit, cos_view, direction, cos_light, alpha);
}
