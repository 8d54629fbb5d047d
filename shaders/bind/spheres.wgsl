@group(0) @binding(6) var<${space_of_spheres}> spheres: array<Sphere${size_of_spheres}>;

fn sphere_at(index: u32, instance: u32) -> Sphere {
    return spheres[index];
}
