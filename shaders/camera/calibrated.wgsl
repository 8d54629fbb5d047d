//@ alternative projection when projection.calibrated
//@ use camera/pixel
//@ use camera/radial
//@ use choice/camera_pose
//@ relies on loops
// A calibrated camera, as OpenCV has it: a plane at distance 1 whose points a lens distorts (Brown, "Decentering Distortion of Lenses", 1966). `film`
// has the principal point, in pixels from the image's middle, and 1 over the focal lengths. The camera's pixels are unit vectors.

// A point of the film, and the derivatives of its x and of its y.
struct Distorted {
    point: vec2<f32>,
    dx: vec2<f32>,
    dy: vec2<f32>,
}

fn distorted(p: vec2<f32>) -> Distorted {
    let k = settings.distortion;
    let t = settings.tangential;
    let s = dot(p, p);
    let radial = 1.0 + s * (k.x + s * (k.y + s * k.z));
    let slope = k.x + s * (2.0 * k.y + s * 3.0 * k.z);
    let point = radial * p + 2.0 * p.x * p.y * t + vec2<f32>(t.y * (s + 2.0 * p.x * p.x), t.x * (s + 2.0 * p.y * p.y));
    let mixed = 2.0 * (p.x * p.y * slope + t.x * p.x + t.y * p.y);
    let dx = radial + 2.0 * (p.x * p.x * slope + t.x * p.y + 3.0 * t.y * p.x);
    let dy = radial + 2.0 * (p.y * p.y * slope + 3.0 * t.x * p.y + t.y * p.x);
    return Distorted(point, vec2<f32>(dx, mixed), vec2<f32>(mixed, dy));
}

fn determinant_of(found: Distorted) -> f32 {
    return found.dx.x * found.dy.y - found.dx.y * found.dy.x;
}

fn is_before_fold(p: vec2<f32>, found: Distorted) -> bool {
    return length(p) <= settings.fold && determinant_of(found) > 0.0;
}

// From the radial distortion's inverse, the tangential one is a few steps of Newton's away.
const MOST_STEPS_BEYOND_RADIAL: u32 = 8u;

fn film_direction(at: vec2<f32>) -> vec3<f32> {
    let aim = (at - settings.film.xy) * settings.film.zw;
    let r = length(aim);
    var p = select(inverse_radial(r) / r, 1.0, r == 0.0) * aim;
    var found = distorted(p);
    for (var i = 0u; i < MOST_STEPS_BEYOND_RADIAL; i++) {
        let rest = aim - found.point;
        let step = vec2<f32>(found.dy.y * rest.x - found.dx.y * rest.y, found.dx.x * rest.y - found.dy.x * rest.x) / determinant_of(found);
        p += step;
        found = distorted(p);
        if !(dot(step, step) > 1e-14 * dot(p, p)) {
            break;
        }
    }
    let rest = aim - found.point;
    let is_found = dot(rest, rest) <= 1e-10 * (1.0 + dot(aim, aim)) && is_before_fold(p, found);
    return select(vec3<f32>(0.0), camera_forward() + (p.x * camera_pixel_x() + p.y * camera_pixel_y()), is_found);
}

fn point_at_distance_1(direction: vec3<f32>, shift: vec3<f32>) -> vec2<f32> {
    return in_pixels(direction / dot(direction, camera_forward()) + shift);
}

fn film_point(direction: vec3<f32>, shift: vec3<f32>) -> vec2<f32> {
    return from_corner(distorted(point_at_distance_1(direction, shift)).point / settings.film.zw + settings.film.xy);
}

fn density_of_camera_ray(direction: vec3<f32>, shift: vec3<f32>) -> f32 {
    let cosine = dot(direction, camera_forward());
    let p = point_at_distance_1(direction, shift);
    let found = distorted(p);
    let pixel = abs(settings.film.z * settings.film.w);
    let is_seen = cosine > 0.0 && is_before_fold(p, found);
    return select(0.0, determinant_of(found) / (cosine * cosine * cosine * pixel), is_seen);
}
