// The browser's device: its limits, the numerics probe, the kernels and the buffers.

// A browser, a device or a driver lacks something, which the message names.
export class Lacks extends Error {}

// The least bytes of a buffer: no struct is larger.
const LEAST = 256;

export async function openDevice(plan, gpu = navigator.gpu) {
  const adapter = await gpu?.requestAdapter({ powerPreference: "high-performance" });
  if (!adapter) throw new Lacks("This browser has no WebGPU here.");
  const storage = Math.max(...plan.kernels.map(kernel => kernel.bindings.filter(([, kind]) => kind !== "uniform").length));
  const largest = Math.max(...plan.buffers.filter(buffer => buffer.binding === "storage" && !buffer.per).map(buffer => buffer.bytes));
  const wanted = {
    maxStorageBuffersPerShaderStage: Math.max(storage, 8),
    maxStorageBufferBindingSize: Math.max(largest, 2 ** 27),
    maxBufferSize: Math.max(largest, 2 ** 28),
  };
  for (const [name, least] of Object.entries(wanted)) {
    if (adapter.limits[name] < least) throw new Lacks(`This device has ${adapter.limits[name]} for ${name}, and the scene needs ${least}.`);
  }
  const device = await adapter.requestDevice({ requiredLimits: wanted });
  const info = adapter.info ?? {};
  const isFallback = info.isFallbackAdapter ?? adapter.isFallbackAdapter ?? false;
  return { device, isFallback, name: info.description || [info.vendor, info.architecture].filter(Boolean).join(" ") || "a device" };
}

export function bindGroup(device, pipeline, bindings, buffers) {
  const entries = bindings.map(([binding, , name]) => ({ binding, resource: { buffer: buffers[name] } }));
  return device.createBindGroup({ layout: pipeline.getBindGroupLayout(0), entries });
}

// A kernel, ready to be dispatched.
export async function compile(device, { wgsl, entry, bindings }, constants, buffers) {
  const entries = bindings.map(([binding, type]) => ({ binding, visibility: 4, buffer: { type } }));
  const layout = device.createPipelineLayout({ bindGroupLayouts: [device.createBindGroupLayout({ entries })] });
  const module = device.createShaderModule({ code: wgsl });
  const pipeline = await device.createComputePipelineAsync({ layout, compute: { module, entryPoint: entry, constants } });
  return { pipeline, bindings, group: bindGroup(device, pipeline, bindings, buffers) };
}

export function bufferOf(device, bytes, usage, contents = null) {
  const size = Math.ceil(Math.max(bytes, contents?.length ?? 0, LEAST) / 4) * 4;
  const buffer = device.createBuffer({ size, usage, mappedAtCreation: contents !== null });
  if (contents !== null) {
    new Uint8Array(buffer.getMappedRange()).set(contents);
    buffer.unmap();
  }
  return buffer;
}

export const fromBase64 = text => Uint8Array.from(atob(text), char => char.charCodeAt(0));

// Probes the arithmetic of this driver. The result is the limit on the steps of walks, or 0 for that of the kernels. A property that a kernel relies on and the driver
// lacks is an error (src/gpu/probe.rs).
export async function probe(device, { probe, kernels }) {
  const usage = GPUBufferUsage;
  const bytes = probe.count * probe.answer.bytes;
  const buffers = {
    trials: bufferOf(device, 0, usage.UNIFORM, fromBase64(probe.trials)),
    answers: bufferOf(device, bytes, usage.STORAGE | usage.COPY_SRC),
  };
  const staging = bufferOf(device, bytes, usage.MAP_READ | usage.COPY_DST);
  const { pipeline, group } = await compile(device, { ...probe, entry: "probe" }, { WORKGROUP_SIZE: probe.count }, buffers);
  const encoder = device.createCommandEncoder();
  const pass = encoder.beginComputePass();
  pass.setPipeline(pipeline);
  pass.setBindGroup(0, group);
  pass.dispatchWorkgroups(1);
  pass.end();
  encoder.copyBufferToBuffer(buffers.answers, 0, staging, 0, bytes);
  device.queue.submit([encoder.finish()]);
  await staging.mapAsync(GPUMapMode.READ);
  const answers = new DataView(staging.getMappedRange().slice(0));
  [staging, ...Object.values(buffers)].forEach(buffer => buffer.destroy());
  const at = (trial, member) => trial * probe.answer.bytes + probe.answer.members[member][0];
  let steps = 0;
  for (const { property, without, member, right } of probe.expected) {
    let holds;
    if (right.words) {
      const { mask, words } = right.words;
      holds = words.every((word, trial) => (answers.getUint32(at(trial, member), true) & mask) >>> 0 === word);
    } else if (right.floats) {
      const { error, values } = right.floats;
      holds = values.every((value, trial) => Math.abs(answers.getFloat32(at(trial, member), true) - value) <= error);
    } else {
      const { least, all } = right.loops;
      const done = loopsUntil(answers.getUint32(at(0, member), true), all);
      holds = done >= least;
      if (done >= all) steps = probe.most_steps;
    }
    const relying = kernels.find(kernel => kernel.relies.includes(property));
    if (!holds && relying) throw new Lacks(`This browser's driver ${without}. The kernel ${relying.name} relies on it.`);
  }
  return steps;
}

// The number of steps after which the probe's generator reaches a state (shaders/stage/probe.wgsl).
function loopsUntil(state, all) {
  let reached = 1;
  for (let steps = 0; steps <= all; steps++) {
    if (reached === state) return steps;
    reached = (Math.imul(reached, 1664525) + 1013904223) >>> 0;
  }
  return 0;
}
