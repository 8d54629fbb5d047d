// The picture of a page: one render pass reads the film's totals, exposes them and draws. The curves are those of the host
// (src/output/view_transform.rs), in f32.

// The layout of the film in words: those of a pixel, and where its samples and its sums are. The number of the first sum of splats, or 0.
override PIXEL_WORDS: u32;
override SAMPLES_AT: u32;
override SUMS_AT: u32;
override SPLATS: u32;
override STRIP_ROWS: u32;

struct View {
    size: vec2<u32>,
    canvas: vec2<u32>,
    exposure: f32,
    curve: u32,
    light_paths: f32,
}
@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> film: array<u32>;

@vertex
fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn rank_of(x: u32, y: u32) -> u32 {
    let first = y / STRIP_ROWS * STRIP_ROWS;
    let rows = min(STRIP_ROWS, view.size.y - first);
    return first * view.size.x + x * rows + (y - first);
}

// A sum of 128 bits.
fn sum(first: u32) -> f32 {
    var words = vec4<u32>(film[first], film[first + 1u], film[first + 2u], film[first + 3u]);
    let negative = words.w >> 31u == 1u;
    if negative {
        words = ~words;
    }
    let value = dot(vec4<f32>(words), vec4<f32>(0x1p-88f, 0x1p-56f, 0x1p-24f, 0x1p8f));
    return select(value, -value, negative);
}

fn sums(pixel: u32, number: u32) -> vec3<f32> {
    let first = pixel + SUMS_AT + 4u * number;
    return vec3<f32>(sum(first), sum(first + 4u), sum(first + 8u));
}

fn radiance(pixel: u32) -> vec3<f32> {
    let at = pixel + SAMPLES_AT;
    let samples = f32(film[at] + film[at + 1u]);
    var mean = (sums(pixel, 0u) + sums(pixel, 3u)) / max(samples, 1.0);
    if SPLATS > 0u {
        mean += (sums(pixel, SPLATS) + sums(pixel, SPLATS + 3u)) / view.light_paths;
    }
    return mean;
}

fn shoulder(peak: f32, start: f32, desaturation: f32) -> vec2<f32> {
    let range = 1.0 - start;
    let new_peak = 1.0 - range * range / (peak + range - start);
    return vec2<f32>(new_peak, 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0));
}

fn largest(v: vec3<f32>) -> f32 {
    return max(v.x, max(v.y, v.z));
}

fn soft(colour: vec3<f32>) -> vec3<f32> {
    let peak = largest(colour);
    if peak <= 0.8 {
        return colour;
    }
    let to_cones = mat3x3<f32>(0.4122214708, 0.2119034982, 0.0883024619, 0.5363325363, 0.6806995452, 0.2817188376, 0.0514459929, 0.1073969566, 0.6299787005);
    let from_cones = mat3x3<f32>(4.0767416614, -1.2684380041, -0.0041960861, -3.3077115901, 2.6097574004, -0.7034186144, 0.2309698887, -0.3413193963, 1.7076147009);
    let bent = shoulder(peak, 0.8, 0.05);
    let roots = pow(to_cones * (colour * (bent.x / peak)), vec3<f32>(1.0 / 3.0));
    let mixed_roots = roots + (pow(bent.x, 1.0 / 3.0) - roots) * bent.y;
    let mixed = from_cones * (mixed_roots * mixed_roots * mixed_roots);
    return mixed * (bent.x / largest(mixed));
}

fn neutral(colour: vec3<f32>) -> vec3<f32> {
    let least = min(colour.x, min(colour.y, colour.z));
    let rest = colour - select(0.04, least - least * least / 0.16, least < 0.08);
    let peak = largest(rest);
    if peak <= 0.76 {
        return rest;
    }
    let bent = shoulder(peak, 0.76, 0.15);
    return rest * (bent.x / peak) * (1.0 - bent.y) + bent.x * bent.y;
}

fn filmic(colour: vec3<f32>) -> vec3<f32> {
    let into = mat3x3<f32>(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
    let out = mat3x3<f32>(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602);
    let v = into * colour;
    return out * ((v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081));
}

@fragment
fn shade(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let at = vec2<u32>(position.xy) * view.size / view.canvas;
    let pixel = rank_of(at.x, at.y) * PIXEL_WORDS;
    let exposed = clamp(radiance(pixel) * view.exposure, vec3<f32>(0.0), vec3<f32>(1e6));
    var shown = exposed;
    switch view.curve {
        case 0u: { shown = soft(exposed); }
        case 2u: { shown = neutral(exposed); }
        case 3u: { shown = filmic(exposed); }
        default: {}
    }
    let v = clamp(shown, vec3<f32>(0.0), vec3<f32>(1.0));
    let coded = select(1.055 * pow(v, vec3<f32>(1.0 / 2.4)) - 0.055, 12.92 * v, v <= vec3<f32>(0.0031308));
    let threshold = fract(52.9829189 * fract(dot(vec2<f32>(0.06711056, 0.00583715), position.xy)));
    return vec4<f32>(floor(255.0 * coded + threshold) / 255.0, 1.0);
}
