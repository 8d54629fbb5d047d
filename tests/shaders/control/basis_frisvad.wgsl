// Wrong on purpose: Frisvad, "Building an Orthonormal Basis from a 3D Unit Vector Without Normalization", JGT 16(3), 2012,
// which cancels near z = -1.
fn basis_around(n: vec3<f32>) -> Basis {
    if n.z < -0.9999999 {
        return Basis(vec3<f32>(0.0, -1.0, 0.0), vec3<f32>(-1.0, 0.0, 0.0), n);
    }
    let a = 1.0 / (1.0 + n.z);
    let b = -n.x * n.y * a;
    return Basis(vec3<f32>(1.0 - n.x * n.x * a, b, -n.x), vec3<f32>(b, 1.0 - n.y * n.y * a, -n.y), n);
}
