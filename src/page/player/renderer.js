// The pipeline: generate, then bounces of intersect, scatter, shadow and refill, and accumulate; light paths after the camera paths of a round
// (src/render.rs).

import { bindGroup, bufferOf, compile, fromBase64, probe } from "./device.js";

// The time that a submission should take, in milliseconds, and how many are in flight.
const SUBMISSION = 25;
const IN_FLIGHT = 2;
// The least work of a submission, in slots times bounces.
const LEAST_WORK = 1024;
// The slots of a device that computes on the processor.
const SLOTS_OF_FALLBACK = 4096;
const LEAST_SLOTS = 16384;

// The device did not do its work, so that the image is lost.
export class Broken extends Error {}

export class Renderer {
  constructor(device, plan, isFallback) {
    const [width, height] = plan.size;
    const slots = isFallback ? SLOTS_OF_FALLBACK : Math.max(width * height, LEAST_SLOTS);
    Object.assign(this, { device, plan, slots: Math.min(slots, plan.slots) });
    this.paces = { camera: { work: LEAST_WORK, last: 0 }, light: { work: LEAST_WORK, last: 0 } };
    this.receipt = 0;
  }

  // Probes the device, fills its buffers and compiles the kernels. `told` follows with the number of kernels that are ready.
  async prepare(data, told = () => {}) {
    const { device, plan, slots } = this;
    const steps = await probe(device, plan);
    const { STORAGE, UNIFORM, COPY_SRC, COPY_DST, MAP_READ } = GPUBufferUsage;
    const count = { slot: slots, pixel: plan.size[0] * plan.size[1], "": 1 };
    this.buffers = {};
    for (const { name, binding, per, bytes, contents } of plan.buffers) {
      const usage = (binding === "uniform" ? UNIFORM : STORAGE | COPY_SRC) | COPY_DST;
      const [first, length] = contents ?? [0, 0];
      this.buffers[name] = bufferOf(device, bytes * count[per], usage, contents ? data.subarray(first, first + length) : null);
    }
    const bytes = this.buffers.counters.size;
    this.readings = Array.from({ length: IN_FLIGHT }, () => bufferOf(device, bytes, MAP_READ | COPY_DST));
    let ready = 0;
    const one = async kernel => {
      const ofSteps = Object.fromEntries((steps ? kernel.steps : []).map(name => [name, steps]));
      const made = await compile(device, kernel, { WORKGROUP_SIZE: plan.workgroup, ...ofSteps }, this.buffers);
      told(++ready, plan.kernels.length);
      return [kernel.name, made];
    };
    this.kernels = Object.fromEntries(await Promise.all(plan.kernels.map(one)));
  }

  // Writes a member of the settings: a number, or the components of a vector.
  set(name, value) {
    const [first] = this.plan.settings.members[name] ?? [];
    if (first === undefined) return;
    for (const [i, number] of [value].flat().entries()) {
      if (Array.isArray(value)) this.settings.setFloat32(first + 4 * i, number, true);
      else this.settings.setUint32(first, number, true);
    }
  }

  // Makes room for a film of so many pixels.
  grow(pixels) {
    const { device, buffers, kernels } = this, bytes = pixels * this.plan.film.bytes;
    if (bytes <= buffers.film.size) return;
    buffers.film.destroy();
    buffers.film = bufferOf(device, bytes, buffers.film.usage);
    for (const kernel of Object.values(kernels)) kernel.group = bindGroup(device, kernel.pipeline, kernel.bindings, buffers);
  }

  // Begins an image of this size with so many samples of a pixel at most. `members` are those of the settings that the camera has.
  begin([width, height], samples, members = {}) {
    Object.assign(this, { size: [width, height], pixels: width * height, samples, blocks: 0 });
    this.grow(this.pixels);
    this.settings = new DataView(fromBase64(this.plan.settings.bytes).buffer);
    const sizes = { image_width: width, image_height: height, film_width: width, film_height: height };
    Object.entries({ ...sizes, slots: this.slots, end_sample: samples, ...members }).forEach(([name, value]) => this.set(name, value));
    this.device.queue.writeBuffer(this.buffers.settings, 0, this.settings.buffer);
    const encoder = this.device.createCommandEncoder();
    encoder.clearBuffer(this.buffers.film);
    this.device.queue.submit([encoder.finish()]);
    const { light_bins } = this.plan.counters;
    this.totals = { paths: 0, rays: 0, too_deep_throughput: 0, rejected: 0, light_paths: [0, 0], light: Array.from({ length: light_bins }, () => [0, 0]) };
    this.stopped = false;
  }

  // The samples that each pixel has.
  done() {
    return Math.min(this.blocks * this.plan.run_length, this.samples);
  }

  // Renders the next blocks of samples of every pixel, and their light paths. `turn` is called after each submission. After `stop()` the image is void.
  async render(blocks, turn = () => {}) {
    const runs = this.plan.run_length;
    const samples = Math.min((this.blocks + blocks) * runs, this.samples) - this.done();
    const traced = () => this.totals.light_paths[0] + this.totals.light_paths[1];
    const before = [this.totals.paths, traced()];
    await this.window("camera", blocks, this.pixels, turn);
    if (this.kernels.light_path !== undefined) {
      await this.window("light", blocks, this.pixels * this.plan.light_paths, turn);
    }
    if (this.stopped) return;
    // A run that is cut short has fewer light paths than others.
    const expected = this.kernels.light_path === undefined ? 0 : blocks * this.pixels * this.plan.light_paths;
    const isRight = traced() - before[1] === expected || samples < blocks * runs;
    if (this.totals.paths - before[0] !== samples * this.pixels || !isRight) throw new Broken("the device has left out paths");
    this.blocks += blocks;
  }

