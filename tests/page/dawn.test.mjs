// The page's pipeline in Dawn: its film and its stated error are those of `gpu-rt render`.

import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { test } from "node:test";
import { create, globals } from "webgpu";

import { ROOT, dataOf, folder, gpuRt, pageOf, planOf, readExr, rendered } from "./common.mjs";

Object.assign(globalThis, globals);
const player = name => import(path.join(ROOT, "src/page/player", name));
const { openDevice } = await player("device.js");
const { Broken, Renderer } = await player("renderer.js");
const { Film } = await player("film.js");
const { exr } = await player("save.js");
const { Camera } = await player("camera.js");
const gpu = create([]);
const LEVEL = 0.05;

async function rendererOf(page) {
  const plan = planOf(page);
  const { device } = await openDevice(plan, gpu);
  const renderer = new Renderer(device, plan, true);
  await renderer.prepare(dataOf(page));
  return renderer;
}

const filmOf = async renderer => new Film(renderer.plan, new Uint32Array(await renderer.film()), renderer.totals);

const differing = (a, b) => a.reduce((count, word, i) => count + (word !== b[i]), a.length === b.length ? 0 : Infinity);

async function saved(film) {
  const file = path.join(fs.mkdtempSync(path.join(folder, "saved-")), "page.exr");
  fs.writeFileSync(file, Buffer.from(await exr(film.develop()).arrayBuffer()));
  return file;
}

// With light paths, media, also of a grid, instances, textures, motion, and tables as uniforms; or all scenes that ship: PAGE_SCENES=all.
const all = () => fs.readdirSync(path.join(ROOT, "scenes")).filter(name => /\.(ron|glb|xml|pbrt)$/.test(name)).map(name => [name, [2]]);
const some = [["cornell.ron", [1, 3]], ["weekend.ron", [4], "--sampler", "independent"], ["motion.ron", [2]], ["window.ron", [2]], ["still-life.glb", [2]], ["cornell-smoke.ron", [2]], ["../tests/references/volumes/blob.ron", [2]]];
for (const [scene, rounds, ...more] of process.env.PAGE_SCENES === "all" ? all() : some) {
  test(`${scene}: the film has the bytes of a render`, async () => {
    const samples = 8 * rounds.reduce((a, b) => a + b);
    const renderer = await rendererOf(pageOf(`scenes/${scene}`, "32x24", ...more));
    renderer.begin(renderer.plan.size, 1 << 20);
    for (const blocks of rounds) await renderer.render(blocks);
    const film = await filmOf(renderer);
    const { image, said } = rendered(`scenes/${scene}`, "32x24", samples, ...more);
    const [own, host] = [readExr(await saved(film)), readExr(image)];
    for (const [name, values] of Object.entries(own.channels)) assert.equal(differing(values, host.channels[name]), 0, name);
    assert.equal(renderer.totals.rays, said.rays);
    const verdict = film.verdict(LEVEL);
    assert.equal(verdict.error, said.relative_error);
    assert.ok(Math.abs(verdict.bound / said.relative_error_bound - 1) < 1e-12, `${verdict.bound} ${said.relative_error_bound}`);
    assert.equal(verdict.reliable, said.reliable);
    // The program reads the file.
    gpuRt("compare", await saved(film), image);
    // Another seed is another image.
    const other = readExr(rendered(`scenes/${scene}`, "32x24", samples, "--seed", "1", ...more).image);
    assert.ok(differing(own.channels.R, other.channels.R) > 0);
    renderer.device.destroy();
  });
}

test("what a stop cuts off is void, and the next image is as if it had not been", async () => {
  const renderer = await rendererOf(pageOf("scenes/cornell.ron", "32x24"));
  const render = async () => {
    renderer.begin(renderer.plan.size, 1 << 20);
    await renderer.render(2);
    return (await filmOf(renderer)).develop();
  };
  const first = await render();
  renderer.begin(renderer.plan.size, 1 << 20);
  await renderer.render(8, () => renderer.stop());
  assert.equal(renderer.done(), 0);
  assert.deepEqual(await render(), first);
  renderer.device.destroy();
});

test("a device that leaves out work is found", async () => {
  const renderer = await rendererOf(pageOf("scenes/cornell.ron", "32x24"));
  renderer.begin(renderer.plan.size, 1 << 20);
  const finish = renderer.finish.bind(renderer);
  // The receipt of a submission that never ran.
  renderer.finish = (flight, kind) => finish({ ...flight, receipt: flight.receipt + 1 }, kind);
  await assert.rejects(renderer.render(1), Broken);
  renderer.device.destroy();
});

test("a driver that lacks what a kernel relies on is refused by name", async () => {
  const plan = planOf(pageOf("scenes/cornell.ron", "8x8"));
  for (const [property, planted] of [
    ["uniforms", right => (right.words.words[3] ^= 1)],
    ["bits", right => (right.words.words[0] ^= 16)],
    ["logarithm", right => (right.floats.error = -1)],
    ["loops", right => (right.loops.least = 1e9)],
  ]) {
    const changed = structuredClone(plan);
    const expected = changed.probe.expected.find(known => known.property === property);
    planted(expected.right);
    changed.kernels[0].relies.push(property);
    const { device } = await openDevice(changed, gpu);
    await assert.rejects(new Renderer(device, changed, true).prepare(new Uint8Array(0)), new RegExp(expected.without.slice(0, 20)));
    device.destroy();
  }
  const needs = structuredClone(plan);
  needs.kernels[0].bindings = Array.from({ length: 99 }, (_, number) => [number, "storage", "film"]);
  await assert.rejects(openDevice(needs, gpu), /maxStorageBuffersPerShaderStage/);
});

