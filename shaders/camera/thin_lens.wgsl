//@ use bind/settings
//@ use data/ray
//@ use lib/sampling
//@ use camera/film_plane
// Rays leave a point of the lens, uniform by area, for the point at the focus distance that the pinhole's ray would meet
// (Cook, Porter, Carpenter, "Distributed Ray Tracing", SIGGRAPH 1984, section 4.3).
fn camera_ray(column: u32, row: u32, u: vec4<f32>) -> Ray {
    let lens = sample_disk(u.zw);
    let origin = lens.x * settings.lens_x + lens.y * settings.lens_y;
    let direction = film_direction(column, row, u.xy) - settings.inverse_focus * origin;
    return Ray(origin, normalize(direction));
}
