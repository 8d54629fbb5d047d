//@ use truth/word
//@ use choice/object_of_hit
//@ use choice/face_of_hit
//@ use choice/time_of_sample
// What the host needs to follow what the sample sees to another frame.
struct Seen {
    // The point of the hit in render space; without a hit, the direction of the ray.
    x: u32,
    y: u32,
    z: u32,
    // The number of the object, or 0, and of its face, or 0.
    object: u32,
    face: u32,
    // The time: 0 where the shutter opens, 1 where it closes.
    time: u32,
}

fn seen0_of(path: ptr<function, Path>) -> Seen {
    let ray = (*path).ray;
    let time = word_of(time_of_sample());
    if has_hit(path) {
        let point = words_of(ray.origin + (*path).t * ray.direction);
        return Seen(point.x, point.y, point.z, object_of_hit(path), face_of_hit(path), time);
    }
    if (*path).status != HIT_NOTHING {
        return Seen();
    }
    let direction = words_of(ray.direction);
    return Seen(direction.x, direction.y, direction.z, 0u, 0u, time);
}
