//@ use lobe/tabled_albedo
// The directional albedo of white sheen, interpolated in a table behind that of rough metals. It is nowhere less than the true one.

// The size of the table, and where it begins (src/lobe/sheen.rs).
const SHEEN_ROWS: u32 = 32u;
const SHEEN_COLUMNS: u32 = 32u;
const SHEEN_BEGIN: u32 = 1024u;

fn white_sheen_albedo(cosine: f32, roughness: f32) -> f32 {
    let rough = (max(roughness, LEAST_SHEEN_ROUGHNESS) - LEAST_SHEEN_ROUGHNESS) / (1.0 - LEAST_SHEEN_ROUGHNESS);
    let x = sqrt(sqrt(cosine)) * f32(SHEEN_COLUMNS - 1u);
    let y = sqrt(rough) * f32(SHEEN_ROWS - 1u);
    let column = min(u32(x), SHEEN_COLUMNS - 2u);
    let row = min(u32(y), SHEEN_ROWS - 2u);
    let at = SHEEN_BEGIN + row * SHEEN_COLUMNS + column;
    let below = at + SHEEN_COLUMNS;
    let right = x - f32(column);
    return mix(tabled_albedo(at, right), tabled_albedo(below, right), y - f32(row));
}
