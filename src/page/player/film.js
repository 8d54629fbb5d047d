// The film of the page: the values of pixels, and the error that they state. The arithmetic is that of the host (src/film), sum by sum, so that the
// relative error is the same number.

const DARK_PIXEL_FLOOR = 0.01;
const MOST_ACROSS = 2;
const RELIABLE = 0.1;
const MOST_OF_HALVES = 0.02;
const DEGREES_OF_SAMPLES = 4;
const FEW = 8;
const CONCENTRATION = 4;
const LEAST_SQUARES = 1n << 10n;
const SATURATED = (1n << 127n) - 1n;
const CHANNELS = [0, 1, 2];

export const luminance = ([r, g, b]) => 0.2126 * r + 0.7152 * g + 0.0722 * b;
const saturating = sum => (sum > SATURATED ? SATURATED : sum < -SATURATED - 1n ? -SATURATED - 1n : sum);
const meanOf = (sum, count, unit) => (count === 0 ? 0 : (Number(sum) * unit) / count);

// The index of the pixel at a place in the order of the device (shaders/step/pixel_order.wgsl).
export function pixelInOrder(rank, [width, height], stripRows) {
  const strip = stripRows * width;
  const firstRow = Math.floor(rank / strip) * stripRows;
  const rows = Math.min(stripRows, height - firstRow);
  const within = rank % strip;
  return (firstRow + (within % rows)) * width + Math.floor(within / rows);
}

// The film as the device has it. `totals` are those of the counters.
export class Film {
  constructor(plan, words, totals) {
    Object.assign(this, { ...plan.film, size: plan.size, totals });
    this.unit = 2 ** -this.sum_fraction;
    this.squareUnit = 2 ** -this.square_fraction;
    const pixels = this.size[0] * this.size[1];
    const [even, odd] = totals.light_paths;
    this.lightPaths = this.splats === null ? [0, 0] : [even / pixels, odd / pixels];
    this.allLightPaths = this.lightPaths[0] + this.lightPaths[1];
    this.lamps = this.lamps.map(([pixel, count, lamp, share, mean, square]) =>
      [pixel, Math.fround(count), lamp, Math.fround(share), mean.map(Math.fround), square.map(Math.fround)]);
    this.words = words;
    this.sum64 = new BigUint64Array(2);
    this.sum32 = new Uint32Array(this.sum64.buffer);
    this.ranks = new Uint32Array(pixels);
    for (let rank = 0; rank < pixels; rank++) this.ranks[pixelInOrder(rank, this.size, plan.strip_rows)] = rank;
    this.means = new Float64Array(3 * pixels);
    for (let index = 0; index < pixels; index++) this.means.set(this.pixel(index).means, 3 * index);
  }

  // A pixel's totals, by its index (row 0 on top). They are not kept: integers of 128 bits take much memory.
  pixel(index) {
    const first = (this.ranks[index] * this.bytes) / 4, words = this.words;
    const at = name => first + this.members[name][0] / 4;
    const saturated = words[at("saturated")];
    const sum = number => {
      if ((saturated >>> Math.min(number, 31)) & 1) return SATURATED;
      this.sum32.set(words.subarray(at("sums") + 4 * number, at("sums") + 4 * number + 4));
      return (BigInt.asIntN(64, this.sum64[1]) << 64n) | this.sum64[0];
    };
    const sums = number => CHANNELS.map(c => sum(number + c));
    const evenSum = sums(0), oddSum = sums(3);
    const even = words[at("samples")], odd = words[at("samples") + 1];
    const splats = this.splats === null ? null : [sums(this.splats), sums(this.splats + 3), sums(this.splats + 6)];
    const pixel = {
      sum: CHANNELS.map(c => saturating(evenSum[c] + oddSum[c])),
      oddSum, squares: sums(6), even, odd, samples: even + odd, runs: words[at("runs")], rejected: words[at("rejected")], splats,
    };
    pixel.means = CHANNELS.map(c => meanOf(pixel.sum[c], pixel.samples, this.unit) + this.allSplats(pixel, c));
    return pixel;
  }

  mean(index) {
    return this.means.subarray(3 * index, 3 * index + 3);
  }

  allSplats({ splats }, c) {
    return splats ? meanOf(saturating(splats[0][c] + splats[1][c]), this.allLightPaths, this.unit) : 0;
  }

