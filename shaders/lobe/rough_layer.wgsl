//@ implements rough_layer when rough_layer
//@ use lobe/tabled_albedo
// The share of light at a cosine that a layer of microfacets lets pass, interpolated in a table of the material (src/material/layer.rs).

// The elements of a table, for equal steps of the cosine's square root.
const LAYER_COLUMNS: u32 = 64u;

fn passed_by_layer(by_smooth: f32, material: Material, hit: Interaction, cosine: f32) -> f32 {
    if material.${plastic.roughness} < LEAST_ROUGHNESS {
        return by_smooth;
    }
    let x = sqrt(cosine) * f32(LAYER_COLUMNS - 1u);
    let column = min(u32(x), LAYER_COLUMNS - 2u);
    return tabled_albedo(u32(hit.second.${plastic.table}) + column, x - f32(column));
}

//@ without
// All layers are smooth.
fn passed_by_layer(by_smooth: f32, material: Material, hit: Interaction, cosine: f32) -> f32 {
    return by_smooth;
}
