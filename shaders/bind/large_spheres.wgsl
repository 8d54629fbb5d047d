@group(0) @binding(20) var<${space_of_large_spheres}> large_spheres: array<LargeSphere${size_of_large_spheres}>;

fn large_sphere_at(index: u32, instance: u32) -> LargeSphere {
    return large_spheres[index];
}
