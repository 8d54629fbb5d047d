//@ use scene/directional_albedo
// The share of light that single scattering by microfacets keeps, by the table.
alias In = vec2<f32>;
alias Out = f32;

fn run(row: u32) {
    output[row] = directional_albedo(input[row].x, input[row].y);
}
