//@ implements surface_group when surface & aov.lights
//@ use bind/light_groups
//@ use scene/surfaces
// The group of the light that a surface emits.
fn group_of_surface(hit: Hit) -> u32 {
    return light_groups[${delta_lights}u + material_index(hit)];
}

//@ without
// There is no surface.
fn group_of_surface(hit: Hit) -> u32 {
    return 0xffffffffu;
}
