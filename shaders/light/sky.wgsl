//@ use light/alias
//@ use light/sample
//@ use lib/angle
//@ use lib/sphere_map
// The sky's image as a light. The alias method draws a cell of a grid over the image. Then a direction is drawn uniformly in
// the cell's solid angle. A sample loads one entry of four words, and so does the density of a given direction. The grid has
// the layout of the image (lib/sphere_map): rows go down from +y, and columns go around from +z through -x, -z and +x.

// A direction uniform in the solid angle of a cell: (1 - cos theta) / 2 = sin^2(theta / 2) is uniform between its values at the
// cell's upper and lower edge. These values differ by sin(b - a) sin(b + a), with a and b half the edges' angles. Below the
// horizon, angles are measured from -y instead of +y, so the precision is always that of the nearer pole.
fn sky_cell_direction(index: u32, columns: u32, rows: u32, u: vec2<f32>) -> vec3<f32> {
    let column = index % columns;
    let row = index / columns;
    let below = row >= rows - row;
    let from_pole = f32(select(row, rows - 1u - row, below));
    // In turns, the unit of circle_point.
    let step = 0.25 / f32(rows);
    let edge = circle_point(from_pole * step).y;
    let height = edge * edge + u.y * (circle_point(step).y * circle_point(min((2.0 * from_pole + 1.0) * step, 0.5)).y);
    let across = 2.0 * sqrt(height * max(1.0 - height, 0.0));
    let y = 1.0 - 2.0 * height;
    // Around the y axis, from -z towards +x.
    let around = across * circle_point((f32(column) + u.x) / f32(columns) - 0.5);
    return normalize(vec3<f32>(around.y, select(y, -y, below), -around.x));
}

// The cell that contains a direction.
fn sky_cell_at(direction: vec3<f32>, columns: u32, rows: u32) -> u32 {
    let uv = sky_uv(direction);
    let column = min(u32(uv.x * f32(columns)), columns - 1u);
    let row = min(u32(uv.y * f32(rows)), rows - 1u);
    return row * columns + column;
}
