// What choosing a direction towards a light gives.
struct DirectionSample {
    // Unit.
    direction: vec3<f32>,
    // Density of the direction in solid angle; 0 where the light has nothing to sample from there.
    pdf: f32,
}

const NO_DIRECTION_SAMPLE: DirectionSample = DirectionSample(vec3<f32>(0.0, 0.0, 1.0), 0.0);
