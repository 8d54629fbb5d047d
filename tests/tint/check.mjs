// Gives the kernels of a folder to Tint, the WGSL compiler of Dawn and Chrome. It takes no driver: Dawn's null backend compiles nothing further.
import fs from 'node:fs';
import path from 'node:path';
import { create, globals } from 'webgpu';

Object.assign(globalThis, globals);

// Devices end with it.
const gpu = create(['backend=null']);
const adapter = await gpu.requestAdapter();
const device = await adapter.requestDevice();

async function errorsOf(code) {
  device.pushErrorScope('validation');
  const { messages } = await device.createShaderModule({ code }).getCompilationInfo();
  await device.popErrorScope();
  return messages.filter(({ type }) => type === 'error').map(({ lineNum, message }) => `${lineNum}: ${message}`);
}

// What naga takes and the standard forbids.
if ((await errorsOf('const mixed = 1u | 2u << 3u;')).length === 0) {
  throw new Error('a planted error is not found');
}

const folder = process.argv[2];
const kernels = fs.readdirSync(folder, { recursive: true }).filter((name) => name.endsWith('.wgsl'));
let refused = 0;
for (const name of kernels) {
  const errors = await errorsOf(fs.readFileSync(path.join(folder, name), 'utf8'));
  refused += errors.length > 0 ? 1 : 0;
  errors.forEach((error) => console.error(`${name}:${error}`));
}
console.log(`Tint accepts ${kernels.length - refused} of ${kernels.length} kernels`);
process.exit(kernels.length > 0 && refused === 0 ? 0 : 1);
