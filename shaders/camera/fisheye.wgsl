//@ alternative projection when projection.fisheye
//@ use camera/pixel
//@ use choice/camera_pose
// Fisheye lenses: the distance r from the image's middle is a function of the angle t to the axis. Equidistant: t. Equisolid: 2 sin(t/2).
// Stereographic: 2 tan(t/2). Orthographic: sin t. `film.z` is what r changes from one pixel to the next. The camera's pixels are unit vectors.
const MODEL: u32 = ${fisheye}u;
const EQUIDISTANT: u32 = 0u;
const EQUISOLID: u32 = 1u;
const STEREOGRAPHIC: u32 = 2u;

fn film_direction(at: vec2<f32>) -> vec3<f32> {
    let p = at * settings.film.zw;
    let r = length(p);
    // The cosine of the angle, and its sine over r.
    var cosine = 0.0;
    var sine = 1.0;
    var is_seen = true;
    if MODEL == EQUIDISTANT {
        let on_circle = circle_point(r * TURNS_OF_RADIAN);
        cosine = on_circle.x;
        sine = select(on_circle.y / r, 1.0, r == 0.0);
        is_seen = r <= 3.14159265;
    } else if MODEL == EQUISOLID {
        cosine = 1.0 - 0.5 * r * r;
        sine = sqrt(max(1.0 - 0.25 * r * r, 0.0));
        is_seen = r <= 2.0;
    } else if MODEL == STEREOGRAPHIC {
        let square = 0.25 * r * r;
        cosine = (1.0 - square) / (1.0 + square);
        sine = 1.0 / (1.0 + square);
    } else {
        cosine = sqrt(max(1.0 - r * r, 0.0));
        is_seen = r <= 1.0;
    }
    let direction = cosine * camera_forward() + sine * (p.x * camera_pixel_x() + p.y * camera_pixel_y());
    return select(vec3<f32>(0.0), direction, is_seen);
}

// 1 + cos t without cancellation.
fn rise_of(sine: f32, cosine: f32) -> f32 {
    return select(1.0 + cosine, sine * sine / (1.0 - cosine), cosine < 0.0);
}

// A unit direction: its components across the axis, and along it.
fn film_point(direction: vec3<f32>, shift: vec3<f32>) -> vec2<f32> {
    let across = in_pixels(direction);
    let along = dot(direction, camera_forward());
    let sine = length(across);
    let rise = rise_of(sine, along);
    // r over the sine.
    var scale = 1.0;
    if MODEL == EQUIDISTANT {
        scale = select(angle_of(sine, along) / sine, 1.0, sine == 0.0);
    } else if MODEL == EQUISOLID {
        scale = sqrt(2.0 / rise);
    } else if MODEL == STEREOGRAPHIC {
        scale = 2.0 / rise;
    }
    return from_corner(scale * across / settings.film.zw);
}

// A pixel has the area r dr dp on the film where its solid angle is sin t dt dp.
fn density_of_camera_ray(direction: vec3<f32>, shift: vec3<f32>) -> f32 {
    let along = dot(direction, camera_forward());
    let sine = length(in_pixels(direction));
    var area = 1.0;
    if MODEL == EQUIDISTANT {
        area = select(angle_of(sine, along) / sine, 1.0, sine == 0.0);
    } else if MODEL == STEREOGRAPHIC {
        let rise = rise_of(sine, along);
        area = 4.0 / (rise * rise);
    } else if MODEL != EQUISOLID {
        area = max(along, 0.0);
    }
    return area / abs(settings.film.z * settings.film.w);
}
