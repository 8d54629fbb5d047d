// Wrong on purpose: no fade, so that the slope jumps at the lattice; truncated cells, wrong below zero; a period of 255.
fn lattice_gradient(cell: vec3<i32>) -> vec3<f32> {
    let wrapped = vec3<u32>((cell % vec3<i32>(255) + vec3<i32>(255)) % vec3<i32>(255));
    let bits = pcg4d(vec4<u32>(wrapped, 0x9e3779b9u));
    return normalize(vec3<f32>(bits.xyz >> vec3<u32>(8u)) * 0x1p-23f + (0x1p-24f - 1.0));
}

fn perlin(point: vec3<f32>) -> f32 {
    let cell = vec3<i32>(point);
    let f = point - vec3<f32>(cell);
    var sum = 0.0;
    for (var corner = 0; corner < 8; corner++) {
        let step = vec3<i32>(corner & 1, (corner >> 1) & 1, corner >> 2);
        let weight = select(1.0 - f, f, step == vec3<i32>(1));
        sum += weight.x * weight.y * weight.z * dot(lattice_gradient(cell + step), f - vec3<f32>(step));
    }
    return sum;
}

fn turbulence(point: vec3<f32>) -> f32 {
    return abs(perlin(point));
}
