//@ implements pose when moves
//@ use motion/pose
//@ use choice/faces
//@ each moving
//@ use bind/${name}s
//@ end
// The poses of objects by their codes. Drivers inline each call, so that what needs a pose several times gets it once.

// The order of an object of a kind that moves; 0 of others.
fn order_of_object(code: u32) -> u32 {
    let index = primitive_index(code);
    switch primitive_kind(code) {
        //@ each moving
        case ${number}u: {
            return ${name}s[index].order;
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

// The pose of the object that a primitive is part of. A face without an instance is in the space of its mesh, and rests.
fn pose_at(code: u32, instance: u32) -> Pose {
    return pose_of(order_of_object(object_code(code, instance)));
}

//@ without
// No object moves.
fn pose_at(code: u32, instance: u32) -> Pose {
    return Pose();
}

fn place_of(order: u32) -> u32 {
    return order;
}
