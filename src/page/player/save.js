// The files that a page saves: a PNG with the pixels of `gpu-rt develop`, and an EXR.

const clip = v => Math.min(Math.max(v, 0), 1);
const product = (rows, [a, b, c]) => rows.map(row => row[0] * a + row[1] * b + row[2] * c);
const srgb = linear => (linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055);
const fraction = x => x - Math.floor(x);

function shoulder(peak, start, desaturation) {
  const range = 1 - start;
  const newPeak = 1 - (range * range) / (peak + range - start);
  return [newPeak, 1 - 1 / (desaturation * (peak - newPeak) + 1)];
}

// The curves of src/output/view_transform.rs.
const CURVE = {
  srgb: colour => colour,
  soft(colour) {
    const toCones = [[0.4122214708, 0.5363325363, 0.0514459929], [0.21190349822119037, 0.68069954516807, 0.1073969566107397], [0.0883024619, 0.2817188376, 0.6299787005]];
    const fromCones = [
      [4.076741661347994, -3.307711590077422, 0.23096988872942776],
      [-1.268438004092176, 2.6097574004023953, -0.3413193963102195],
      [-0.0041960865418372, -0.7034186144891075, 1.7076147009309445],
    ];
    const peak = Math.max(...colour);
    if (peak <= 0.8) return colour;
    const [newPeak, white] = shoulder(peak, 0.8, 0.05);
    const roots = product(toCones, colour.map(v => v * (newPeak / peak))).map(Math.cbrt);
    const mixed = product(fromCones, roots.map(root => (root + (Math.cbrt(newPeak) - root) * white) ** 3));
    const mixedPeak = Math.max(...mixed);
    return mixed.map(v => v * (newPeak / mixedPeak));
  },
  neutral(colour) {
    const f90 = 0.04, least = Math.min(...colour);
    const offset = least < 2 * f90 ? least - (least * least) / (4 * f90) : f90;
    const rest = colour.map(v => v - offset), peak = Math.max(...rest);
    if (peak <= 0.8 - f90) return rest;
    const [newPeak, white] = shoulder(peak, 0.8 - f90, 0.15);
    return rest.map(v => v * (newPeak / peak) * (1 - white) + newPeak * white);
  },
  filmic(colour) {
    const into = [[0.59719, 0.35458, 0.04823], [0.076, 0.90834, 0.01566], [0.0284, 0.13383, 0.83777]];
    const out = [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];
    const curve = v => (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.432951) + 0.238081);
    return product(out, product(into, colour).map(curve));
  },
};

// The red, green, blue and alpha of all pixels, in codes.
export function codes({ size: [width], rgb }, { exposure, curve }) {
  const scale = 2 ** exposure, all = new Uint8ClampedArray((rgb.length / 3) * 4).fill(255);
  for (let index = 0; index < rgb.length / 3; index++) {
    const exposed = [0, 1, 2].map(c => Math.max(rgb[3 * index + c] * scale, 0));
    const [x, y] = [(index % width) + 0.5, Math.floor(index / width) + 0.5];
    const threshold = fraction(52.9829189 * fraction(0.06711056 * x + 0.00583715 * y));
    CURVE[curve](exposed).forEach((v, c) => (all[4 * index + c] = Math.floor(255 * srgb(clip(v)) + threshold)));
  }
  return all;
}

export async function png(picture, view) {
  const [width, height] = picture.size;
  const canvas = new OffscreenCanvas(width, height);
  canvas.getContext("2d").putImageData(new ImageData(codes(picture, view), width, height), 0, 0);
  return canvas.convertToBlob({ type: "image/png" });
}

// An OpenEXR file of floats and the numbers of samples, without compression (openexr.com, "OpenEXR File Layout").
export function exr({ size: [width, height], rgb, variance, samples }) {
  const third = (values, c) => index => values[3 * index + c];
  const channels = [
    ["B", third(rgb, 2)], ["G", third(rgb, 1)], ["R", third(rgb, 0)], ["samples.Y", index => samples[index]],
    ["variance.B", third(variance, 2)], ["variance.G", third(variance, 1)], ["variance.R", third(variance, 0)],
  ];
  const text = words => [...new TextEncoder().encode(words), 0];
  const numbers = (type, values) => [...new Uint8Array(type.from(values).buffer)];
  const ints = (...values) => numbers(Int32Array, values), floats = (...values) => numbers(Float32Array, values);
  const attribute = (name, type, bytes) => [...text(name), ...text(type), ...ints(bytes.length), ...bytes];
  const box = ints(0, 0, width - 1, height - 1);
  const isCount = name => name === "samples.Y";
  const list = channels.flatMap(([name]) => [...text(name), ...ints(isCount(name) ? 0 : 2), 0, 0, 0, 0, ...ints(1, 1)]);
  const header = [
    ...ints(20000630, 2),
    ...attribute("channels", "chlist", [...list, 0]),
    ...["compression", "lineOrder"].flatMap(name => attribute(name, name, [0])),
    ...["dataWindow", "displayWindow"].flatMap(name => attribute(name, "box2i", box)),
    ...["pixelAspectRatio", "screenWindowWidth"].flatMap(name => attribute(name, "float", floats(1))),
    ...attribute("screenWindowCenter", "v2f", floats(0, 0)),
    0,
  ];
  const row = 8 + 4 * width * channels.length, first = header.length + 8 * height;
  const file = new DataView(new ArrayBuffer(first + row * height));
  new Uint8Array(file.buffer).set(header);
  for (let y = 0; y < height; y++) {
    const at = first + y * row;
    file.setBigUint64(header.length + 8 * y, BigInt(at), true);
    file.setInt32(at, y, true);
    file.setInt32(at + 4, row - 8, true);
    channels.forEach(([name, value], channel) => {
      const set = (isCount(name) ? file.setUint32 : file.setFloat32).bind(file);
      for (let x = 0; x < width; x++) set(at + 8 + 4 * (channel * width + x), value(y * width + x), true);
    });
  }
  return new Blob([file.buffer], { type: "image/x-exr" });
}

export function download(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}
