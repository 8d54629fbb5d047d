//@ use data/hit
//@ use data/material
//@ use data/surface
//@ use bind/details
//@ use bind/materials
//@ use choice/colour
// The colour that a detail of a material has at a hit. `index` is that of its row.
fn detail_colour(index: u32, hit: Hit, surface: Surface) -> vec3<f32> {
    let row = materials[index];
    var own = surface;
    own.frame += row.kind;
    return surface_colour(row, hit, own);
}
