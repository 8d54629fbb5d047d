//@ implements media_transmittance when !varying
//@ use bind/media
//@ use choice/pose_of_boundary
//@ use scene/at_run_time
//@ each convex_boundary
//@ use medium/${name}
//@ use bind/${name}s
//@ use choice/moved_${name}
//@ end
//@ use choice/medium_in_mesh
// The fraction of light that passes all media up to distance t, or WALK_CUT if a walk took too many steps.
fn transmittance(ray: Ray, t: f32, steps: ptr<function, u32>) -> f32 {
    var depth = 0.0;
    for (var i = 0u; i < ${media}u; i++) {
        let medium = media[at_run_time(i)];
        let index = primitive_index(medium.boundary);
        let pose = pose_of_boundary(medium.boundary);
        var distance = 0.0;
        switch primitive_kind(medium.boundary) {
            //@ each convex_boundary
            case ${number}u: {
                distance = length_within(${name}_interval(ray, moved_${name}(${name}s[index], pose)), t);
            }
            //@ end
            default: {
                distance = length_in_mesh(ray, index, pose, t, steps);
            }
        }
        if distance == WALK_CUT {
            return WALK_CUT;
        }
        depth += medium.density * distance;
    }
    return exp(-depth);
}
