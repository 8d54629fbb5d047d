//@ use data/hit
//@ use data/material
//@ use data/surface
//@ use scene/details
// Numbers of materials that vary over a surface.

// The material of a surface, with the numbers that it has at a hit.
fn material_at(hit: Hit, surface: Surface) -> Material {
    let own = details[surface.material];
    var material = materials[surface.material];
    //@ if varying_roughness
    if own.roughness != NO_DETAIL {
        material.parameter = number_at(own.roughness, hit, surface);
    }
    //@ end
    //@ if varying_metallic
    if own.metallic != NO_DETAIL {
        material.contrast_inside = number_at(own.metallic, hit, surface);
    }
    //@ end
    return material;
}

// The number of a detail. Rounding may have put it above its largest texel.
fn number_at(index: u32, hit: Hit, surface: Surface) -> f32 {
    return min(detail_colour(index, hit, surface).x, 1.0);
}
