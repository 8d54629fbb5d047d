//@ implements collision when !varying
//@ use bind/media
//@ use medium/free_flight
//@ use scene/at_run_time
//@ use choice/pose_of_boundary
//@ each convex_boundary
//@ use medium/${name}
//@ use bind/${name}s
//@ use choice/moved_${name}
//@ end
//@ use choice/medium_in_mesh
// Finds where media of constant density scatter rays.

// The distance at which the medium of this index scatters a ray, if that is nearer than `limit`; NO_HIT otherwise, or WALK_CUT if the walk took
// too many steps. `words` are random. It has only the kinds of boundary that the scene has.
fn collision(number: u32, ray: Ray, words: vec4<u32>, limit: f32, steps: ptr<function, u32>) -> f32 {
    let medium = media[at_run_time(number)];
    let distance = optical_depth(words.xy) / medium.density;
    let index = primitive_index(medium.boundary);
    let pose = pose_of_boundary(medium.boundary);
    switch primitive_kind(medium.boundary) {
        //@ each convex_boundary
        case ${number}u: {
            return collision_within(${name}_interval(ray, moved_${name}(${name}s[index], pose)), distance, limit);
        }
        //@ end
        default: {
            return collision_in_mesh(ray, index, pose, distance, limit, steps);
        }
    }
}
