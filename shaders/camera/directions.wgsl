//@ implements camera_direction when projection
// Points of the film that no direction belongs to: their projection says the zero vector. Their samples are black.

// The direction through a point of the film, from a point of the lens that shifts it.
fn camera_direction(through_film: vec3<f32>, shift: vec3<f32>) -> vec3<f32> {
    return select(normalize(through_film - shift), vec3<f32>(0.0), all(through_film == vec3<f32>(0.0)));
}

fn has_direction(ray: Ray) -> bool {
    return any(ray.direction != vec3<f32>(0.0));
}

//@ without
// Each point of the film has a direction.
fn camera_direction(through_film: vec3<f32>, shift: vec3<f32>) -> vec3<f32> {
    return normalize(through_film - shift);
}

fn has_direction(ray: Ray) -> bool {
    return true;
}
