//@ use light/alias
//@ use light/sample
//@ use lib/angle
//@ use lib/sphere_map
// The sky's image as a light: a cell of a grid over it is drawn by the alias method, and a direction uniform in the cell's
// solid angle. What is loaded is one entry of four words a sample, and one for the density of a direction.
// The grid lies as the image does (lib/sphere_map): rows from +y down, columns around from +z through -x, -z and +x.

// An entry of the grid, row by row (src/lights.rs): the cell is drawn itself where the rest of the uniform is below the
// threshold, the one that it names otherwise. Densities are in solid angle.
struct SkyCell {
    threshold: f32,
    alias_index: u32,
    density: f32,
    alias_density: f32,
}

struct SkyChoice {
    index: u32,
    pdf: f32,
}

// What is drawn, where alias_pick led to this cell.
fn sky_choice(pick: AliasPick, cell: SkyCell) -> SkyChoice {
    let own = pick.rest < cell.threshold;
    return SkyChoice(select(cell.alias_index, pick.index, own), select(cell.alias_density, cell.density, own));
}

// A direction uniform in the solid angle of a cell: (1 - cos theta) / 2 = sin^2(theta / 2) is uniform between its values at
// the cell's upper and lower edge, which differ by sin(b - a) sin(b + a), a and b their halved angles. Below the horizon
// the same from -y up, so that the digits are those of the nearer pole.
fn sky_cell_direction(index: u32, columns: u32, rows: u32, u: vec2<f32>) -> vec3<f32> {
    let column = index % columns;
    let row = index / columns;
    let below = row >= rows - row;
    let from_pole = f32(select(row, rows - 1u - row, below));
    // In turns, as circle_point takes them.
    let step = 0.25 / f32(rows);
    let edge = circle_point(from_pole * step).y;
    let height = edge * edge + u.y * (circle_point(step).y * circle_point(min((2.0 * from_pole + 1.0) * step, 0.5)).y);
    let across = 2.0 * sqrt(height * max(1.0 - height, 0.0));
    let y = 1.0 - 2.0 * height;
    // From -z towards +x.
    let around = across * circle_point((f32(column) + u.x) / f32(columns) - 0.5);
    return normalize(vec3<f32>(around.y, select(y, -y, below), -around.x));
}

// The cell in which a direction lies.
fn sky_cell_at(direction: vec3<f32>, columns: u32, rows: u32) -> u32 {
    let place = sky_place(direction);
    let column = min(u32(place.x * f32(columns)), columns - 1u);
    let row = min(u32(place.y * f32(rows)), rows - 1u);
    return row * columns + column;
}
