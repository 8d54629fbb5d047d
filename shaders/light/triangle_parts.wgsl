//@ use geometry/triangle
//@ use light/parts
//@ use light/triangle
// Parts of a triangle: smaller triangles of its shape.

fn part_of_triangle(corners: Corners, part: u32) -> Corners {
    let cell = cell_of_part(part);
    // The triangle above the diagonal is the one below it, turned by half a turn around the cell's middle.
    let first = cell.low + select(vec2<f32>(0.0), cell.size, cell.is_above);
    let step = select(cell.size, -cell.size, cell.is_above);
    let to_b = corners.b - corners.a;
    let to_c = corners.c - corners.a;
    let a = corners.a + (first.x * to_b + first.y * to_c);
    return Corners(a, a + step.x * to_b, a + step.y * to_c);
}

fn triangle_part_sample(from_point: vec3<f32>, triangle: Triangle, part: u32, u: vec2<f32>) -> DirectionSample {
    return corners_sample(from_point, part_of_triangle(corners_in_render_space(triangle), part), u);
}

fn triangle_part_pdf(from_point: vec3<f32>, direction: vec3<f32>, triangle: Triangle, part: u32) -> f32 {
    return corners_pdf(from_point, part_of_triangle(corners_in_render_space(triangle), part));
}

fn triangle_part_point(triangle: Triangle, part: u32, u: vec2<f32>) -> LightPoint {
    return corners_point(part_of_triangle(corners_in_render_space(triangle), part), u);
}

fn triangle_part_coordinates(weights: vec3<f32>) -> vec2<f32> {
    return weights.yz;
}
