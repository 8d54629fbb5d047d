// A sampled direction towards a light.
struct DirectionSample {
    // Unit vector.
    direction: vec3<f32>,
    // Pdf of the direction in solid angle. 0 if the light cannot be sampled from the point.
    pdf: f32,
}

const NO_DIRECTION_SAMPLE: DirectionSample = DirectionSample(vec3<f32>(0.0, 0.0, 1.0), 0.0);
