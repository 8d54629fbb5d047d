//@ use geometry/bounds
//@ use geometry/slab
//@ use choice/mesh_tree
// A walk through the BVH: where it is, and what is still to be visited.

// The greatest depth of the stack in this scene's BVH. It is filled in as text, because an override cannot be the
// size of a private array in WGSL.
const STACK_SIZE: u32 = ${stack_size}u;

// The waiting children of a node, in one word: what names them (choice/mesh_tree) above three numbers of two bits, the nearest child lowest. The last
// number is repeated if fewer than three wait.
const WAITING_BITS: u32 = 6u;
const NONE_WAIT: u32 = 0xffffffffu;

struct Walk {
    // The node or the primitive that it visits.
    code: u32,
    // The ray in the space of the current nodes: the scene's space, or that of the mesh that the walk has entered.
    ray: Ray,
    inverse: vec3<f32>,
    // The nodes with children that are still to be visited are on a stack of this depth, but for the last one of them.
    depth: u32,
    waiting: u32,
    // The instance of the mesh that it has entered, and the stack's depth and what was on top of it there.
    instance: u32,
    entered_at: u32,
    outside: u32,
    // The bit of the face of this pair that the last iteration tested, if this iteration tests the other one.
    tested: u32,
}

fn start_walk(walk: ptr<function, Walk>, ray: Ray, root: u32) {
    (*walk).code = root;
    (*walk).ray = ray;
    (*walk).inverse = slab_inverse(ray.direction);
    (*walk).waiting = NONE_WAIT;
    (*walk).instance = NO_INSTANCE;
}

// The word for the children with these keys. The first one is not CHILD_MISSED.
fn wait_for(children: u32, keys: vec3<u32>) -> u32 {
    let second = select(keys.y, keys.x, keys.y == CHILD_MISSED);
    let third = select(keys.z, second, keys.z == CHILD_MISSED);
    let numbers = vec3<u32>(keys.x, second, third) & vec3<u32>(CHILD_MASK);
    return (children << WAITING_BITS) | (numbers.z << 4u) | (numbers.y << 2u) | numbers.x;
}

// The nearest child of the walk's node that the ray may hit before `nearest`, or CHILD_MISSED. The others wait.
fn nearest_child(walk: ptr<function, Walk>, stack: ptr<function, array<u32, STACK_SIZE>>, visited: Visited, nearest: f32) -> u32 {
    let children = children_of((*walk).code, visited, (*walk).instance != NO_INSTANCE);
    let node = visited_node(visited);
    let keys = sort_keys(child_keys(node, (*walk).ray.origin, (*walk).inverse, begin_of_walk(), nearest));
    if keys.y != CHILD_MISSED {
        if (*walk).waiting != NONE_WAIT {
            (*stack)[(*walk).depth] = (*walk).waiting;
            (*walk).depth += 1u;
        }
        (*walk).waiting = wait_for(children, keys.yzw);
    }
    return select(children * 4u + (keys.x & CHILD_MASK), CHILD_MISSED, keys.x == CHILD_MISSED);
}

// Takes the next of the children that wait; at least one does. The caller tests that, because a return in the middle of this function would make
// walks 2 % slower on llvmpipe.
fn take_waiting(walk: ptr<function, Walk>) -> u32 {
    let waiting = (*walk).waiting;
    let child = waiting & CHILD_MASK;
    let after = (waiting >> 2u) & CHILD_MASK;
    // The next child moves to the lowest bits, and the last one is repeated.
    let rest = (waiting & ~15u) | ((waiting >> 2u) & 15u);
    (*walk).waiting = select(rest, NONE_WAIT, after == child);
    return (waiting >> WAITING_BITS) * 4u + child;
}