// The camera's settings against those of the host for the same view. A scene that stands around the origin, so that lengths are comparable.
test("a hundred cameras have the host's settings", () => {
  const scene = ([x, y, z], [a, b, c]) => `(camera: (look_from: (${x}, ${y}, ${z}), look_at: (${a}, ${b}, ${c}), up: (0.1, 1, 0), vertical_fov: 40, aperture: 0.2, focus_distance: 4),
    image: (width: 64, height: 48), background: Solid((1, 1, 1)), materials: {"m": Lambertian(albedo: Rgb(0.5, 0.5, 0.5))}, objects: [Sphere(center: (0, 0, 0), radius: 1, material: "m")])`;
  const file = path.join(folder, "placed.ron");
  const planAt = (from, to) => {
    fs.writeFileSync(file, scene(from, to));
    return planOf(pageOf(file, "64x48"));
  };
  const vector = (plan, name) => {
    const bytes = Buffer.from(plan.settings.bytes, "base64"), [first, size] = plan.settings.members[name];
    return Array.from({ length: size / 4 }, (_, i) => bytes.readFloatLE(first + 4 * i));
  };
  const [eye, target] = [[3, 2, 5], [0.5, 0, 0]];
  const start = planAt(eye, target);
  const scale = start.camera.distance / Math.hypot(...eye.map((v, i) => v - target[i]));
  let state = 1;
  const random = () => ((state = (state * 48271) % 2147483647) / 2147483647) * 2 - 1;
  for (let number = 0; number < 100; number++) {
    const camera = new Camera(start);
    for (let step = 0; step < 3; step++) {
      camera.orbit(2 * random(), random());
      camera.pan(0.3 * random(), 0.3 * random());
      camera.dolly(Math.exp(0.3 * random()));
    }
    const inScene = place => place.map((v, i) => eye[i] + v / scale);
    const host = planAt(inScene(camera.place), inScene(camera.target()));
    const own = camera.settings(start.size);
    // The host's unit of length depends on the view.
    const hostScale = host.camera.distance / (camera.distance / scale);
    for (const [name, unit] of [["forward", 1], ["pixel_x", 1], ["pixel_y", 1], ["lens_x", hostScale / scale], ["lens_y", hostScale / scale]]) {
      const expected = vector(host, name), largest = Math.max(...expected.map(Math.abs));
      own[name].forEach((v, i) => assert.ok(Math.abs(v * unit - expected[i]) <= 2e-6 * largest, `${number} ${name}: ${own[name]} ${expected}`));
    }
  }
  // At the start they are those of the host, to the bit.
  assert.deepEqual(new Camera(start).settings(start.size), {});
  // One that is turned by a thousandth is another.
  const turned = new Camera(start);
  turned.orbit(0.001, 0);
  assert.ok(Math.abs(turned.settings(start.size).forward[0] - vector(start, "forward")[0]) > 1e-4);
  // It stops where coordinates become too coarse.
  for (let step = 0; step < 100; step++) turned.dolly(2);
  assert.ok(Math.hypot(...turned.place) <= 1000);
});

// The picture from another place is that of a scene whose camera stands there.
test("a moved camera sees what the host sees from there", async () => {
  const page = pageOf("scenes/cornell.ron", "40x40");
  const renderer = await rendererOf(page);
  const camera = new Camera(renderer.plan);
  camera.orbit(0.3, 0.1);
  camera.dolly(0.8);
  const scale = renderer.plan.camera.distance;
  const text = fs.readFileSync(path.join(ROOT, "scenes/cornell.ron"), "utf8");
  const numbers = name => text.match(new RegExp(`${name}: \\(([^)]*)\\)`))[1].split(",").map(Number);
  const [from, to] = [numbers("look_from"), numbers("look_at")];
  const unit = Math.hypot(...from.map((v, i) => v - to[i])) / scale;
  const written = place => `(${place.map((v, i) => from[i] + v * unit).join(", ")})`;
  const moved = path.join(folder, "moved.ron");
  fs.writeFileSync(moved, text.replace(/look_from: \([^)]*\)/, `look_from: ${written(camera.place)}`).replace(/look_at: \([^)]*\)/, `look_at: ${written(camera.target())}`));
  renderer.begin([40, 40], 1 << 20, camera.settings([40, 40]));
  await renderer.render(32);
  const own = (await filmOf(renderer)).develop();
  const host = readExr(rendered(moved, "40x40", 256).image).channels;
  const floats = words => new Float32Array(words.buffer);
  // The same sums but for the rounding of the place, and samples that it moves from one surface to another.
  let [difference, sum, noise] = [0, 0, 0];
  for (const [c, name] of ["R", "G", "B"].entries()) {
    floats(host[name]).forEach((v, i) => {
      difference += own.rgb[3 * i + c] - v;
      sum += v;
      noise += own.variance[3 * i + c];
    });
  }
  assert.ok(Math.abs(difference) < 3 * Math.sqrt(2 * noise) && Math.abs(difference / sum) < 0.01, `${difference} of ${sum}, noise ${Math.sqrt(noise)}`);
  renderer.device.destroy();
});
