// The page: loads the scene, renders it block by block, and shows its figures.

import { Lacks, fromBase64, openDevice } from "./device.js";
import { Camera } from "./camera.js";
import { Broken, Renderer } from "./renderer.js";
import { CURVES, Picture } from "./show.js";
import { download, exr, png } from "./save.js";
import { control } from "./controls.js";

const SAMPLES = 2 ** 20;
// The probability that the error is above its bound.
const LEVEL = 0.05;
// A round should take so long, in milliseconds, and the camera rests after that time without a step.
const ROUND = [250, 1000];
const REST = 250;
const MOST_ATTEMPTS = 4;
// The bytes of a binding that every device has.
const FILM_BYTES = 2 ** 27;

const element = id => document.getElementById(id);
const tell = words => (element("message").textContent = words);
const percent = share => (share < 0.0001 ? "below 0.01 %" : share < 1 ? `${(100 * share).toPrecision(3)} %` : "not known");
const wait = milliseconds => new Promise(done => setTimeout(done, milliseconds));

async function load() {
  const inline = element("plan");
  const bytes = inline ? fromBase64(element("data").textContent) : await (await fetch("data.gz")).arrayBuffer();
  const plan = inline ? JSON.parse(inline.textContent) : await (await fetch("plan.json")).json();
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return { plan, data: new Uint8Array(await new Response(stream).arrayBuffer()) };
}

// Answers about films, by a worker: their verdict, or their picture.
class Estimator {
  constructor() {
    const text = element("worker")?.textContent;
    const url = text ? URL.createObjectURL(new Blob([text], { type: "text/javascript" })) : new URL("film.js", import.meta.url);
    this.worker = new Worker(url, { type: text ? "classic" : "module" });
    this.last = Promise.resolve();
  }

  ask(question, words) {
    const answer = () => new Promise((done, fail) => {
      Object.assign(this.worker, { onmessage: ({ data }) => done(data), onerror: fail });
      this.worker.postMessage({ ...question, words, level: LEVEL }, [words]);
    });
    return (this.last = this.last.then(answer));
  }
}

class Player {
  constructor(plan, data) {
    Object.assign(this, { plan, data, slots: Infinity, view: { exposure: 0, curve: CURVES[0] }, paused: false, version: 0, lastStep: -Infinity, saves: [] });
    this.camera = plan.camera && new Camera(plan);
    this.estimator = new Estimator();
    this.listen();
  }

  listen() {
    const changed = () => {
      this.lastStep = performance.now();
      this.version++;
      this.renderer?.stop();
    };
    if (this.camera) control(element("view"), this.camera, changed);
    addEventListener("resize", () => this.size && String(this.size) !== String(this.sizeOfView()) && changed());
    element("reset").hidden = !this.camera;
    element("reset").onclick = () => changed(this.camera.reset());
    element("pause").onclick = () => {
      this.paused = !this.paused;
      element("pause").textContent = this.paused ? "Go on" : "Pause";
      element("pause").setAttribute("aria-pressed", this.paused);
    };
    element("curve").append(...CURVES.map(curve => new Option(curve)));
    const look = () => {
      this.view = { exposure: Number(element("exposure").value), curve: element("curve").value };
      this.draw();
    };
    element("exposure").oninput = element("curve").onchange = look;
    for (const kind of ["png", "exr"]) element(kind).onclick = () => this.saves.push(kind);
    element("controls").onsubmit = event => event.preventDefault();
    document.addEventListener("visibilitychange", () => this.draw());
  }

  // The size of the image: that of the view, with the scene's proportions, where the film has room for it.
  sizeOfView() {
    const { plan } = this;
    if (plan.fixed || !plan.camera?.scales) return plan.size;
    const { clientWidth } = element("stage"), ratio = this.isFallback ? 1 : Math.min(devicePixelRatio, 2);
    const fits = ratio * Math.min(clientWidth / plan.size[0], (0.78 * innerHeight) / plan.size[1]);
    const room = Math.sqrt(FILM_BYTES / plan.film.bytes / (plan.size[0] * plan.size[1]));
    return plan.size.map(side => Math.max(Math.floor(side * Math.min(fits, room)), 1));
  }

  // Opens a device and renders with it. Returns only when the device is lost, why.
  async attempt() {
    const { device, isFallback, name } = await openDevice(this.plan);
    this.lost = device.lost.then(({ message }) => message || "no reason is known");
    this.isFallback = isFallback;
    const renderer = new Renderer(device, this.plan, isFallback);
    renderer.slots = Math.min(renderer.slots, this.slots);
    const rendering = async () => {
      await renderer.prepare(this.data, (ready, all) => tell(`Compiling: ${ready} of ${all} kernels`));
      this.picture = new Picture(device, this.plan, element("view"));
      tell(`Rendering on ${name}.`);
      [element("view").hidden, element("figures").hidden, element("controls").hidden] = [false, false, false];
      this.renderer = renderer;
      await this.run(renderer);
    };
    try {
      return await Promise.race([rendering(), this.lost]);
    } catch (error) {
      // If it fails because the device is lost, the device says so a moment later.
      const lost = await Promise.race([this.lost, wait(1000)]);
      if (lost === undefined && !(error instanceof Broken)) throw error;
      device.destroy();
      return lost ?? error.message;
    } finally {
      this.slots = Math.max(Math.floor(renderer.slots / 2), 1024);
      this.renderer = null;
      this.version++;
    }
  }

