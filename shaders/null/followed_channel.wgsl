//@ use data/material
//@ use data/path
// No surface has dispersion.
fn follow_channel(path: ptr<function, Path>, evaluated: EvaluatedMaterial) -> EvaluatedMaterial {
    return evaluated;
}
