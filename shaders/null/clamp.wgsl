// Without a clamp, no contribution is limited.
fn limited_indirect(contribution: vec3<f32>, depth: u32) -> vec3<f32> {
    return contribution;
}

fn weight_of_light(weight: vec3<f32>, depth: u32) -> vec3<f32> {
    return weight;
}

fn limited_light(contribution: vec3<f32>) -> vec3<f32> {
    return contribution;
}
