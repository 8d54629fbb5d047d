//@ use bind/settings
//@ use camera/pixel
//@ use camera/perspective
// Wrong on purpose: in the right half of the image a quarter of the rays have a direction of length 2, and an eighth one of
// length 4, which background_broken knows them by. Of eight Sobol points of a run these are two and one.
fn camera_ray(column: u32, row: u32, u: vec4<f32>) -> Ray {
    let direction = normalize(film_direction(from_middle(column, row, u.xy)));
    let size = select(select(1.0, 4.0, u.x >= 0.875), 2.0, u.x < 0.25);
    return Ray(vec3<f32>(0.0), direction * select(1.0, size, 2u * column >= settings.image_width));
}
