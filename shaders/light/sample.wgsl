// A sampled direction towards a light.
struct DirectionSample {
    // Unit vector.
    direction: vec3<f32>,
    // Pdf of the direction in solid angle. 0 if the light cannot be sampled from the point.
    pdf: f32,
}

// A point of a light, uniform in its area, and its outward normal; 0 on a flat light, which light may leave on both sides.
struct LightPoint {
    point: vec3<f32>,
    outward: vec3<f32>,
}

const NO_DIRECTION_SAMPLE: DirectionSample = DirectionSample(vec3<f32>(0.0, 0.0, 1.0), 0.0);