  stop() {
    this.stopped = true;
  }

  // Paths of a kind until every slot is idle, so many runs of each block.
  async window(kind, blocks, runsOfBlock, turn) {
    const { device, slots } = this;
    const window = { first_block: this.blocks, end: blocks * runsOfBlock, first_pixel: 0, pixels: this.pixels, begins: 1, first_slot: 0, end_slot: 0 };
    device.queue.writeBuffer(this.buffers.counters, 0, new Uint8Array(this.buffers.counters.size));
    const flights = [];
    let counters = { next: 0, idle: 0 }, submitted = 0;
    for (;;) {
      const wanted = Math.max(counters.next, slots) < window.end ? IN_FLIGHT : 1;
      while (counters.idle < slots && !this.stopped && flights.length < wanted) flights.push(this.submit(window, submitted++, kind));
      if (flights.length === 0) break;
      counters = await this.finish(flights.shift(), kind);
      turn();
    }
    if (!this.stopped) this.add(counters);
  }

  // Records and submits a pass over the next slots.
  submit(window, number, kind) {
    const { device, plan, slots, buffers, kernels } = this;
    if (window.end_slot === slots) Object.assign(window, { end_slot: 0, begins: 0 });
    const left = slots - window.end_slot, pace = this.paces[kind];
    const part = Math.ceil(left / Math.max(Math.ceil(left / pace.work), 1));
    const most = kind === "camera" ? (plan.records_per_slot - 1) * Math.min(plan.run_length, this.samples) : 0xffffffff;
    const bounces = Math.min(Math.max(Math.floor(pace.work / slots), 1), most);
    this.receipt = (this.receipt % 0xffffffff) + 1;
    Object.assign(window, { first_slot: window.end_slot, end_slot: window.end_slot + part, bounces, receipt: this.receipt });
    const bytes = new DataView(new ArrayBuffer(plan.window.bytes));
    Object.entries(plan.window.members).forEach(([name, [first]]) => bytes.setUint32(first, window[name], true));
    device.queue.writeBuffer(buffers.window, 0, bytes.buffer);
    const { generate, bounce, light_path, accumulate, receipt } = plan.stages;
    const first = window.begins ? [generate] : [];
    const camera = () => [...first, ...Array.from({ length: bounces }, () => bounce).flat(), accumulate];
    const stages = [...(kind === "camera" ? camera() : [light_path]), receipt];
    const encoder = device.createCommandEncoder();
    const pass = encoder.beginComputePass();
    for (const name of stages) {
      const { pipeline, group } = kernels[name];
      pass.setPipeline(pipeline);
      pass.setBindGroup(0, group);
      pass.dispatchWorkgroups(name === receipt ? 1 : Math.ceil(part / plan.workgroup));
    }
    pass.end();
    const reading = this.readings[number % IN_FLIGHT];
    encoder.clearBuffer(buffers.counters, plan.counters.members.records[0], 4);
    encoder.copyBufferToBuffer(buffers.counters, 0, reading, 0, buffers.counters.size);
    device.queue.submit([encoder.finish()]);
    return { reading, receipt: this.receipt, begun: window.begins ? window.end_slot : slots, work: part * bounces, begin: performance.now() };
  }

  // Waits for a submission, and adapts the work of the next one to its time.
  async finish({ reading, receipt, begun, work, begin }, kind) {
    await reading.mapAsync(GPUMapMode.READ);
    const view = new DataView(reading.getMappedRange().slice(0));
    reading.unmap();
    const member = name => view.getUint32(this.plan.counters.members[name][0], true);
    if (member("receipt") !== receipt || member("next") < begun) throw new Broken("the device has given up its work");
    const pace = this.paces[kind], now = performance.now();
    const ratio = SUBMISSION / Math.max(now - Math.max(begin, pace.last), 1e-3);
    pace.work = Math.max(Math.floor(work * Math.min(Math.max(ratio, 0.25), 4)), LEAST_WORK);
    pace.last = now;
    return { view, next: member("next"), idle: member("idle") };
  }

  // Adds the counters of a window to the totals.
  add({ view }) {
    const { members, counts, light_bins } = this.plan.counters, { totals } = this;
    const wide = at => view.getUint32(at, true) + 2 ** 32 * view.getUint32(at + 4, true);
    const count = number => wide(members.counts[0] + 8 * number);
    totals.paths += count(counts.paths);
    totals.rays += count(counts.rays);
    totals.too_deep_throughput += count(counts.too_deep_throughput);
    for (const half of [0, 1]) totals.light_paths[half] += count(counts.light_paths + half);
    for (const name of ["nan", "infinite", "cut", "refused"]) totals.rejected += view.getUint32(members[name][0], true);
    for (let bin = 0; members.light && bin < light_bins; bin++) {
      for (const of of [0, 1]) totals.light[bin][of] += wide(members.light[0] + 16 * bin + 8 * of);
    }
  }

  // The words of the film, as the device has them.
  async film() {
    const { device, plan } = this;
    const bytes = this.pixels * plan.film.bytes;
    const staging = bufferOf(device, bytes, GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST);
    const encoder = device.createCommandEncoder();
    encoder.copyBufferToBuffer(this.buffers.film, 0, staging, 0, bytes);
    device.queue.submit([encoder.finish()]);
    await staging.mapAsync(GPUMapMode.READ);
    const words = staging.getMappedRange().slice(0, bytes);
    staging.destroy();
    return words;
  }
}
