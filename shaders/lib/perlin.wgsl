//@ use lib/rng
// Gradient noise with period 256 in each direction: Perlin, "An Image Synthesizer", SIGGRAPH 1985, with the cubic fade and
// unit gradients. The gradient of a lattice point is a hash of it: no table, so no binding.

fn lattice_gradient(cell: vec3<i32>) -> vec3<f32> {
    let bits = pcg4d(vec4<u32>(bitcast<vec3<u32>>(cell) & vec3<u32>(255u), 0x9e3779b9u));
    // In the cube [-1, 1]^3 and never zero: an odd number of half-steps on every axis.
    let in_cube = vec3<f32>(bits.xyz >> vec3<u32>(8u)) * 0x1p-23f + (0x1p-24f - 1.0);
    return normalize(in_cube);
}

// In (-1, 1), zero on the lattice, continuous with its first derivative.
fn perlin(point: vec3<f32>) -> f32 {
    let base = floor(point);
    let f = point - base;
    // Reduced by the period first, which is exact: beyond 2^31 there are no integers to convert to.
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