  async run(renderer) {
    for (const canvas = element("view"); ; ) {
      const version = this.version;
      this.size = this.sizeOfView();
      // To set its size, even to what it is, makes a canvas black.
      if (String([canvas.width, canvas.height]) !== String(this.size)) [canvas.width, canvas.height] = this.size;
      if (performance.now() - this.lastStep < REST) await this.move(renderer);
      else await this.rest(renderer, version);
    }
  }

  // While the camera moves: one sample of few pixels.
  async move(renderer) {
    const size = this.plan.camera?.scales ? this.size.map(side => Math.ceil(side / 2)) : this.size;
    renderer.begin(size, 1, this.camera?.settings(size));
    await renderer.render(1);
    if (renderer.blocks > 0) this.shown([0, 0], size);
    this.figures("moving", null);
    await wait(0);
  }

  // While it rests: blocks of samples, and the error at 16, 32, 64 … samples, until the camera moves.
  async rest(renderer, version) {
    const { size } = this;
    renderer.begin(size, SAMPLES, this.camera?.settings(size));
    let [blocks, check, verdict] = [1, 2, null];
    const begin = performance.now();
    let idle = 0;
    while (version === this.version) {
      const from = performance.now();
      await this.free(() => version !== this.version);
      // All samples have been rendered.
      if (renderer.done() === SAMPLES && this.saves.length === 0) await wait(100);
      idle += performance.now() - from;
      if (version !== this.version) return;
      if (this.saves.length > 0 && renderer.blocks > 0) {
        await this.save(renderer, this.saves.shift());
        continue;
      }
      if (renderer.done() === SAMPLES) continue;
      const round = performance.now();
      let drawn = 0;
      await renderer.render(Math.min(blocks, check - renderer.blocks), () => {
        // A picture ahead of its figures. The first block would be drawn over the last picture.
        if (renderer.blocks > 0 && performance.now() - drawn > 50) {
          element("samples").textContent = `${renderer.done()} per pixel, the picture is ahead`;
          this.shown(renderer.totals.light_paths, size);
          drawn = performance.now();
        }
      });
      if (version !== this.version) return;
      const took = performance.now() - round;
      blocks = took < ROUND[0] ? 2 * blocks : took > ROUND[1] ? Math.max(blocks >> 1, 1) : blocks;
      this.shown(renderer.totals.light_paths, size);
      if (renderer.blocks === check) {
        check *= 2;
        verdict = { ...(await this.ask(renderer, false)), samples: renderer.done() };
        if (version !== this.version) return;
      }
      const seconds = (performance.now() - begin - idle) / 1000;
      this.figures(`${renderer.done()} per pixel`, verdict, renderer.totals.paths / seconds);
    }
  }

  // Gives the browser a moment, and waits while the page is hidden or paused, unless the camera moves.
  async free(until = () => false) {
    await wait(0);
    while ((document.hidden || this.paused) && !until() && this.saves.length === 0) await wait(50);
  }

  shown(lightPaths, size) {
    const pixels = size[0] * size[1];
    this.last = [size, (lightPaths[0] + lightPaths[1]) / pixels];
    element("still").hidden = true;
    this.draw();
  }

  draw() {
    if (this.last && this.renderer && !document.hidden) this.picture.draw(this.renderer.buffers.film, ...this.last, this.view);
  }

  figures(samples, verdict, pace = null) {
    element("samples").textContent = samples;
    const known = verdict !== null && verdict.error !== null;
    element("error").textContent = known ? `${percent(verdict.error)}, at most ${percent(verdict.bound)} (95 %), at ${verdict.samples} samples` : "not yet known";
    element("verdict").textContent = known ? (verdict.reliable ? "reliable" : `not reliable: ${verdict.why}`) : "none yet";
    element("pace").textContent = pace === null ? "" : `${(pace / 1e6).toPrecision(3)} million paths/s`;
    Object.assign(document.body.dataset, { samples: this.renderer?.done() ?? 0, version: this.version });
  }

  // Lamps at whose edges samples may be missing are known for the view that the page was made with.
  async ask(renderer, develops) {
    const { plan, size, camera } = this, { strip_rows } = plan, { totals } = renderer;
    const film = !camera || camera.isStart(size) ? plan.film : { ...plan.film, lamps: [] };
    return this.estimator.ask({ plan: { film, strip_rows, size }, totals, develops }, await renderer.film());
  }

  async save(renderer, kind) {
    const picture = await this.ask(renderer, true);
    const blob = kind === "png" ? await png(picture, this.view) : exr(picture);
    download(blob, `${document.title.replace(/ · gpu-rt$/, "")}-${renderer.done()}.${kind}`);
  }
}

async function start() {
  let why = "";
  try {
    const { plan, data } = await load();
    const player = new Player(plan, data);
    globalThis.player = player;
    for (let attempt = 0; attempt < MOST_ATTEMPTS; attempt++) {
      if (why) tell(`The device was lost (${why}). It is opened again.`);
      why = await player.attempt();
    }
    why = `The device was lost ${MOST_ATTEMPTS} times: ${why}.`;
  } catch (error) {
    why = error instanceof Lacks ? error.message : `This page cannot render: ${error.message}`;
  }
  [element("still").hidden, element("view").hidden, element("controls").hidden, element("figures").hidden] = [false, true, true, true];
  tell(element("still").firstChild ? `${why} This is a picture that was rendered before.` : why);
}

start();
