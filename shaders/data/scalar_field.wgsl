// A number that varies in space. The densities of the media come first, in the order of the media, then their temperatures.
struct ScalarField {
    // Rows for the offset from the medium's own point, with a 1 behind it. They give the position in a grid, in voxels; for a
    // density by height, `x` gives the logarithm of the density.
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
    // The radiance of what absorbs light in the medium; with a temperature, the factor of a black body's radiance, which is in W / (m^2 sr nm).
    emission: vec3<f32>,
    // How the density varies: the number of its file, counted from 1; 0 if it does not.
    kind: u32,
    // The corners of the box that the grid fills, in voxels.
    low: vec3<f32>,
    // The grid's first word among those of all grids (medium/grid).
    first: u32,
    high: vec3<f32>,
    // The value outside of the box, in the grid's unit.
    outside: f32,
    // The number of tiles of the grid along each axis.
    tiles: vec3<u32>,
    // The index of the field of the medium's temperature, or NO_FIELD.
    temperature: u32,
    // The factor of the grid's values.
    scale: f32,
    // The first word of the table of black bodies (scene/heat).
    heat: u32,
    padding0: u32,
    padding1: u32,
}

const NO_FIELD: u32 = 0xffffffffu;
