// The share of light that single scattering by microfacets keeps (src/material/microfacets.rs), four columns an element. It is no uniform: with
// all other tables, a kernel would have more of those than some drivers allow.
@group(0) @binding(30) var<storage, read> directional_albedos: array<vec4<f32>>;
