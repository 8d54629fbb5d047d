//@ use scene/directional_albedo
// The share of light that single scattering by microfacets keeps, by the table.
@group(0) @binding(21) var<storage, read> input: array<vec2<f32>>;
@group(0) @binding(22) var<storage, read_write> output: array<f32>;

fn run(row: u32) {
    output[row] = directional_albedo(input[row].x, input[row].y);
}
