// Wrong on purpose: the cosine as in textbooks, which cancels for small g, and where light goes nearly straight on.
fn henyey_greenstein(g: f32, one_minus_g: f32, u: f32) -> vec2<f32> {
    let root = (1.0 - g * g) / (1.0 - g + 2.0 * g * select(u, 1.0 - u, g < 0.0));
    let cos = select((1.0 + g * g - root * root) / (2.0 * g), 2.0 * u - 1.0, g == 0.0);
    return vec2<f32>(1.0 - cos, 1.0 + cos);
}

fn sample_phase(incoming: vec3<f32>, g: f32, one_minus_g: f32, u: vec2<f32>) -> vec3<f32> {
    let from_one = henyey_greenstein(g, one_minus_g, u.x);
    let sin = sqrt(max(from_one.x * from_one.y, 0.0));
    return normalize(from_basis(basis_around(incoming), vec3<f32>(sin * sample_circle(u.y), 1.0 - from_one.x)));
}
