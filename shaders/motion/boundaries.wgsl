//@ implements pose_of_boundary when boundary_moves
//@ use data/medium
//@ use data/primitive
//@ use motion/pose
//@ each convex_boundary
//@ use bind/${name}s
//@ end
//@ if boundary.mesh
//@ use bind/instances
//@ end
// The poses of the boundaries of media.

fn order_of_boundary(code: u32) -> u32 {
    let index = primitive_index(code);
    switch primitive_kind(code) {
        //@ each convex_boundary
        ${case}: {
            return ${name}s[index].order;
        }
        //@ end
        //@ if boundary.mesh
        default: {
            return instances[index].order;
        }
        //@ end
    }
}

fn pose_of_boundary(code: u32) -> Pose {
    return pose_of(order_of_boundary(code));
}

//@ without
//@ use data/motion
// No boundary of a medium moves.
fn pose_of_boundary(code: u32) -> Pose {
    return Pose();
}
