//@ use data/path
//@ use data/primitive
//@ use step/aov
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
    let place = film_place(path);
    //@ if aov_hits
    add_to_film(place, ${sum_of_hits}u, 1.0, SUM_FRACTION);
    //@ end
    //@ if aov_depth
    // Along the camera's axis. A lens lies across it, so that all of its rays start at depth 0.
    let depth = (*path).t * dot((*path).ray.direction, settings.forward);
    add_to_film(place, ${sum_of_depth}u, depth, SUM_FRACTION);
    //@ end
    //@ if aov_position
    add_vector_to_film(place, ${sum_of_position}u, (*path).ray.origin + (*path).t * (*path).ray.direction);
    //@ end
    // A mean of numbers means nothing: these are of the pixel's first sample.
    //@ if aov_object
    if (*path).sample == 0u {
        add_to_film(place, ${sum_of_object}u, f32(primitive_order(path_hit(path)) + 1u), SUM_FRACTION);
    }
    //@ end
    //@ if aov_material
    if (*path).sample == 0u {
        add_to_film(place, ${sum_of_material}u, f32(material_index(path_hit(path)) + 1u), SUM_FRACTION);
    }
    //@ end
}
