//@ use light/disk
//@ use light/parts
// Parts of a disk: pieces of rings. The coordinates are the uniform numbers of its points: the square of the radius, and the turns.

fn disk_part_sample(from_point: vec3<f32>, square: Quad, part: u32, u: vec2<f32>) -> DirectionSample {
    let cell = cell_of_part(part);
    let whole = disk_light_sample(from_point, square, cell.low + cell.size * u);
    return DirectionSample(whole.direction, whole.pdf / (cell.size.x * cell.size.y));
}

fn disk_part_pdf(from_point: vec3<f32>, direction: vec3<f32>, square: Quad, part: u32) -> f32 {
    let cell = cell_of_part(part);
    return disk_light_pdf(from_point, direction, square) / (cell.size.x * cell.size.y);
}

fn disk_part_point(square: Quad, part: u32, u: vec2<f32>) -> LightPoint {
    let cell = cell_of_part(part);
    return disk_light_point(square, cell.low + cell.size * u);
}

fn disk_part_coordinates(local: vec3<f32>) -> vec2<f32> {
    let offset = 2.0 * local.xy - 1.0;
    let half_turns = angle_of(abs(offset.y), offset.x) / PI;
    return vec2<f32>(min(dot(offset, offset), 1.0), 0.5 + select(0.5, -0.5, offset.y < 0.0) * half_turns);
}
