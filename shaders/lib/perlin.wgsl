// Gradient noise with period 256 in each direction: Perlin, "An Image Synthesizer", SIGGRAPH 1985, with the cubic fade and unit
// gradients. The gradient of a lattice point is a hash of the point, so there is no table and no binding.

fn lattice_gradient(cell: vec3<i32>) -> vec3<f32> {
    let bits = pcg4d(vec4<u32>(bitcast<vec3<u32>>(cell) & vec3<u32>(255u), 0x9e3779b9u));
    // A point of the cube [-1, 1]^3, never zero, because each coordinate is an odd number of half-steps.
    let in_cube = vec3<f32>(bits.xyz >> vec3<u32>(8u)) * 0x1p-23f + (0x1p-24f - 1.0);
    return normalize(in_cube);
}

// Gradient noise in (-1, 1). It is zero at lattice points, and continuous with its first derivative.
fn perlin(point: vec3<f32>) -> f32 {
    let base = floor(point);
    let f = point - base;
    // The coordinates are first reduced by the period, which is exact. Beyond 2^31 they would fit no integer.
    let cell = vec3<i32>(base - 256.0 * floor(base * 0x1p-8f));
    let fade = f * f * (3.0 - 2.0 * f);
    var sum = 0.0;
    for (var corner = 0; corner < 8; corner++) {
        let step = vec3<i32>(corner & 1, (corner >> 1) & 1, corner >> 2);
        let weight = select(1.0 - fade, fade, step == vec3<i32>(1));
        sum += weight.x * weight.y * weight.z * dot(lattice_gradient(cell + step), f - vec3<f32>(step));
    }
    return sum;
}

// |sum of perlin(2^i p) / 2^i| over seven octaves.
fn turbulence(point: vec3<f32>) -> f32 {
    var sum = 0.0;
    var p = point;
    var weight = 1.0;
    for (var octave = 0; octave < 7; octave++) {
        sum += weight * perlin(p);
        weight *= 0.5;
        p *= 2.0;
    }
    return abs(sum);
}
