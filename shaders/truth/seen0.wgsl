//@ implements seen0 when truth
//@ use truth/word
//@ use choice/object0
//@ use choice/face0
//@ use choice/time0
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
    let at = words_of(select(ray.direction, ray.origin + (*path).t * ray.direction, has_hit(path)));
    if (*path).status == PATH_ENDED {
        return Seen();
    }
    return Seen(at.x, at.y, at.z, object0_of(path), face0_of(path), word_of(time0()));
}
