//@ implements distribution when beckmann
// The distribution of Beckmann, for the materials that have it.
fn is_beckmann(hit: Interaction) -> bool {
    return hit.beckmann != 0.0;
}

fn facet_density(hit: Interaction, along: vec3<f32>, alphas: vec2<f32>) -> f32 {
    if is_beckmann(hit) {
        return beckmann_density(along, alphas);
    }
    return anisotropic_density(along, alphas);
}

// The cosine times 1 + 2 Lambda.
fn masking_root(hit: Interaction, direction: vec3<f32>, alphas: vec2<f32>) -> f32 {
    if is_beckmann(hit) {
        return beckmann_root(direction, alphas);
    }
    return anisotropic_root(direction, alphas);
}

fn sample_normal(hit: Interaction, view: vec3<f32>, alphas: vec2<f32>, u: vec2<f32>) -> vec3<f32> {
    if is_beckmann(hit) {
        return sample_beckmann_normal(view, alphas, u);
    }
    return sample_anisotropic_normal(view, alphas, u);
}

//@ without
// All microfacets have that of GGX.
fn is_beckmann(hit: Interaction) -> bool {
    return false;
}

fn facet_density(hit: Interaction, along: vec3<f32>, alphas: vec2<f32>) -> f32 {
    return anisotropic_density(along, alphas);
}

fn masking_root(hit: Interaction, direction: vec3<f32>, alphas: vec2<f32>) -> f32 {
    return anisotropic_root(direction, alphas);
}

fn sample_normal(hit: Interaction, view: vec3<f32>, alphas: vec2<f32>, u: vec2<f32>) -> vec3<f32> {
    return sample_anisotropic_normal(view, alphas, u);
}
