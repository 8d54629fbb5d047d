//@ use data/motion
//@ use data/primitive
//@ use data/surface
//@ use lib/tangents
// Large spheres rest.
fn moved_large_sphere(large_sphere: LargeSphere, pose: Pose) -> LargeSphere {
    return large_sphere;
}

fn large_sphere_at_rest(surface: Surface, large_sphere: LargeSphere) -> Surface {
    return surface;
}

fn large_sphere_unturned(surface: Surface) -> Surface {
    return surface;
}

fn large_sphere_tangents_with(tangents: Tangents, pose: Pose) -> Tangents {
    return tangents;
}
