//@ use data/motion
//@ use data/primitive
//@ use data/surface
//@ use lib/tangents
// Spheres rest.
fn moved_sphere(sphere: Sphere, pose: Pose) -> Sphere {
    return sphere;
}

fn sphere_at_rest(surface: Surface, sphere: Sphere) -> Surface {
    return surface;
}

fn sphere_unturned(surface: Surface) -> Surface {
    return surface;
}

fn sphere_tangents_with(tangents: Tangents, pose: Pose) -> Tangents {
    return tangents;
}
