//@ use truth/word
//@ use choice/camera_pose
//@ use choice/surface0
//@ use choice/time_of_sample
//@ use step/start
// What a camera ray says of the sample, and where it hits: 0 without a hit. Points are in render space.
fn depth0_of(path: ptr<function, Path>) -> u32 {
    let depth = (*path).t * dot((*path).ray.direction, camera_forward());
    return select(0u, words_of(vec3<f32>(depth)).x, has_hit(path));
}

fn distance0_of(path: ptr<function, Path>) -> u32 {
    return select(0u, words_of(vec3<f32>((*path).t)).x, has_hit(path));
}

fn position0_of(path: ptr<function, Path>) -> vec3<u32> {
    let point = (*path).ray.origin + (*path).t * (*path).ray.direction;
    return select(vec3<u32>(0u), words_of(point), has_hit(path));
}

// From the pixel's left upper corner, in pixels: x to the right, y down.
fn offset0_of(path: ptr<function, Path>) -> vec2<u32> {
    return words_of(pixel_offset(path).xyz).xy;
}

// What the host needs to follow what the sample sees to another frame.
struct Seen {
    // The point of the hit; without a hit, the direction of the ray.
    at: vec3<u32>,
    // The number of the object, or 0, and of its face, or 0.
    object: u32,
    face: u32,
    // The time: 0 where the shutter opens, 1 where it closes.
    time: u32,
}

fn seen0_of(path: ptr<function, Path>) -> Seen {
    if !has_hit(path) && (*path).status != HIT_NOTHING {
        return Seen();
    }
    let direction = words_of((*path).ray.direction);
    let at = select(direction, position0_of(path), has_hit(path));
    return Seen(at, object0_of(path), face0_of(path), words_of(vec3<f32>(time_of_sample())).x);
}
