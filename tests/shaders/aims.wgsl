//@ use light_path/aims
//@ use light_path/parallel_aims
//@ use sampler/independent
// Where light paths of a light go: directions from a point of it, or rays of a directional light, with their densities.
struct In {
    start: vec3<f32>,
    light: u32,
    // Where a hit on the same point of the light may round it to.
    rounded: vec3<f32>,
    // 0 to draw directions, 1 to draw parallel rays, 2 and 3 for the density of `along`.
    what: u32,
    along: vec3<f32>,
    padding: u32,
}

struct Out {
    // The direction, or the origin of the parallel ray.
    drawn: vec3<f32>,
    density: f32,
    // The density of the same, computed without having drawn it.
    again: f32,
    padding0: f32,
    padding1: f32,
    padding2: f32,
}

fn run(row: u32) {
    let given = input[row / job.times];
    let u = random4(row, 0u, 0u, 1u);
    var out: Out;
    switch given.what {
        case 0u: {
            let aim = aim_from(given.start, given.light, u.x, u.yz);
            out.drawn = aim.direction;
            out.density = aim.pdf;
            out.again = density_of_aim(Ray(given.rounded, aim.direction), given.light);
        }
        case 1u: {
            let aim = aim_parallel(given.along, given.light, u.x, u.yz);
            out.drawn = aim.origin;
            out.density = aim.density;
            out.again = density_of_parallel_aim(Ray(aim.origin, given.along), given.light);
        }
        case 2u: {
            out.density = density_of_aim(Ray(given.start, given.along), given.light);
        }
        default: {
            out.density = density_of_parallel_aim(Ray(given.start, given.along), given.light);
        }
    }
    output[row] = out;
}
