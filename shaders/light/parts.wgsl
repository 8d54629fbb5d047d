// Parts of flat lights whose radiance varies. A shape has coordinates in the unit square, such that equal areas there are equal areas of the
// shape; those of a triangle are the weights of its second and third corner. A part is a cell of a grid over the square. Its code has
// the column and the row in 11 bits each, and the exponents of the numbers of columns and rows in 4 bits each. The cells of triangles are
// cut by a diagonal, and a last bit says that the part is the triangle above it (src/flatten/light_parts.rs).

struct PartCell {
    low: vec2<f32>,
    size: vec2<f32>,
    is_above: bool,
}

fn cell_of_part(part: u32) -> PartCell {
    let exponents = vec2<u32>(part >> 22u, part >> 26u) & vec2<u32>(15u);
    let size = bitcast<vec2<f32>>((vec2<u32>(127u) - exponents) << vec2<u32>(23u));
    return PartCell(vec2<f32>(vec2<u32>(part, part >> 11u) & vec2<u32>(0x7ffu)) * size, size, ((part >> 30u) & 1u) != 0u);
}

// Whether a part has this point.
fn part_holds(part: u32, at: vec2<f32>, is_triangle: bool) -> bool {
    let cell = cell_of_part(part);
    let within = (at - cell.low) / cell.size;
    let is_above = is_triangle && within.x + within.y > 1.0;
    return all(within >= vec2<f32>(0.0)) && all(within < vec2<f32>(1.0)) && is_above == cell.is_above;
}
