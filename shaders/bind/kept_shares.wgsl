// The share of light that single scattering by microfacets keeps (src/material/microfacets.rs), four columns an element. It is small enough
// for a uniform on every device.
@group(0) @binding(30) var<uniform> kept_shares: array<vec4<f32>, 256>;
