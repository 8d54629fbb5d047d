//@ implements camera_pose when moving_camera
//@ use bind/motions
//@ use bind/settings
//@ use choice/lens_place
//@ use motion/pose
// A camera that moves: both the point at which it is and the one at which it looks have keys. They are relative to the camera where the
// shutter opens, which is the origin of render space.

// Flags of the first row: the plane that is sharp is at the point at which the camera looks; the image is mirrored.
const FOLLOWS_FOCUS: u32 = 1u;
const IS_MIRRORED: u32 = 2u;

struct MovingCamera {
    origin: vec3<f32>,
    forward: vec3<f32>,
    right: vec3<f32>,
    upward: vec3<f32>,
    // The distance to the point at which it looks, if the plane that is sharp is there; else 0.
    distance: f32,
    // Whether it rests, as with all features linked. Then it is as the settings say, to the last bit.
    rests: bool,
}
var<private> camera_now: MovingCamera;

// Sets the camera to where it is at the time of the sample. The first row of its keys has the direction that is up, as a unit vector, and flags.
fn begin_camera() {
    let first = motions[0].x;
    let keys = motions[0].y;
    camera_now.rests = keys == 0u;
    if camera_now.rests {
        return;
    }
    let origin = vector_between(between_keys(first + 1u, keys, 1u));
    let view = vector_between(between_keys(first + 1u + keys, keys, 1u)) - origin;
    let distance = length(view);
    let forward = view / distance;
    let right = normalize(cross(forward, vector_of_row(motions[first])));
    let flags = motions[first].w;
    let to_right = select(right, -right, (flags & IS_MIRRORED) != 0u);
    camera_now = MovingCamera(origin, forward, to_right, cross(right, forward), select(0.0, distance, (flags & FOLLOWS_FOCUS) != 0u), false);
}

// A point given relative to the middle of the lens.
fn from_lens(point: vec3<f32>) -> vec3<f32> {
    return select(camera_now.origin + point, placed(point), camera_now.rests);
}

fn camera_forward() -> vec3<f32> {
    return select(camera_now.forward, settings.forward, camera_now.rests);
}

fn camera_pixel_x() -> vec3<f32> {
    return select(length(settings.pixel_x) * camera_now.right, settings.pixel_x, camera_now.rests);
}

fn camera_pixel_y() -> vec3<f32> {
    return select(-length(settings.pixel_y) * camera_now.upward, settings.pixel_y, camera_now.rests);
}

fn camera_lens_x() -> vec3<f32> {
    return select(length(settings.lens_x) * camera_now.right, settings.lens_x, camera_now.rests);
}

fn camera_lens_y() -> vec3<f32> {
    return select(length(settings.lens_y) * camera_now.upward, settings.lens_y, camera_now.rests);
}

fn camera_inverse_focus() -> f32 {
    return select(settings.inverse_focus, 1.0 / camera_now.distance, !camera_now.rests && camera_now.distance > 0.0);
}
