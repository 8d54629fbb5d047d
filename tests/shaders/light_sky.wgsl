//@ use scene/sky
//@ use sampler/independent
// A direction towards the sky, its point on the image, and its density: by that point, and by the direction.
struct In {
    // Uniforms for the row and for the column; or the point.
    u: vec2<f32>,
    columns: u32,
    rows: u32,
}

struct Out {
    direction: vec3<f32>,
    pdf: f32,
    point: vec2<f32>,
    again: f32,
    padding: u32,
}

fn run(index: u32) {
    let given = input[${row}];
    let point = ${point};
    let direction = sky_direction(point);
    let pdf = sky_pdf(direction, point, given.columns, given.rows);
    let again = sky_pdf(direction, sky_uv(direction), given.columns, given.rows);
    output[index] = Out(direction, pdf, point, again, 0u);
}
