//@ use data/path
// There is no surface to hit.
const ITERATIONS_OF_SHADING: u32 = 0u;

fn scatter_path(path: ptr<function, Path>) {
}
