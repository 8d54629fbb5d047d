//@ use bind/bricks
//@ use geometry/slab
//@ use medium/free_flight
//@ use medium/most_steps
//@ relies on loops
// Grids of numbers. A grid is a lattice of tiles of 8 x 8 x 8 bricks of 8 x 8 x 8 cells, which lie between voxels. At its first word it has an
// entry of three words for each tile, x first: the index of the words for the tile's bricks, the least and the largest value. Each brick has such an
// entry with the index of its texels. A tile or brick whose index is 0 has one value everywhere. Indices count from the grid's first word. A brick has
// 9 x 9 x 9 texels, z first, so that neighbours share those on their faces; a texel is a share of the brick's largest value.

const CELLS_OF_BRICK: i32 = 8;
const BRICKS_OF_TILE: i32 = 8;

// A cube of the grid with one bound: a brick, or a tile of one value.
struct GridPart {
    low: vec3<i32>,
    size: i32,
    // The index of its texels, or 0 if all of it has the value `bound`.
    texels: u32,
    // The least value and the largest one.
    least: f32,
    bound: f32,
}

fn part_of_grid(field: ScalarField, brick: vec3<i32>) -> GridPart {
    let tile = brick / BRICKS_OF_TILE;
    let at = vec3<u32>(tile);
    let of_tile = field.first + 3u * (at.x + field.tiles.x * (at.y + field.tiles.y * at.z));
    let of_bricks = bricks[of_tile];
    if of_bricks == 0u {
        let size = CELLS_OF_BRICK * BRICKS_OF_TILE;
        let value = bitcast<f32>(bricks[of_tile + 1u]);
        return GridPart(tile * size, size, 0u, value, value);
    }
    let within = vec3<u32>(brick - tile * BRICKS_OF_TILE);
    let of_brick = field.first + of_bricks + 3u * (within.x + 8u * (within.y + 8u * within.z));
    let texels = bricks[of_brick];
    let least = bitcast<f32>(bricks[of_brick + 1u]);
    let bound = bitcast<f32>(bricks[of_brick + 2u]);
    return GridPart(brick * CELLS_OF_BRICK, CELLS_OF_BRICK, select(0u, field.first + texels, texels != 0u), least, bound);
}

fn texel_of_brick(texels: u32, index: u32) -> f32 {
    let pair = unpack2x16unorm(bricks[texels + index / 2u]);
    return select(pair.x, pair.y, (index & 1u) != 0u);
}

// The value at a position, in voxels, as a share of the part's bound: trilinear.
fn share_in_part(part: GridPart, position: vec3<f32>) -> f32 {
    if part.texels == 0u {
        return 1.0;
    }
    let local = position - vec3<f32>(part.low);
    let cell = clamp(floor(local), vec3<f32>(0.0), vec3<f32>(f32(CELLS_OF_BRICK - 1)));
    let weight = clamp(local - cell, vec3<f32>(0.0), vec3<f32>(1.0));
    let at = vec3<u32>(cell);
    let first = (at.x * 9u + at.y) * 9u + at.z;
    var planes = vec2<f32>(0.0);
    for (var i = 0u; i < 4u; i++) {
        let x = i >> 1u;
        let y = i & 1u;
        let index = first + 81u * x + 9u * y;
        let along_z = mix(texel_of_brick(part.texels, index), texel_of_brick(part.texels, index + 1u), weight.z);
        let share = select(1.0 - weight.y, weight.y, y != 0u) * along_z;
        planes += select(vec2<f32>(share, 0.0), vec2<f32>(0.0, share), x != 0u);
    }
    return mix(planes.x, planes.y, weight.x);
}

fn brick_at(field: ScalarField, position: vec3<f32>) -> vec3<i32> {
    let last = vec3<i32>(field.tiles) * BRICKS_OF_TILE - 1;
    return clamp(vec3<i32>(floor(position / f32(CELLS_OF_BRICK))), vec3<i32>(0), last);
}

