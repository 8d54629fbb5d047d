//@ implements crossings when crossed_body
//@ each crossed_body
//@ use medium/${name}
//@ use bind/${name}s
//@ use choice/moved_${name}
//@ end
// Convex bodies whose surface lets light pass straight on: a pane, such as a soap bubble, or one with an alpha. A ray that passes the near side
// meets the far side from inside.

// The distances at which the ray enters such a body and leaves it; 0 twice for other primitives.
fn interval_of_body(code: u32, pose: Pose, ray: Ray) -> vec2<f32> {
    let index = primitive_index(code);
    switch primitive_kind(code) {
        //@ each crossed_body
        case ${number}u: {
            return ${name}_interval(ray, moved_${name}(${name}s[index], pose));
        }
        //@ end
        default: {
            return vec2<f32>(0.0);
        }
    }
}

// Returns the hit with its side of the body.
fn with_side(hit: Hit, pose: Pose, ray: Ray) -> Hit {
    let inside = interval_of_body(hit.code, pose, ray);
    let is_far = inside.x > 0.0 && inside.x < inside.y && hit.t - inside.x > inside.y - hit.t;
    var sided = hit;
    sided.instance = select(hit.instance, FAR_SIDE, is_far);
    return sided;
}

// To the far side, the ray begins in the middle of the body: shapes take a ray from outside to hit the near side.
fn ray_to_hit(hit: Hit, pose: Pose, ray: Ray) -> RayToHit {
    if hit.instance != FAR_SIDE {
        return RayToHit(ray, hit.t);
    }
    let inside = interval_of_body(hit.code, pose, ray);
    let middle = 0.5 * (inside.x + inside.y);
    return RayToHit(Ray(ray.origin + middle * ray.direction, ray.direction), hit.t - middle);
}

//@ without
// No convex body is passed: a ray hits the first side that it meets.
fn interval_of_body(code: u32, pose: Pose, ray: Ray) -> vec2<f32> {
    return vec2<f32>(0.0);
}

fn with_side(hit: Hit, pose: Pose, ray: Ray) -> Hit {
    return hit;
}

fn ray_to_hit(hit: Hit, pose: Pose, ray: Ray) -> RayToHit {
    return RayToHit(ray, hit.t);
}
