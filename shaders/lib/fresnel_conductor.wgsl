// The reflectance of metals.

// The reflected share of unpolarised light, per channel, for an index of refraction eta + i k. `excess` is eta - 1. With (a + i b)^2 =
// (eta + i k)^2 - sin^2, the amplitudes' squares are ((a - c)^2 + b^2) / ((a + c)^2 + b^2), and that times ((a c - s^2)^2 + b^2 c^2) /
// ((a c + s^2)^2 + b^2 c^2) (Born and Wolf, Principles of Optics, section 14.4.1). Near an index of 1, a - c cancels. It is (a^2 - c^2) /
// (a + c), and a^2 - c^2 = b^2 + m with m the real part of (eta + i k)^2 - 1, which the excess gives with all its digits (own derivation).
fn fresnel_of_index(cosine: f32, excess: vec3<f32>, k: vec3<f32>) -> vec3<f32> {
    let s2 = (1.0 - cosine) * (1.0 + cosine);
    let m = excess * (2.0 + excess) - k * k;
    let real = m + cosine * cosine;
    let imaginary = 2.0 * (1.0 + excess) * k;
    let modulus = sqrt(real * real + imaginary * imaginary);
    // Of a^2 and b^2, the larger one is a sum. The other follows from 2 a b = the imaginary part.
    let larger = 0.5 * (modulus + abs(real));
    let smaller = 0.25 * imaginary * imaginary / max(larger, vec3<f32>(0x1p-60f));
    let a = sqrt(select(smaller, larger, real > vec3<f32>(0.0)));
    let b2 = select(larger, smaller, real > vec3<f32>(0.0));
    let more = a + cosine;
    // The form that is rounded less: by the parts of a sum over a + c, or by a + c.
    let less = select(a - cosine, (b2 + m) / max(more, vec3<f32>(0x1p-60f)), abs(m) + b2 < more * more);
    // Both are 0 along the surface of an index of 1.
    let perpendicular = (less * less + b2) / max(more * more + b2, vec3<f32>(0x1p-120f));
    let near = a * cosine - s2;
    let far = a * cosine + s2;
    let across = b2 * cosine * cosine;
    return 0.5 * perpendicular * (1.0 + (near * near + across) / (far * far + across));
}

// The reflectance by Schlick's approximation, from that at normal incidence.
fn schlick(cosine: f32, albedo: vec3<f32>) -> vec3<f32> {
    return schlick_up_to(cosine, albedo, 1.0);
}

// Schlick's approximation between the reflectances at normal and at grazing incidence.
fn schlick_up_to(cosine: f32, f0: vec3<f32>, f90: f32) -> vec3<f32> {
    let m = 1.0 - cosine;
    let m2 = m * m;
    return f0 + (f90 - f0) * (m2 * m2 * m);
}

// Of a metal of an albedo; or where the share is not 0 that share of the reflectance of an index, whose real part less 1 is `colour`.
fn reflectance_of_metal(cosine: f32, colour: vec3<f32>, k: vec3<f32>, share: f32) -> vec3<f32> {
    if share != 0.0 {
        return share * fresnel_of_index(cosine, colour, k);
    }
    return schlick(cosine, colour);
}