// The value at a position in the grid, in voxels.
fn value_in_grid(field: ScalarField, position: vec3<f32>) -> f32 {
    if any(position < field.low) || any(position > field.high) {
        return field.scale * field.outside;
    }
    let part = part_of_grid(field, brick_at(field, position));
    return field.scale * part.bound * share_in_part(part, position);
}

// The way of a ray through a grid, from where it enters.
struct GridWalk {
    // In voxels.
    origin: vec3<f32>,
    direction: vec3<f32>,
    inverse: vec3<f32>,
    // The distances from there at which it is, and at which it leaves.
    t: f32,
    end: f32,
    brick: vec3<i32>,
}

// The part of the interval in which the ray, whose origin and direction are in voxels, is in the grid's box; x = y if there is none.
fn interval_in_grid(field: ScalarField, ray: Ray, inside: vec2<f32>) -> vec2<f32> {
    let crossed = slab(ray.origin, slab_inverse(ray.direction), field.low, field.high);
    let enter = max(max(crossed.enter.x, crossed.enter.y), max(crossed.enter.z, inside.x));
    let leave = min(min(crossed.leave.x, crossed.leave.y), min(crossed.leave.z, inside.y));
    return select(vec2<f32>(inside.y), vec2<f32>(enter, leave), enter < leave);
}

// Distances from the point where the ray enters are small, so that no step in a dense grid is lost.
fn begin_grid_walk(field: ScalarField, ray: Ray, within: vec2<f32>) -> GridWalk {
    let origin = clamp(ray.origin + within.x * ray.direction, field.low, field.high);
    return GridWalk(origin, ray.direction, slab_inverse(ray.direction), 0.0, within.y - within.x, brick_at(field, origin));
}

fn position_of_walk(walk: GridWalk) -> vec3<f32> {
    return walk.origin + walk.t * walk.direction;
}

// The distances at which the ray leaves a part along each axis.
fn ends_of_part(walk: GridWalk, part: GridPart) -> vec3<f32> {
    let sides = part.low + select(vec3<i32>(0), vec3<i32>(part.size), walk.direction >= vec3<f32>(0.0));
    return (vec3<f32>(sides) - walk.origin) * walk.inverse;
}

// The distance at which the ray leaves a part, or the grid.
fn end_of_part(walk: GridWalk, part: GridPart) -> f32 {
    let ends = ends_of_part(walk, part);
    return clamp(min(ends.x, min(ends.y, ends.z)), walk.t, walk.end);
}

// Moves on to the next part. The numbers of bricks are integers and change by each call, so that no rounding can stop the walk.
fn leave_part(walk: ptr<function, GridWalk>, field: ScalarField, part: GridPart) {
    let ends = ends_of_part(*walk, part);
    let nearest = min(ends.x, min(ends.y, ends.z));
    (*walk).t = end_of_part(*walk, part);
    let low = part.low / CELLS_OF_BRICK;
    let high = (part.low + part.size) / CELLS_OF_BRICK;
    let here = vec3<i32>(floor(position_of_walk(*walk) / f32(CELLS_OF_BRICK)));
    let beyond = select(low - 1, high, (*walk).direction >= vec3<f32>(0.0));
    let brick = select(clamp(here, low, high - 1), beyond, ends <= vec3<f32>(nearest));
    if nearest >= (*walk).end || any(brick < vec3<i32>(0)) || any(brick >= vec3<i32>(field.tiles) * BRICKS_OF_TILE) {
        (*walk).t = (*walk).end;
    }
    (*walk).brick = brick;
}

