//@ use data/hit
//@ use data/material
//@ use data/surface
// No material has a normal map.
fn mapped_normal(
    hit: Hit,
    surface: Surface,
    incoming: vec3<f32>,
    shading: vec3<f32>,
    front: bool,
    code: vec3<f32>,
) -> vec3<f32> {
    return shading;
}

fn keep_side(bsdf: Scatter, mapped: vec3<f32>, shading: vec3<f32>) -> Scatter {
    return bsdf;
}

fn response_on_side(value: vec3<f32>, direction: vec3<f32>, mapped: vec3<f32>, shading: vec3<f32>) -> vec3<f32> {
    return value;
}
