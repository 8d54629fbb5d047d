//@ alternative projection when projection.equirectangular
//@ use camera/pixel
//@ use choice/camera_pose
// Longitude along x, to the right of the camera's axis, and latitude along y: both are linear on the film. `film` has them in turns at the image's
// middle, and how they change from one pixel to the next. The camera's pixels are unit vectors.

fn film_direction(at: vec2<f32>) -> vec3<f32> {
    let turns = settings.film.xy + at * settings.film.zw;
    let longitude = circle_point(turns.x);
    let latitude = circle_point(turns.y);
    let level = longitude.x * camera_forward() + longitude.y * camera_pixel_x();
    // Beyond a pole, where only a filter reaches, the film is mirrored (camera/seam).
    return abs(latitude.x) * level - latitude.y * camera_pixel_y();
}

// Of all longitudes that are the same direction, the one that is nearest to the image's middle.
fn film_point(direction: vec3<f32>, shift: vec3<f32>) -> vec2<f32> {
    let right = dot(direction, camera_pixel_x());
    let forward = dot(direction, camera_forward());
    let up = -dot(direction, camera_pixel_y());
    let longitude = TURNS_OF_RADIAN * sign_of(right) * angle_of(abs(right), forward);
    let latitude = TURNS_OF_RADIAN * sign_of(up) * angle_of(abs(up), length(vec2<f32>(right, forward)));
    let turns = vec2<f32>(longitude, latitude) - settings.film.xy;
    return from_corner(vec2<f32>(turns.x - round(turns.x), turns.y) / settings.film.zw);
}

// The solid angle of a pixel is that of its latitude.
fn density_of_camera_ray(direction: vec3<f32>, shift: vec3<f32>) -> f32 {
    let level = length(vec2<f32>(dot(direction, camera_pixel_x()), dot(direction, camera_forward())));
    let pixel = abs(settings.film.z * settings.film.w) / (TURNS_OF_RADIAN * TURNS_OF_RADIAN);
    return 1.0 / (max(level, LEAST_DENSITY) * pixel);
}

fn sign_of(x: f32) -> f32 {
    return select(1.0, -1.0, x < 0.0);
}