  splatMean({ splats }, half, c) {
    return splats ? meanOf(splats[half][c], this.lightPaths[half], this.unit) : 0;
  }

  halfMeans(pixel) {
    const { sum, oddSum, even, odd } = pixel;
    return [
      CHANNELS.map(c => meanOf(saturating(sum[c] - oddSum[c]), even, this.unit) + this.splatMean(pixel, 0, c)),
      CHANNELS.map(c => meanOf(oddSum[c], odd, this.unit) + this.splatMean(pixel, 1, c)),
    ];
  }

  // The variance of a pixel's mean, or null if it is not known.
  variance(pixel, c) {
    const sums = [pixel.sum, pixel.squares, ...(pixel.splats ?? [])];
    if (sums.some(sum => sum[c] === SATURATED) || !hasHalves(pixel)) return null;
    return (this.independent ? this.varianceOfSamples(pixel, c) : null) ?? this.varianceOfHalves(pixel, c);
  }

  varianceOfHalves(pixel, c) {
    const { sum, oddSum, even, odd, samples } = pixel;
    const meanOdd = oddSum[c] / BigInt(odd);
    const meanEven = saturating(sum[c] - oddSum[c]) / BigInt(even);
    const ofCamera = Number(meanOdd - meanEven) * this.unit;
    const difference = ofCamera + (this.splatMean(pixel, 1, c) - this.splatMean(pixel, 0, c));
    return (even / samples) * (odd / samples) * difference * difference;
  }

  varianceOfSamples({ squares, runs, samples, splats }, c) {
    const degrees = samples - runs;
    if (degrees <= 0) return null;
    const divisor = degrees * samples;
    const paths = this.allLightPaths;
    const ofSplats = paths === 0 ? 0 : (Number(splats ? splats[2][c] : 0n) * divisor) / (paths * paths);
    const all = Number(squares[c]) + ofSplats;
    return all >= Number(LEAST_SQUARES * BigInt(runs)) ? (all * this.squareUnit) / divisor : null;
  }

  variancesOfSamples(pixel) {
    return CHANNELS.map(c => this.varianceOfSamples(pixel, c) ?? 0);
  }

  degrees(pixel) {
    const known = this.independent && CHANNELS.every(c => this.varianceOfSamples(pixel, c) !== null);
    return known ? pixel.samples - pixel.runs : 1;
  }

  // The relative error, its bound, and whether it is reliable; null if it is not known (Film::error_estimate).
  errorEstimate(level) {
    const pixels = this.ranks.length, width = this.size[0];
    let sum = 0;
    for (let index = 0; index < pixels; index++) sum += luminance(this.mean(index));
    const meanLuminance = sum / pixels;
    if (meanLuminance === 0) return null;
    const floor = DARK_PIXEL_FLOOR * meanLuminance * meanLuminance;
    let total = 0, count = 0;
    const ofHalves = new NoiseSum(), ofBound = new NoiseSum();
    for (let index = 0; index < pixels; index++) {
      const pixel = this.pixel(index);
      if (pixel.rejected > 0 && !hasHalves(pixel)) continue;
      const v = CHANNELS.map(c => this.variance(pixel, c));
      if (v.includes(null)) return null;
      const samples = this.variancesOfSamples(pixel);
      const relative = mean => 1 / (mean * mean + floor);
      const means = this.halfMeans(pixel);
      const mean = CHANNELS.map(c => {
        const alike = means[0][c] < 0 === means[1][c] < 0;
        return alike ? 0.5 * (relative(means[0][c]) + relative(means[1][c])) : 1 / floor;
      });
      const spread = CHANNELS.map(c => Math.sqrt(Math.max(v[c], samples[c])));
      const lone = this.withoutLoneLight(index, width, spread);
      const weights = CHANNELS.map(c => Math.max(mean[c], relative(lone[c])));
      total += weighted(v, pixel.means.map(relative));
      const degrees = this.degrees(pixel);
      ofHalves.add(weighted(v, mean), degrees, weighted(samples, mean));
      ofBound.add(weighted(v, weights), degrees, weighted(samples, weights));
      count++;
    }
    if (count === 0) return null;
    const { missing, excess } = this.errorsOfLamps(floor);
    const error = squares => Math.sqrt(squares / count);
    if (total === 0 && ofHalves.largest.length === 0 && missing === 0) return { value: 0, bound: 0, reliable: true };
    const [, degrees] = ofHalves.bound(level);
    const alike = ofHalves.total <= MOST_ACROSS * MOST_ACROSS * total;
    const known = alike && 0.5 / degrees <= RELIABLE * RELIABLE;
    const bound = Math.max(ofBound.bound(level)[0], total) + missing + excess;
    const reliable = known && total + missing <= MOST_ACROSS * MOST_ACROSS * total;
    return { value: error(total), bound: error(bound), reliable };
  }

