// The basis around a vector.
struct In {
    normal: vec3<f32>,
    padding: u32,
}

struct Out {
    tangent: vec3<f32>,
    padding0: u32,
    bitangent: vec3<f32>,
    padding1: u32,
    // The point (1, 2, 3) of the basis.
    point: vec3<f32>,
    padding2: u32,
}

fn run(row: u32) {
    let basis = basis_around(input[row].normal);
    let point = from_basis(basis, vec3<f32>(1.0, 2.0, 3.0));
    output[row] = Out(basis.tangent, 0u, basis.bitangent, 0u, point, 0u);
}
