// Interference in a thin film (Belcour and Barla, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence", ACM
// TOG 36(4), 2017), as KHR_materials_iridescence has it: Schlick's approximation at both boundaries, and light that passes the film up to
// three times.

// The colour of the interference at an optical path difference in nm. `turns` is the shift of the phase, in turns. The sensitivities of the eye
// are Gaussians in the Fourier domain (section 4 and its supplemental code): x is the sum of two.
fn interference(difference: f32, turns: vec3<f32>) -> vec3<f32> {
    let square = difference * difference;
    let waves = vec4<f32>(0.0016810, 0.0017953, 0.0022084, 0.0022399) * difference + turns.xyzx;
    let cosines = vec4<f32>(circle_point(waves.x).x, circle_point(waves.y).x, circle_point(waves.z).x, circle_point(waves.w).x);
    let widths = vec4<f32>(1.708547e-7, 3.673309e-7, 2.610352e-7, 1.787662e-7);
    let heights = vec4<f32>(0.84659, 1.000222, 1.001122, 0.1538683) * exp(-square * widths) * cosines;
    let xyz = vec3<f32>(heights.x + heights.w, heights.y, heights.z);
    return vec3<f32>(
        dot(xyz, vec3<f32>(3.2404542, -1.5371385, -0.4985314)),
        dot(xyz, vec3<f32>(-0.9692660, 1.8760108, 0.0415560)),
        dot(xyz, vec3<f32>(0.0556434, -0.2040259, 1.0572252)),
    );
}

// The reflectance of a film of this index and thickness in nm. `f0` is that of what lies below, in air at normal incidence.
fn thin_film(cosine: f32, film_ior: f32, thickness: f32, f0: vec3<f32>) -> vec3<f32> {
    // A film that is much thinner than light is no film.
    let ior = 1.0 + (film_ior - 1.0) * smoothstep(0.0, 0.03, thickness);
    let inside = sqrt((ior - 1.0) * (ior + 1.0) + cosine * cosine) / ior;
    let amplitude = (ior - 1.0) / (ior + 1.0);
    let top = schlick(cosine, vec3<f32>(amplitude * amplitude)).x;
    let root = sqrt(clamp(f0, vec3<f32>(0.0), vec3<f32>(0.9999)));
    let base_ior = (1.0 + root) / (1.0 - root);
    let ratio = (base_ior - ior) / (base_ior + ior);
    let bottom = schlick(min(inside, 1.0), ratio * ratio);

    // Reflections between both boundaries, summed without their phases, and the first two terms with them. The extension's code keeps the product
    // above 1e-5, which gives colours to a film of the base's own index. Here such a film has none.
    let both = min(top * bottom, vec3<f32>(0.9999));
    let passed = 1.0 - top;
    let series = passed * passed * bottom / (1.0 - both);
    let difference = 2.0 * ior * thickness * inside;
    let turns = 0.5 + select(vec3<f32>(0.0), vec3<f32>(0.5), base_ior < vec3<f32>(ior));
    let amplitudes = sqrt(both);
    let first = amplitudes * interference(difference, turns);
    let second = both * interference(2.0 * difference, 2.0 * turns);
    let reflected = top + series + 2.0 * (series - passed) * (first + second);
    return clamp(reflected, vec3<f32>(0.0), vec3<f32>(1.0));
}
