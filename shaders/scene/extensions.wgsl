//@ use data/hit
//@ use data/material
//@ use data/surface
//@ use bind/extensions
//@ use bind/materials
//@ use choice/colour
// The colour that an extension of a material has at a hit. `index` is that of its row.
fn extension_colour(index: u32, hit: Hit, surface: Surface) -> vec3<f32> {
    let row = materials[index];
    var own = surface;
    own.frame += row.kind;
    return surface_colour(row, hit, own);
}