  withoutLoneLight(index, width, spread) {
    const row = Math.floor(index / width), column = index % width;
    const brightest = [[0, 0], [0, 0], [0, 0]];
    for (let y = Math.max(row - 1, 0); y <= Math.min(row + 1, this.size[1] - 1); y++) {
      for (let x = Math.max(column - 1, 0); x <= Math.min(column + 1, width - 1); x++) {
        if (x === column && y === row) continue;
        for (const c of CHANNELS) {
          const mean = this.means[3 * (y * width + x) + c], both = brightest[c];
          both[1] = Math.max(both[1], Math.min(mean, both[0]));
          both[0] = Math.max(both[0], mean);
        }
      }
    }
    const means = this.mean(index);
    return CHANNELS.map(c => Math.max(Math.min(means[c], Math.max(brightest[c][1], means[c] - spread[c])), 0));
  }

  // Lamps that too few samples see (src/film/lamps.rs).
  errorsOfLamps(floor) {
    const visible = this.visibleLamps();
    const errors = { missing: 0, excess: 0 };
    for (const [index, count, lamp, share, mean, square] of this.lamps) {
      const pixel = this.pixel(index);
      if (pixel.samples === 0 || share * pixel.samples >= FEW) continue;
      const variances = this.variancesOfSamples(pixel);
      const missing = [0, 0, 0], excess = [0, 0, 0], weights = [0, 0, 0];
      for (const c of CHANNELS) {
        if (square[c] === 0) continue;
        const ofLamp = Math.sqrt(square[c] / share);
        const found = 0.5 - Math.sqrt(0.25 - Math.min((variances[c] * pixel.samples) / (ofLamp * ofLamp), 0.25));
        const rest = Math.max(pixel.means[c] - found * ofLamp, 0);
        const lacks = mean[c] * (1 - found / share);
        if (found < share) missing[c] = lacks * lacks;
        else excess[c] = Math.min(lacks * lacks, 2 * variances[c]);
        weights[c] = 1 / ((mean[c] + rest) * (mean[c] + rest) + floor);
      }
      errors.missing += count * (visible.get(lamp) ?? 1) * weighted(missing, weights);
      errors.excess += count * weighted(excess, weights);
    }
    return errors;
  }

  visibleLamps() {
    const sums = new Map();
    for (const [index, count, lamp, share, , square] of this.lamps) {
      const { samples, means } = this.pixel(index);
      const ofLamp = Math.sqrt(luminance(square) / share);
      const seen = Math.min(Math.max(luminance(means) / ofLamp, 0), 1);
      const [expected, found] = sums.get(lamp) ?? [0, 0];
      sums.set(lamp, [expected + count * samples * share, found + count * samples * seen]);
    }
    const share = ([expected, found]) => Math.min((found + 2 * Math.sqrt(found) + 3) / expected, 1);
    return new Map([...sums].map(([lamp, both]) => [lamp, share(both)]));
  }

  // The stated error, and whether light that the samples may lack makes it unreliable (src/film/verdict.rs).
  verdict(level) {
    let sum = 0;
    for (let index = 0; index < this.ranks.length; index++) sum += Math.max(...this.mean(index));
    const light = (sum / this.ranks.length) * this.totals.paths;
    const share = light > 0 ? 1 / light : 0;
    const unfound = Math.log(1 / level) * this.not_sampled * share;
    const bins = this.totals.light.map(([probed, found]) => [(probed / 16777216) * share, (found / 16777216) * share]);
    const hidden = bins.reduce((all, [probed, found]) => all + Math.max(0.75 * probed - found, 0), 0);
    const error = this.errorEstimate(level);
    if (error === null) return { error: null, bound: null, reliable: null, why: "" };
    const lacks = Math.max(CONCENTRATION * hidden, unfound) > error.bound;
    const why = !error.reliable ? "rare bright paths dominate it" : lacks ? "light may be missing" : "";
    return { error: error.value, bound: error.bound, reliable: error.reliable && !lacks, why };
  }

