//@ use lobe/tabled_albedo
// The directional albedo of a rough white metal by single scattering, interpolated in a table.

// The size of the table (src/material/microfacets.rs).
const ALBEDO_ROWS: u32 = 32u;
const ALBEDO_COLUMNS: u32 = 32u;

fn directional_albedo(cosine: f32, roughness: f32) -> f32 {
    let rough = max(roughness, LEAST_ROUGHNESS);
    let alpha = rough * rough;
    let x = cosine * (1.0 + alpha) / (cosine + alpha) * f32(ALBEDO_COLUMNS - 1u);
    let y = rough * f32(ALBEDO_ROWS - 1u);
    let column = min(u32(x), ALBEDO_COLUMNS - 2u);
    let row = min(u32(y), ALBEDO_ROWS - 2u);
    let at = row * ALBEDO_COLUMNS + column;
    let below = at + ALBEDO_COLUMNS;
    let right = x - f32(column);
    return mix(tabled_albedo(at, right), tabled_albedo(below, right), y - f32(row));
}
