//@ alternative projection when projection.fisheye | projection.calibrated_fisheye
//@ use camera/pixel
//@ use choice/camera_pose
//@ use choice/round_lens
// A lens that is the same around its axis: an angle t to the axis is at a distance r(t) from it. `film` has the point of the axis, in pixels from
// the image's middle, and what r changes from one pixel to the next. The camera's pixels are unit vectors.

fn film_direction(at: vec2<f32>) -> vec3<f32> {
    let aim = (at - settings.film.xy) * settings.film.zw;
    let r = length(aim);
    let angle = lens_angle(r);
    let on_circle = circle_point(angle * TURNS_OF_RADIAN);
    let sine = select(on_circle.y / r, 1.0, r == 0.0);
    let direction = on_circle.x * camera_forward() + sine * (aim.x * camera_pixel_x() + aim.y * camera_pixel_y());
    return select(vec3<f32>(0.0), direction, angle >= 0.0);
}

fn film_point(direction: vec3<f32>, shift: vec3<f32>) -> vec2<f32> {
    let across = in_pixels(direction);
    let sine = length(across);
    let r = lens_distance(angle_of(sine, dot(direction, camera_forward()))).x;
    return from_corner(select(r / sine, 1.0, sine == 0.0) * across / settings.film.zw + settings.film.xy);
}

// A pixel has the area r dr dp on the film where its solid angle is sin t dt dp.
fn density_of_camera_ray(direction: vec3<f32>, shift: vec3<f32>) -> f32 {
    let sine = length(in_pixels(direction));
    let found = lens_distance(angle_of(sine, dot(direction, camera_forward())));
    let area = select(found.x / sine, 1.0, sine == 0.0) * found.y;
    return max(area, 0.0) / abs(settings.film.z * settings.film.w);
}