  // The picture in scene units, row by row: red, green, blue, their variances, and the samples.
  develop() {
    const scale = 2 ** this.exponent, most = 3.4028234663852886e38;
    const limited = value => Math.min(Math.max(Math.fround(value), -most), most);
    const ofVariance = v => (v === null ? most : v === 0 ? 0 : Math.max(limited(v * scale * scale), 1.1754943508222875e-38));
    const pixels = this.ranks.length;
    const picture = { size: this.size, rgb: new Float32Array(3 * pixels), variance: new Float32Array(3 * pixels), samples: new Uint32Array(pixels) };
    for (let index = 0; index < pixels; index++) {
      const pixel = this.pixel(index);
      picture.samples[index] = pixel.samples;
      for (const c of CHANNELS) {
        picture.rgb[3 * index + c] = limited(pixel.means[c] * scale);
        picture.variance[3 * index + c] = ofVariance(this.variance(pixel, c));
      }
    }
    return picture;
  }
}

const hasHalves = pixel => pixel.even > 0 && pixel.odd > 0;
const weighted = (variance, weight) => (variance[0] * weight[0] + variance[1] * weight[1] + variance[2] * weight[2]) / 3;

// The squared relative errors of pixels, summed (src/film/error.rs).
class NoiseSum {
  total = 0;
  variance = 0;
  largest = [];

  add(x, degrees, w) {
    const most = 50;
    const variance = ((2 * degrees) / (degrees + 2)) * x * x;
    this.total += x;
    this.variance += variance;
    if (w > 0 && (this.largest.length < most || w > this.largest.at(-1)[0])) {
      const smaller = this.largest.findIndex(([other]) => other < w);
      this.largest.splice(smaller < 0 ? this.largest.length : smaller, 0, [w, x, variance]);
      this.largest.length = Math.min(this.largest.length, most);
    }
  }

  bound(level) {
    let ofHalves = [this.total, this.variance], ofSamples = [0, 0];
    for (const [w, x, variance] of this.largest) {
      if (w <= MOST_OF_HALVES * (ofSamples[0] + ofHalves[0])) break;
      ofSamples = [ofSamples[0] + w, ofSamples[1] + 2 * w * w];
      ofHalves = [Math.max(ofHalves[0] - x, 0), Math.max(ofHalves[1] - variance, 0)];
    }
    const total = ofSamples[0] + ofHalves[0];
    const degrees = samples => {
      const variance = samples + ofHalves[1];
      return variance > 0 ? Math.max((2 * (total * total - ofHalves[1])) / variance, 0) : Infinity;
    };
    const ofEstimate = degrees(ofSamples[1] / DEGREES_OF_SAMPLES);
    return [total * upperFisher(degrees(ofSamples[1]), ofEstimate, level), ofEstimate];
  }
}

function upperFisher(mu, nu, level) {
  if (!(mu > 0 && nu > 0)) return Infinity;
  const t = Math.sqrt(-2 * Math.log(Math.min(Math.max(level, 1e-300), 0.5)));
  const z = t - (2.515517 + t * (0.802853 + t * 0.010328)) / (1 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
  const a = 2 / (9 * mu), b = 2 / (9 * nu);
  const p = 1 - a, q = 1 - b;
  const divisor = q * q - b * z * z;
  if (q <= 0 || divisor <= 0) return Infinity;
  const root = Math.sqrt(Math.max(p * p * b + q * q * a - a * b * z * z, 0));
  return ((p * q + z * root) / divisor) ** 3;
}

// In a worker: the verdict of a film, or its picture.
if (typeof WorkerGlobalScope !== "undefined") {
  globalThis.onmessage = ({ data: { plan, words, totals, level, develops } }) => {
    const film = new Film(plan, new Uint32Array(words), totals);
    postMessage(develops ? film.develop() : film.verdict(level));
  };
}
