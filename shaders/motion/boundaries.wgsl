//@ implements pose_of_boundary when boundary_moves
//@ use motion/pose
//@ each moving_boundary
//@ use bind/${name}s
//@ end
// The poses of the boundaries of media.

// The order of a boundary of a kind that moves; 0 of others.
fn order_of_boundary(code: u32) -> u32 {
    let index = primitive_index(code);
    switch primitive_kind(code) {
        //@ each moving_boundary
        case ${number}u: {
            return ${name}s[index].order;
        }
        //@ end
        default: {
            return 0u;
        }
    }
}

fn pose_of_boundary(code: u32) -> Pose {
    return pose_of(order_of_boundary(code));
}

//@ without
// No boundary of a medium moves.
fn pose_of_boundary(code: u32) -> Pose {
    return Pose();
}
