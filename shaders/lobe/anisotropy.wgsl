//@ implements facets when anisotropy | beckmann
//@ use choice/distribution
// Microfacets that are rougher along the tangent (KHR_materials_anisotropy): alpha is mix(alpha, 1, strength^2) there; or whose slopes have another
// distribution. A material with neither has the functions of isotropic ones.

fn is_plain(hit: Interaction) -> bool {
    return hit.lobes.anisotropy == 0.0 && !is_beckmann(hit);
}

fn alphas_of(hit: Interaction, alpha: f32) -> vec2<f32> {
    return vec2<f32>(mix(alpha, 1.0, hit.lobes.anisotropy), alpha);
}

fn facet_basis(hit: Interaction) -> Basis {
    if hit.lobes.anisotropy == 0.0 {
        return basis_around(hit.normal);
    }
    return Basis(hit.tangent, cross(hit.normal, hit.tangent), hit.normal);
}

fn sample_facet(hit: Interaction, cos_view: f32, alpha: f32, u: vec2<f32>) -> vec3<f32> {
    let basis = facet_basis(hit);
    let view = vec3<f32>(-in_basis(basis, hit.incoming).xy, cos_view);
    if is_plain(hit) {
        return from_basis(basis, sample_visible_normal(view, alpha, u));
    }
    return from_basis(basis, sample_normal(hit, view, alphas_of(hit, alpha), u));
}

fn visible_facets(along: vec3<f32>, hit: Interaction, cos_view: f32, alpha: f32) -> f32 {
    if is_plain(hit) {
        return visible_density(microfacet_density(along, hit.normal, alpha), cos_view, alpha);
    }
    let basis = facet_basis(hit);
    let alphas = alphas_of(hit, alpha);
    let view = vec3<f32>(in_basis(basis, hit.incoming).xy, cos_view);
    return 2.0 * facet_density(hit, in_basis(basis, along), alphas) / (cos_view + masking_root(hit, view, alphas));
}

fn facet_shadowing(hit: Interaction, cos_view: f32, direction: vec3<f32>, cos_light: f32, alpha: f32) -> f32 {
    if is_plain(hit) {
        return smith_shadowing(cos_view, cos_light, alpha);
    }
    let basis = facet_basis(hit);
    let alphas = alphas_of(hit, alpha);
    let root_view = masking_root(hit, vec3<f32>(in_basis(basis, hit.incoming).xy, cos_view), alphas);
    let root_light = masking_root(hit, vec3<f32>(in_basis(basis, direction).xy, cos_light), alphas);
    return cos_light * (cos_view + root_view) / (cos_light * root_view + cos_view * root_light);
}

fn widest_alpha(hit: Interaction, alpha: f32) -> f32 {
    return mix(alpha, 1.0, hit.lobes.anisotropy);
}
