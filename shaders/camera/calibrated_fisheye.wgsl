//@ alternative projection when projection.calibrated_fisheye
//@ use camera/pixel
//@ use camera/radial
//@ use choice/camera_pose
// A calibrated fisheye lens, as OpenCV has it: the distance from the principal point is t + k1 t³ + k2 t⁵ + k3 t⁷ + k4 t⁹ of the angle t to the axis
// (Kannala, Brandt, "A Generic Camera Model and Calibration Method", IEEE TPAMI 28(8), 2006, equation 6). `film` has the principal point, in
// pixels from the image's middle, and 1 over the focal lengths. The camera's pixels are unit vectors.

fn film_direction(at: vec2<f32>) -> vec3<f32> {
    let aim = (at - settings.film.xy) * settings.film.zw;
    let r = length(aim);
    let angle = inverse_radial(r);
    let is_found = abs(radial_of(angle).x - r) <= 1e-5 * (1.0 + r);
    let on_circle = circle_point(angle * TURNS_OF_RADIAN);
    let sine = select(on_circle.y / r, 1.0, r == 0.0);
    let direction = on_circle.x * camera_forward() + sine * (aim.x * camera_pixel_x() + aim.y * camera_pixel_y());
    return select(vec3<f32>(0.0), direction, is_found);
}

fn film_point(direction: vec3<f32>, shift: vec3<f32>) -> vec2<f32> {
    let across = in_pixels(direction);
    let sine = length(across);
    let r = radial_of(angle_of(sine, dot(direction, camera_forward()))).x;
    return from_corner(select(r / sine, 1.0, sine == 0.0) * across / settings.film.zw + settings.film.xy);
}

// A pixel has the area r dr dp on the film where its solid angle is sin t dt dp.
fn density_of_camera_ray(direction: vec3<f32>, shift: vec3<f32>) -> f32 {
    let sine = length(in_pixels(direction));
    let angle = angle_of(sine, dot(direction, camera_forward()));
    let found = radial_of(angle);
    let area = select(found.x / sine, 1.0, sine == 0.0) * found.y;
    return select(0.0, area / abs(settings.film.z * settings.film.w), angle < settings.fold && area > 0.0);
}
