// The random dimensions, in blocks of four with names. Every block is reserved whether or not a scene uses it, so no feature
// changes the numbers of another. Each bounce has DIMENSION_BLOCKS_PER_BOUNCE consecutive blocks, from DIMENSION_FIRST_BOUNCE on.

const DIMENSION_CAMERA: u32 = 0u; // two for the point in the pixel, two for the point on the lens
const DIMENSION_TIME: u32 = 0x7fffffffu; // one for the time, behind all bounces
const DIMENSION_FIRST_BOUNCE: u32 = 1u;
const DIMENSION_BLOCKS_PER_BOUNCE: u32 = 4u;

// The blocks of one scattering event, in order: direction, light, medium, roulette.
const DIMENSION_SCATTER: u32 = 0u;
const DIMENSION_LIGHT: u32 = 1u;
const DIMENSION_MEDIUM: u32 = 2u;
const DIMENSION_ROULETTE: u32 = 3u;

// Light paths: two blocks for the emission, and their events are numbered from here on. So their blocks begin at 2^31, where no camera path
// has one.
const DIMENSION_EMISSION: u32 = 0x80000000u; // the light, the bound that it is aimed at, and two for the point
const DIMENSION_EMITTED_DIRECTION: u32 = 0xc0000000u; // two for the direction
const FIRST_LIGHT_EVENT: u32 = 0x20000000u;

// The samples that dispersion lets follow the channel c have blocks of their own: the bits above this one hold c + 1. No path has 2^27 events.
const DIMENSION_CHANNEL_BIT: u32 = 29u;

fn bounce_dimension(event: u32, block: u32) -> u32 {
    return DIMENSION_FIRST_BOUNCE + event * DIMENSION_BLOCKS_PER_BOUNCE + block;
}
