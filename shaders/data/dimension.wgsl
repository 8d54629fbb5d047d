// Blocks of four random dimensions, by name. Reserved whether a scene uses them or not, so that no feature shifts
// another's numbers. A bounce owns BLOCKS_PER_EVENT consecutive blocks from FIRST_EVENT on.

const DIMENSION_CAMERA: u32 = 0u; // x, y within the pixel; lens, lens
const DIMENSION_FIRST_BOUNCE: u32 = 1u;
const DIMENSION_BLOCKS_PER_BOUNCE: u32 = 4u;

// The blocks of one scattering event, in this order: direction, light, medium, roulette.
const DIMENSION_SCATTER: u32 = 0u;
const DIMENSION_LIGHT: u32 = 1u;
const DIMENSION_MEDIUM: u32 = 2u;
const DIMENSION_ROULETTE: u32 = 3u;

fn bounce_dimension(event: u32, block: u32) -> u32 {
    return DIMENSION_FIRST_BOUNCE + event * DIMENSION_BLOCKS_PER_BOUNCE + block;
}
