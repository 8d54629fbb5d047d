//@ use bind/extensions
//@ use bind/materials
//@ use choice/colour
// Returns the colour of a material's extension at a hit. `index` is the row of the extension.
fn extension_colour(index: u32, hit: Hit, surface: Surface) -> vec3<f32> {
    let row = materials[index];
    var framed = surface;
    framed.frame += row.kind;
    return surface_colour(row, hit, framed);
}
