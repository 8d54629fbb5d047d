//@ use light/sample
// Wrong on purpose: 1 - cos by subtraction, which has no digits for spheres far away.
fn textbook_height(from_point: vec3<f32>, sphere: Sphere) -> f32 {
    let sine = sphere.radius / length(sphere.center - from_point);
    return 1.0 - sqrt(max(1.0 - sine * sine, 0.0));
}

fn sphere_light_sample(from_point: vec3<f32>, sphere: Sphere, u: vec2<f32>) -> DirectionSample {
    let rise = textbook_height(from_point, sphere);
    let height = u.x * rise;
    let local = vec3<f32>(sqrt(height * (2.0 - height)) * sample_circle(u.y), 1.0 - height);
    let axis = normalize(sphere.center - from_point);
    return DirectionSample(from_basis(basis_around(axis), local), 1.0 / (2.0 * PI * rise));
}

fn sphere_light_pdf(from_point: vec3<f32>, direction: vec3<f32>, sphere: Sphere) -> f32 {
    return 1.0 / (2.0 * PI * textbook_height(from_point, sphere));
}
