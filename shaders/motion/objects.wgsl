//@ implements pose when moves
//@ use data/hit
//@ use data/primitive
//@ use motion/pose
//@ each moving
//@ use bind/${name}s
//@ end
//@ if moves.triangle
//@ use bind/instances
//@ use scene/at_run_time
//@ end
// The poses of objects by their codes. Drivers inline each call, so that what needs a pose several times gets it once.

// The order of an object of a kind that moves; 0 of others. For a face, `instance` is that of its mesh; without one it is in the mesh's space, and rests.
fn order_of_object(code: u32, instance: u32) -> u32 {
    let index = primitive_index(code);
    switch primitive_kind(code) {
        //@ each moving
        case ${number}u: {
            return ${name}s[index].order;
        }
        //@ end
        //@ if moves.triangle
        case KIND_TRIANGLE: {
            if instance == NO_INSTANCE {
                return 0u;
            }
            return instances[at_run_time(instance)].order;
        }
        case KIND_INSTANCE: {
            return instances[index].order;
        }
        //@ end
        default: {
            return 0u;
        }
    }
}

// Its place in the order of the scene.
fn place_of(order: u32) -> u32 {
    return order & ~MOVES;
}

fn pose_at(code: u32, instance: u32) -> Pose {
    return pose_of(order_of_object(code, instance));
}

//@ without
//@ use data/motion
// No object moves.
fn pose_at(code: u32, instance: u32) -> Pose {
    return Pose();
}

fn place_of(order: u32) -> u32 {
    return order;
}
