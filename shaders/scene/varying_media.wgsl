//@ implements collision when varying
//@ use bind/fields
//@ use bind/media
//@ use medium/free_flight
//@ use medium/interval
//@ use scene/at_run_time
//@ use scene/field
//@ use choice/pose_of_boundary
//@ use choice/moved_medium
//@ each convex_boundary
//@ use medium/${name}
//@ use bind/${name}s
//@ use choice/moved_${name}
//@ end
//@ use choice/medium_in_mesh
//@ each varying
//@ use medium/${name}
//@ end
// Media whose density varies, among those where it is constant. They scatter a ray, or let it pass, in one part of it inside of the boundary
// after the other: events of a Poisson process in one do not depend on those in another.

// The distance at which the medium of this index scatters a ray, if that is nearer than `limit`; NO_HIT otherwise, or WALK_CUT if the walk took
// too many steps. `words` are random.
fn collision(number: u32, ray: Ray, words: vec4<u32>, limit: f32, steps: ptr<function, u32>) -> f32 {
    let medium = media[at_run_time(number)];
    let field = fields[at_run_time(number)];
    let here = ray_in_field(medium, field, ray);
    var own = words;
    var last = AT_ORIGIN;
    var inside = next_interval(medium, ray, &last, limit, steps);
    while is_interval(inside) {
        let t = event_within(medium, field, here, inside, &own, steps);
        if t != NO_HIT {
            return t;
        }
        own = pcg4d(own);
        inside = next_interval(medium, ray, &last, limit, steps);
    }
    return select(NO_HIT, WALK_CUT, inside.x < 0.0);
}

// The ray in the space of a field (data/scalar_field). Distances along it are those in render space.
fn ray_in_field(medium: Medium, field: ScalarField, ray: Ray) -> Ray {
    let offset = vec4<f32>(offset_at_rest(medium, ray.origin), 1.0);
    let direction = vec4<f32>(direction_at_rest(medium, ray.direction), 0.0);
    return Ray(position_in_field(field, offset), position_in_field(field, direction));
}

// The next part of the ray inside of the medium's boundary, up to `limit`, as interval_in_mesh has it. `last` begins as AT_ORIGIN.
fn next_interval(medium: Medium, ray: Ray, last: ptr<function, Crossing>, limit: f32, steps: ptr<function, u32>) -> vec2<f32> {
    let index = primitive_index(medium.boundary);
    let pose = pose_of_boundary(medium.boundary);
    if (*last).t >= limit {
        return NO_INTERVAL;
    }
    var inside = NO_INTERVAL;
    switch primitive_kind(medium.boundary) {
        //@ each convex_boundary
        case ${number}u: {
            inside = ${name}_interval(ray, moved_${name}(${name}s[index], pose));
        }
        //@ end
        default: {
            return next_in_mesh(ray, index, pose, last, limit, steps);
        }
    }
    (*last).t = VERY_FAR;
    inside.y = min(inside.y, limit);
    return select(NO_INTERVAL, inside, inside.x < inside.y);
}

// The distance at which the medium scatters the ray in an interval, or NO_HIT, or WALK_CUT.
fn event_within(
    medium: Medium,
    field: ScalarField,
    here: Ray,
    inside: vec2<f32>,
    words: ptr<function, vec4<u32>>,
    steps: ptr<function, u32>,
) -> f32 {
    switch field.kind {
        //@ each varying
        case ${number}u: {
            return event_in_${name}(field, here, inside, words, steps);
        }
        //@ end
        default: {
            return collision_within(inside, optical_depth((*words).xy) / medium.density, inside.y);
        }
    }
}

// An estimate of the share of light that passes the medium in an interval, or WALK_CUT.
fn share_through(
    medium: Medium,
    field: ScalarField,
    here: Ray,
    inside: vec2<f32>,
    words: ptr<function, vec4<u32>>,
    steps: ptr<function, u32>,
) -> f32 {
    switch field.kind {
        //@ each varying
        case ${number}u: {
            return share_through_${name}(field, here, inside, words, steps);
        }
        //@ end
        default: {
            return exp(-medium.density * (inside.y - inside.x));
        }
    }
}
