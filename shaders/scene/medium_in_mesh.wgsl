//@ use data/ray
//@ use data/surface
//@ use data/medium
//@ use data/primitive
//@ use bind/nodes
//@ use bind/instances
//@ use geometry/bounds
//@ use scene/meshes
//@ use lib/float
//@ relies on loops
// Media bounded by closed meshes, which a ray may enter and leave any number of times.

// The deepest that the stack can get in such a mesh's BVH.
const CROSSING_STACK_SIZE: u32 = ${boundary_stack_size}u;

// Steps of all walks along one ray, in all media (stage/bounce). More where the numerics probe finds no limit on loops.
override MOST_STEPS_OF_CROSSINGS: u32 = STEPS_OF_CROSSINGS;

// Where a ray crosses a closed mesh.
struct Crossing {
    t: f32,
    // The face's index; among crossings at one distance they come in its order.
    face: u32,
    // How many times the mesh winds around the ray's way before the crossing; 0 is outside.
    winding: i32,
}

// The next crossing behind another one, and the winding on the way between: every face that the ray meets from there on
// to infinity is either left, from a place inside, or entered. The faces of a closed mesh are met without gaps and
// doubles (geometry/triangle), so that the count is right wherever the ray starts.
fn next_crossing(ray: Ray, root: u32, last: Crossing, steps: ptr<function, u32>) -> Crossing {
    let inverse = slab_inverse(ray.direction);
    var next = Crossing(VERY_FAR, 0xffffffffu, 0);
    var stack: array<u32, CROSSING_STACK_SIZE>;
    var depth = 0u;
    var code = root;
    loop {
        *steps += 1u;
        if *steps >= MOST_STEPS_OF_CROSSINGS {
            break;
        }
        if (code & PRIMITIVE_BIT) != 0u {
            let face = primitive_index(code);
            let met = face_hit(ray, inverse, face);
            if met.t > last.t || (met.t == last.t && face > last.face) {
                next.winding += select(1, -1, met.front);
                if met.t < next.t || (met.t == next.t && face < next.face) {
                    next.t = met.t;
                    next.face = face;
                }
            }
        } else {
            let keys = child_keys(nodes[code], ray.origin, inverse, VERY_FAR);
            for (var child = 0u; child < 4u; child++) {
                stack[depth] = code * 4u + child;
                depth += u32(keys[child] != CHILD_MISSED);
            }
        }
        if depth == 0u {
            break;
        }
        depth -= 1u;
        let follow = stack[depth];
        code = nodes[follow / 4u].children[follow % 4u];
    }
    return next;
}

// The distance along a ray at which its way inside the mesh has a length, if that is nearer than `limit`; else NO_HIT,
// or WALK_CUT.
fn collision_in_mesh(ray: Ray, index: u32, way: f32, limit: f32, steps: ptr<function, u32>) -> f32 {
    let instance = instances[index];
    let here = to_mesh(instance, ray);
    var left = way;
    var last = Crossing(0.0, 0xffffffffu, 0);
    // The last crossing of all is not followed by another one: its distance is VERY_FAR.
    while last.t < limit {
        let next = next_crossing(here, instance.root, last, steps);
        if *steps >= MOST_STEPS_OF_CROSSINGS {
            return WALK_CUT;
        }
        if next.winding != 0 {
            let t = last.t + left;
            if t < next.t {
                return select(NO_HIT, t, t < limit);
            }
            left -= next.t - last.t;
        }
        last = next;
    }
    return NO_HIT;
}

// The length of the way inside up to distance t, or WALK_CUT.
fn way_in_mesh(ray: Ray, index: u32, t: f32, steps: ptr<function, u32>) -> f32 {
    let instance = instances[index];
    let here = to_mesh(instance, ray);
    var way = 0.0;
    var last = Crossing(0.0, 0xffffffffu, 0);
    while last.t < t {
        let next = next_crossing(here, instance.root, last, steps);
        if *steps >= MOST_STEPS_OF_CROSSINGS {
            return WALK_CUT;
        }
        way += select(0.0, min(next.t, t) - last.t, next.winding != 0);
        last = next;
    }
    return way;
}
