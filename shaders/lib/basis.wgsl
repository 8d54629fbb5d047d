// An orthonormal basis whose third vector is the unit vector n, exact to an ulp everywhere:
// Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
struct Basis {
    tangent: vec3<f32>,
    bitangent: vec3<f32>,
    normal: vec3<f32>,
}

fn basis_around(n: vec3<f32>) -> Basis {
    let s = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    return Basis(
        vec3<f32>(1.0 + s * n.x * n.x * a, s * b, -s * n.x),
        vec3<f32>(b, s + n.y * n.y * a, -n.y),
        n,
    );
}

fn from_basis(basis: Basis, local: vec3<f32>) -> vec3<f32> {
    return local.x * basis.tangent + local.y * basis.bitangent + local.z * basis.normal;
}

// A direction in the axes of the basis.
fn in_basis(basis: Basis, v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(v, basis.tangent), dot(v, basis.bitangent), dot(v, basis.normal));
}
