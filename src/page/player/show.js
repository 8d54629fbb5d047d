// The picture: one render pass reads the film's totals, exposes them and draws (src/page/show.wgsl).

export const CURVES = ["soft", "srgb", "neutral", "filmic"];

export class Picture {
  constructor(device, plan, canvas) {
    const format = navigator.gpu.getPreferredCanvasFormat();
    this.context = canvas.getContext("webgpu");
    this.context.configure({ device, format, alphaMode: "opaque" });
    Object.assign(this, { device, plan, canvas });
    const module = device.createShaderModule({ code: plan.show });
    const { members, bytes, splats } = plan.film;
    const constants = {
      PIXEL_WORDS: bytes / 4, SAMPLES_AT: members.samples[0] / 4, SUMS_AT: members.sums[0] / 4, SPLATS: splats ?? 0, STRIP_ROWS: plan.strip_rows,
    };
    this.pipeline = device.createRenderPipeline({
      layout: "auto",
      vertex: { module, entryPoint: "corner", constants },
      fragment: { module, entryPoint: "shade", constants, targets: [{ format }] },
    });
    this.view = device.createBuffer({ size: 32, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
  }

  // Draws a film of this size. `lightPaths` is their number per pixel.
  draw(film, [width, height], lightPaths, { exposure, curve }) {
    const bytes = new ArrayBuffer(32);
    new Uint32Array(bytes).set([width, height, this.canvas.width, this.canvas.height, 0, CURVES.indexOf(curve)]);
    const scale = 2 ** (this.plan.film.exponent + exposure);
    const floats = new Float32Array(bytes);
    [floats[4], floats[6]] = [scale, lightPaths];
    this.device.queue.writeBuffer(this.view, 0, bytes);
    const entries = [this.view, film].map((buffer, binding) => ({ binding, resource: { buffer } }));
    const group = this.device.createBindGroup({ layout: this.pipeline.getBindGroupLayout(0), entries });
    const encoder = this.device.createCommandEncoder();
    const view = this.context.getCurrentTexture().createView();
    const pass = encoder.beginRenderPass({ colorAttachments: [{ view, loadOp: "clear", storeOp: "store" }] });
    pass.setPipeline(this.pipeline);
    pass.setBindGroup(0, group);
    pass.draw(3);
    pass.end();
    this.device.queue.submit([encoder.finish()]);
  }
}
