//@ use bind/settings
//@ use data/ray
//@ use camera/film_plane
// All rays start at one point, the origin of render space.
fn camera_ray(column: u32, row: u32, u: vec4<f32>) -> Ray {
    return Ray(vec3<f32>(0.0), normalize(film_direction(column, row, u.xy)));
}
