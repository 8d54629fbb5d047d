//@ implements facets when anisotropy
// Microfacets that are rougher along the tangent (KHR_materials_anisotropy): alpha is mix(alpha, 1, strength^2) there. A material without an
// anisotropy has the functions of isotropic ones.

fn is_isotropic(hit: Interaction) -> bool {
    return hit.lobes.anisotropy == 0.0;
}

fn alphas_of(hit: Interaction, alpha: f32) -> vec2<f32> {
    return vec2<f32>(mix(alpha, 1.0, hit.lobes.anisotropy), alpha);
}

fn facet_basis(hit: Interaction) -> Basis {
    if is_isotropic(hit) {
        return basis_around(hit.normal);
    }
    return Basis(hit.tangent, cross(hit.normal, hit.tangent), hit.normal);
}

fn sample_ggx(hit: Interaction, cos_view: f32, alpha: f32, u: vec2<f32>) -> vec3<f32> {
    if is_isotropic(hit) {
        let basis = basis_around(hit.normal);
        let view = vec3<f32>(-in_basis(basis, hit.incoming).xy, cos_view);
        return from_basis(basis, sample_visible_normal(view, alpha, u));
    }
    let basis = facet_basis(hit);
    let view = vec3<f32>(-in_basis(basis, hit.incoming).xy, cos_view);
    return from_basis(basis, sample_anisotropic_normal(view, alphas_of(hit, alpha), u));
}

fn visible_ggx(along: vec3<f32>, hit: Interaction, cos_view: f32, alpha: f32) -> f32 {
    if is_isotropic(hit) {
        return visible_density(microfacet_density(along, hit.normal, alpha), cos_view, alpha);
    }
    let basis = facet_basis(hit);
    let alphas = alphas_of(hit, alpha);
    let view = vec3<f32>(in_basis(basis, hit.incoming).xy, cos_view);
    return 2.0 * anisotropic_density(in_basis(basis, along), alphas) / (cos_view + anisotropic_root(view, alphas));
}

fn ggx_shadowing(hit: Interaction, cos_view: f32, direction: vec3<f32>, cos_light: f32, alpha: f32) -> f32 {
    if is_isotropic(hit) {
        return smith_shadowing(cos_view, cos_light, alpha);
    }
    let basis = facet_basis(hit);
    let alphas = alphas_of(hit, alpha);
    let root_view = anisotropic_root(vec3<f32>(in_basis(basis, hit.incoming).xy, cos_view), alphas);
    let root_light = anisotropic_root(vec3<f32>(in_basis(basis, direction).xy, cos_light), alphas);
    return cos_light * (cos_view + root_view) / (cos_light * root_view + cos_view * root_light);
}

fn widest_alpha(hit: Interaction, alpha: f32) -> f32 {
    return mix(alpha, 1.0, hit.lobes.anisotropy);
}