// The distance of the next event in an interval of the ray, whose origin and direction are in voxels, by delta tracking: Woodcock et al.,
// "Techniques used in the GEM code for Monte Carlo neutronics calculations in reactors and other systems of complex geometry", 1965. Tentative
// events come at the rate of each part's bound; one is real with the probability density / bound. NO_HIT if there is no event, or
// WALK_CUT. `words` are random; each tentative event changes them.
fn event_in_grid(
    field: ScalarField,
    ray: Ray,
    inside: vec2<f32>,
    words: ptr<function, vec4<u32>>,
    steps: ptr<function, u32>,
) -> f32 {
    let within = interval_in_grid(field, ray, inside);
    let outside = field.scale * field.outside;
    var left = optical_depth((*words).xy);
    // Before the grid, and behind it, there is one density.
    if left < (within.x - inside.x) * outside {
        return inside.x + left / outside;
    }
    left -= (within.x - inside.x) * outside;
    var walk = begin_grid_walk(field, ray, within);
    while walk.t < walk.end {
        let part = part_of_grid(field, walk.brick);
        let bound = field.scale * part.bound;
        let end = end_of_part(walk, part);
        while left < (end - walk.t) * bound {
            walk.t += left / bound;
            *steps += 1u;
            if unit_of_words((*words).zw) < share_in_part(part, position_of_walk(walk)) {
                return within.x + walk.t;
            }
            if *steps >= MOST_STEPS_OF_CROSSINGS {
                return WALK_CUT;
            }
            *words = pcg4d(*words);
            left = optical_depth((*words).xy);
        }
        left -= (end - walk.t) * bound;
        leave_part(&walk, field, part);
        *steps += 1u;
        if *steps >= MOST_STEPS_OF_CROSSINGS {
            return WALK_CUT;
        }
    }
    let t = within.y + left / outside;
    return select(NO_HIT, t, t < inside.y);
}

// A uniform number in [0, 1) of 64 bits. Small ones keep their precision, so that events are rare where the density is 1e-12 of its bound.
fn unit_of_words(words: vec2<u32>) -> f32 {
    return min(f32(words.x) * 0x1p-32f + f32(words.y) * 0x1p-64f, 0x1.fffffep-1f);
}

// An estimate that falls below this share is ended by roulette, or raised to it.
const LEAST_THROUGH: f32 = 0.125;

// An estimate of the share of light that passes the grid from inside.x to inside.y, by residual ratio tracking: Novak, Selle and Jarosz,
// "Residual ratio tracking for estimating attenuation in participating media", ACM TOG 33(6), 2014. The least density of a part passes exactly what
// it should; tentative events are those of the rest. WALK_CUT if the walk took too many steps.
fn share_through_grid(
    field: ScalarField,
    ray: Ray,
    inside: vec2<f32>,
    words: ptr<function, vec4<u32>>,
    steps: ptr<function, u32>,
) -> f32 {
    let within = interval_in_grid(field, ray, inside);
    var depth = (inside.y - inside.x - (within.y - within.x)) * field.scale * field.outside;
    var through = 1.0;
    var left = optical_depth((*words).xy);
    var walk = begin_grid_walk(field, ray, within);
    while walk.t < walk.end {
        let part = part_of_grid(field, walk.brick);
        let end = end_of_part(walk, part);
        depth += (end - walk.t) * field.scale * part.least;
        let rest = part.bound - part.least;
        let bound = field.scale * rest;
        while left < (end - walk.t) * bound {
            walk.t += left / bound;
            *steps += 1u;
            if *steps >= MOST_STEPS_OF_CROSSINGS {
                return WALK_CUT;
            }
            let share = (share_in_part(part, position_of_walk(walk)) * part.bound - part.least) / rest;
            through *= 1.0 - max(share, 0.0);
            if through < LEAST_THROUGH {
                if !(unit_of_words((*words).zw) * LEAST_THROUGH < through) {
                    return 0.0;
                }
                through = LEAST_THROUGH;
            }
            *words = pcg4d(*words);
            left = optical_depth((*words).xy);
        }
        left -= (end - walk.t) * bound;
        leave_part(&walk, field, part);
        *steps += 1u;
        if *steps >= MOST_STEPS_OF_CROSSINGS {
            return WALK_CUT;
        }
    }
    return through * exp(-depth);
}
