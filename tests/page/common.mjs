// What the tests of pages share. All of them run on SwiftShader, which Chromium brings: the program by Vulkan, Dawn in node, and the browser, so
// that the same kernels give the same bytes.

import { execFileSync } from "node:child_process";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import zlib from "node:zlib";

export const CHROMIUM = "/usr/bin/chromium";
export const ROOT = path.resolve(import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname), "../..");
const DRIVER = "/usr/lib/chromium/vk_swiftshader_icd.json";
Object.assign(process.env, { VK_DRIVER_FILES: DRIVER, VK_ICD_FILENAMES: DRIVER, NODEVICE_SELECT: "1" });

export const folder = fs.mkdtempSync(path.join(os.tmpdir(), "gpu-rt-page-"));
process.on("exit", () => fs.rmSync(folder, { recursive: true, force: true }));

// Runs the program. The result is what it prints.
export const gpuRt = (...args) => execFileSync("gpu-rt", args, { encoding: "utf8", cwd: ROOT, stdio: ["ignore", "pipe", "pipe"] });

// A page of a scene as a folder, without a picture.
export function pageOf(scene, size, ...more) {
  const to = fs.mkdtempSync(path.join(folder, "page-"));
  gpuRt("page", scene, "-o", to, "--size", size, "--spp", "0", ...more);
  return to;
}

export const planOf = page => JSON.parse(fs.readFileSync(path.join(page, "plan.json"), "utf8"));
export const dataOf = page => new Uint8Array(zlib.gunzipSync(fs.readFileSync(path.join(page, "data.gz"))));

// A render of the program: its EXR, and what it says of it.
export function rendered(scene, size, samples, ...more) {
  const image = path.join(fs.mkdtempSync(path.join(folder, "image-")), "image.exr");
  const said = JSON.parse(gpuRt("render", scene, "--size", size, "--spp", String(samples), "-o", image, "--json", "--quiet", "--no-state", ...more));
  return { image, said };
}

// The channels of an EXR of floats by name, without compression or by zip (openexr.com, "OpenEXR File Layout").
export function readExr(file) {
  const bytes = fs.readFileSync(file);
  let at = 8;
  const text = () => {
    const end = bytes.indexOf(0, at);
    const found = bytes.toString("latin1", at, end);
    at = end + 1;
    return found;
  };
  const header = {};
  for (let name = text(); name !== ""; name = text()) {
    text();
    const length = bytes.readInt32LE(at);
    header[name] = bytes.subarray(at + 4, at + 4 + length);
    at += 4 + length;
  }
  const [width, height] = [8, 12].map(offset => header.dataWindow.readInt32LE(offset) + 1);
  const names = [];
  for (let i = 0; header.channels[i] !== 0; i += 16) {
    const end = header.channels.indexOf(0, i);
    names.push(header.channels.toString("latin1", i, end));
    if (header.channels.readInt32LE(end + 1) > 2) throw new Error("expected floats");
    i = end + 1;
  }
  const rows = { 0: 1, 2: 1, 3: 16 }[header.compression[0]];
  if (rows === undefined) throw new Error(`compression ${header.compression[0]} is not read`);
  const found = Object.fromEntries(names.map(name => [name, new Uint32Array(width * height)]));
  for (let first = 0; first < height; first += rows) {
    const start = Number(bytes.readBigUInt64LE(at + (8 * first) / rows));
    const packed = bytes.subarray(start + 8, start + 8 + bytes.readInt32LE(start + 4));
    const count = Math.min(rows, height - first);
    const whole = 4 * width * names.length * count;
    const block = packed.length === whole ? packed : unpacked(packed);
    for (let y = 0; y < count; y++) {
      names.forEach((name, channel) => {
        for (let x = 0; x < width; x++) found[name][(first + y) * width + x] = block.readUInt32LE(4 * ((y * names.length + channel) * width + x));
      });
    }
  }
  return { width, height, channels: found };
}

function unpacked(packed) {
  const even = zlib.inflateSync(packed);
  for (let i = 1; i < even.length; i++) even[i] = (even[i - 1] + even[i] - 128) & 255;
  const half = Math.ceil(even.length / 2);
  return Buffer.from(even.map((_, i) => even[i % 2 === 0 ? i / 2 : half + (i - 1) / 2]));
}
