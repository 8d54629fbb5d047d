// `Path` is the state of a path, and of the run that its sample belongs to. The plan generates it from its table of fields,
// which describes each (src/plan/state.rs). `status` is the code of the primitive that the ray hit, or what the path is doing
// (data/primitive); once the path has ended, `throughput` holds its radiance. `pdf` is that of the ray's direction by the last event, and 0 for
// camera rays and in specular lobes. `light` is the code of the shadow ray's light, or NO_LIGHT. `aov` has the sums of `--aov` over the
// samples of the run.

// Light that reaches the camera by fewer scattering events is direct.
const INDIRECT_FROM: u32 = 2u;

// Stands for a light's code if there is no shadow ray.
const NO_LIGHT: u32 = 0xfffffff9u;

// The hit of the path's ray.
fn path_hit(path: ptr<function, Path>) -> Hit {
    var hit = hit_at((*path).status, (*path).t);
    hit.instance = (*path).instance;
    return hit;
}
