//@ use data/path
//@ use data/primitive
//@ if aov_depth
//@ use bind/settings
//@ end
//@ if aov_object
//@ use scene/primitives
//@ end
//@ if aov_material
//@ use scene/surfaces
//@ end
// Channels of the first surface that a camera ray hits: its depth, its position, and which it is. Media do not matter to them.
fn note_hit(path: ptr<function, Path>) {
    if (*path).depth != 0u || (*path).status >= FIRST_STATUS {
        return;
    }
    //@ if aov_hits
    (*path).hits += 1.0;
    //@ end
    //@ if aov_depth
    // Along the camera's axis. A lens lies across it, so that all of its rays start at depth 0.
    (*path).depth_sum += (*path).t * dot((*path).ray.direction, settings.forward);
    //@ end
    //@ if aov_position
    (*path).position_sum += (*path).ray.origin + (*path).t * (*path).ray.direction;
    //@ end
    // A mean of numbers means nothing: these are of the pixel's first sample.
    //@ if aov_object
    if (*path).sample == 0u {
        (*path).object = f32(primitive_order(path_hit(path)) + 1u);
    }
    //@ end
    //@ if aov_material
    if (*path).sample == 0u {
        (*path).material = f32(material_index(path_hit(path)) + 1u);
    }
    //@ end
}
