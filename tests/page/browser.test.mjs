// The page in Chromium: from a server and from a disk, with its figures, files, camera, and what goes wrong.

import assert from "node:assert/strict";
import fs from "node:fs";
import http from "node:http";
import path from "node:path";
import { after, before, test } from "node:test";
import puppeteer from "puppeteer-core";

import { CHROMIUM, ROOT, folder, gpuRt, readExr, rendered } from "./common.mjs";

const SCENE = "scenes/cornell.ron", SIZE = "96x96";
const FLAGS = ["--no-sandbox", "--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader", "--enable-features=Vulkan", "--use-vulkan=swiftshader", "--use-angle=swiftshader"];
const TYPES = { ".js": "text/javascript", ".html": "text/html", ".css": "text/css", ".json": "application/json", ".png": "image/png" };
const SHOTS = process.env.PAGE_SHOTS ?? folder;

let browser, server, urls;

before(async () => {
  const [served, single] = [path.join(folder, "served"), path.join(folder, "single.html")];
  gpuRt("page", SCENE, "-o", served, "--size", SIZE, "--spp", "8");
  gpuRt("page", SCENE, "-o", single, "--single", "--size", SIZE, "--spp", "8");
  server = http.createServer((request, response) => {
    const file = path.join(served, path.basename(request.url) || "index.html");
    response.writeHead(fs.existsSync(file) ? 200 : 404, { "content-type": TYPES[path.extname(file)] ?? "application/octet-stream" });
    response.end(fs.existsSync(file) ? fs.readFileSync(file) : "");
  });
  await new Promise(done => server.listen(0, done));
  urls = { server: `http://localhost:${server.address().port}/`, disk: `file://${single}` };
  browser = await puppeteer.launch({ executablePath: CHROMIUM, args: FLAGS });
});

after(async () => {
  await browser?.close();
  server?.close();
});

// Opens the page. What the console says is in `said`.
async function opened(url, prepare = async () => {}) {
  const page = await browser.newPage();
  const said = [];
  page.on("console", message => said.push(message.text()));
  page.on("pageerror", error => said.push(error.message));
  page.on("requestfailed", request => said.push(request.url()));
  await page.setViewport({ width: 900, height: 900 });
  await prepare(page);
  await page.goto(url);
  return { page, said };
}

const until = (page, condition, ...values) => page.waitForFunction(condition, { timeout: 60000, polling: 50 }, ...values);
const samples = (page, least) => until(page, least => Number(document.body.dataset.samples) >= least, least);
// Waits for an image of the camera as it is now.
const redrawn = page => until(page, () => Number(document.body.dataset.version) === player.version && Number(document.body.dataset.samples) >= 8);
const textOf = (page, id) => page.$eval(`#${id}`, element => element.textContent);
const shot = (page, name) => page.screenshot({ path: path.join(SHOTS, `${name}.png`) });

// The codes of the canvas as it is shown.
const codesOf = page => page.evaluate(() => {
  player.draw();
  const canvas = document.getElementById("view");
  const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
  copy.drawImage(canvas, 0, 0);
  return [...copy.getImageData(0, 0, canvas.width, canvas.height).data];
});
// The codes of a PNG.
const codesOfPng = async (page, file) => {
  const url = `data:image/png;base64,${fs.readFileSync(file).toString("base64")}`;
  return page.evaluate(async url => {
    const image = await createImageBitmap(await (await fetch(url)).blob(), { colorSpaceConversion: "none" });
    const copy = new OffscreenCanvas(image.width, image.height).getContext("2d");
    copy.drawImage(image, 0, 0);
    return [...copy.getImageData(0, 0, image.width, image.height).data];
  }, url);
};

async function saved(page, kind) {
  const to = fs.mkdtempSync(path.join(folder, "saved-"));
  const session = await page.createCDPSession();
  await session.send("Browser.setDownloadBehavior", { behavior: "allow", downloadPath: to });
  await page.click(`#${kind}`);
  for (let tries = 0; tries < 200; tries++) {
    const [file] = fs.readdirSync(to).filter(name => name.endsWith(kind));
    if (file) return path.join(to, file);
    await new Promise(done => setTimeout(done, 50));
  }
  throw new Error(`no ${kind} was saved`);
}

// Waits until the page has ended the round that it has begun. The result is its samples, which stay as they are.
async function rested(page) {
  const end = Date.now() + 60000;
  for (let [before, since] = ["", Date.now()]; Date.now() - since < 3000; ) {
    assert.ok(Date.now() < end, "the page does not rest");
    const now = await textOf(page, "samples");
    if (now !== before || now.includes("ahead")) [before, since] = [now, Date.now()];
    await new Promise(done => setTimeout(done, 50));
  }
  return Number(await page.evaluate(() => document.body.dataset.samples));
}

for (const from of ["server", "disk"]) {
  test(`from a ${from}, the page renders and saves what the program renders`, async () => {
    const { page, said } = await opened(urls[from]);
    await samples(page, 16);
    await until(page, () => /^[\d.]+ %, at most .* at 16 samples$/.test(document.getElementById("error").textContent));
    // The button moves while the text beside it changes, so that a mouse may miss it.
    await page.$eval("#pause", button => button.click());
    const count = await rested(page);
    const { image, said: host } = rendered(SCENE, SIZE, count);
    const exr = await saved(page, "exr");
    const [own, right] = [readExr(exr), readExr(image)];
    assert.match(path.basename(exr), new RegExp(`^cornell-${count}`));
    for (const [name, values] of Object.entries(own.channels)) assert.ok(values.every((word, i) => word === right.channels[name][i]), name);
    assert.ok(host.samples_per_pixel === count);
    const developed = path.join(folder, `developed-${from}.png`);
    gpuRt("develop", image, "-o", developed);
    const [png, host_png, shown] = [await codesOfPng(page, await saved(page, "png")), await codesOfPng(page, developed), await codesOf(page)];
    assert.equal(png.filter((code, i) => code !== host_png[i]).length, 0);
    const most = shown.reduce((most, code, i) => Math.max(most, Math.abs(code - host_png[i])), 0);
    assert.ok(shown.length === host_png.length && most <= 1, `${most}`);
    for (const curve of ["srgb", "neutral", "filmic"]) {
      await page.select("#curve", curve);
      gpuRt("develop", image, "-o", developed, "--tonemap", curve);
      const [shown, right] = [await codesOf(page), await codesOfPng(page, developed)];
      assert.ok(shown.every((code, i) => Math.abs(code - right[i]) <= 1), curve);
      assert.ok(host_png.some((code, i) => Math.abs(code - right[i]) > 1), curve);
    }
    await shot(page, from);
    assert.deepEqual(said, []);
    await page.close();
  });
}

test("mouse and keys move the camera, and a reset brings it back", async () => {
  const { page, said } = await opened(urls.server);
  await samples(page, 8);
  const first = await codesOf(page);
  const differ = (a, b) => a.filter((code, i) => Math.abs(code - b[i]) > 40).length;
  await page.focus("#view");
  await page.keyboard.press("ArrowLeft");
  await redrawn(page);
  assert.ok(differ(first, await codesOf(page)) > 1000);
  await shot(page, "orbit");
  await page.keyboard.press("0");
  await redrawn(page);
  assert.ok(differ(first, await codesOf(page)) < 1000);
  for (const act of [
    async box => {
      await page.mouse.move(box.x + 300, box.y + 300);
      await page.mouse.down();
      await page.mouse.move(box.x + 400, box.y + 320, { steps: 4 });
      await page.mouse.up();
    },
    () => page.mouse.wheel({ deltaY: -300 }),
    () => page.keyboard.press("+"),
    async () => {
      await page.keyboard.down("Shift");
      await page.keyboard.press("ArrowUp");
      await page.keyboard.up("Shift");
    },
  ]) {
    const before = await page.evaluate(() => JSON.stringify(player.camera));
    await act(await (await page.$("#view")).boundingBox());
    assert.notEqual(await page.evaluate(() => JSON.stringify(player.camera)), before);
  }
  await redrawn(page);
  await page.click("#reset");
  assert.equal(await page.evaluate(() => player.camera.moved), false);
  // Two fingers: apart is nearer.
  const distance = await page.evaluate(() => player.camera.distance);
  const touch = await page.createCDPSession();
  const points = (...xs) => xs.map((x, id) => ({ x, y: 300, id }));
  await touch.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints: points(400, 500) });
  await touch.send("Input.dispatchTouchEvent", { type: "touchMove", touchPoints: points(350, 550) });
  await touch.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
  assert.ok((await page.evaluate(() => player.camera.distance)) < 0.8 * distance);
  assert.deepEqual(said, []);
  await page.close();
});

test("a hidden page rests", async () => {
  const { page } = await opened(urls.server);
  await samples(page, 8);
  const hide = hidden => page.evaluate(hidden => {
    Object.defineProperty(document, "hidden", { value: hidden, configurable: true });
    document.dispatchEvent(new Event("visibilitychange"));
  }, hidden);
  await hide(true);
  const count = await rested(page);
  assert.equal(await rested(page), count);
  await hide(false);
  await samples(page, count + 8);
  await page.close();
});

test("a lost device is told and opened again", async () => {
  const { page } = await opened(urls.server);
  await samples(page, 16);
  await page.evaluate(() => {
    globalThis.told = [];
    new MutationObserver(() => told.push(document.getElementById("message").textContent)).observe(document.getElementById("message"), { childList: true });
    player.renderer.device.destroy();
  });
  await until(page, () => told.some(words => words.startsWith("The device was lost (")) && told.at(-1).startsWith("Rendering on"));
  await until(page, () => Number(document.body.dataset.samples) < 16);
  await samples(page, 8);
  await page.close();
});

test("without WebGPU there are words and the picture", async () => {
  for (const url of Object.values(urls)) {
    const { page, said } = await opened(url, page => page.evaluateOnNewDocument(() => Object.defineProperty(navigator, "gpu", { value: undefined })));
    await until(page, () => document.getElementById("message").textContent.startsWith("This browser has no WebGPU"));
    assert.ok(await page.$eval("#still img", image => image.naturalWidth === 96 && image.getBoundingClientRect().width > 90));
    assert.equal(await page.$eval("#controls", form => form.getBoundingClientRect().width), 0);
    await shot(page, "without");
    assert.deepEqual(said, []);
    await page.close();
  }
});

test("it fits a phone, by day and by night", async () => {
  const grounds = [];
  for (const value of ["light", "dark"]) {
    const { page, said } = await opened(urls.disk, async page => {
      await page.setViewport({ width: 390, height: 844, deviceScaleFactor: 2 });
      await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value }]);
    });
    await samples(page, 8);
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= 390));
    grounds.push(await page.$eval("body", body => getComputedStyle(body).backgroundColor));
    await shot(page, `phone-${value}`);
    await page.setViewport({ width: 1200, height: 500 });
    assert.ok(await page.$eval("#view", canvas => canvas.getBoundingClientRect().height <= 500));
    assert.deepEqual(said, []);
    await page.close();
  }
  assert.notEqual(grounds[0], grounds[1]);
});

test("all can be reached by keys, and has a name", async () => {
  const { page } = await opened(urls.disk);
  await samples(page, 8);
  const reached = [];
  for (let press = 0; press < 8; press++) {
    await page.keyboard.press("Tab");
    reached.push(await page.evaluate(() => document.activeElement.id));
  }
  assert.deepEqual(reached.slice(0, 7), ["view", "pause", "reset", "exposure", "curve", "png", "exr"]);
  const tree = JSON.stringify(await page.accessibility.snapshot());
  for (const name of ["Exposure", "Curve", "Pause", "cornell: arrows turn the camera"]) assert.ok(tree.includes(name), `${name} in ${tree}`);
  await page.close();
});

test("without --size the image fills the view, with the scene's proportions", async () => {
  const file = path.join(folder, "filling.html");
  gpuRt("page", "scenes/window.ron", "-o", file, "--single", "--spp", "0");
  const { page, said } = await opened(`file://${file}`, page => page.setViewport({ width: 120, height: 900 }));
  await samples(page, 8);
  const [width, height] = await page.$eval("#view", canvas => [canvas.width, canvas.height]);
  const inner = await page.$eval("#stage", stage => stage.clientWidth);
  assert.ok(width === inner && Math.abs(height - (width * 400) / 640) <= 1, `${width} ${height} ${inner}`);
  await page.setViewport({ width: 150, height: 900 });
  await until(page, width => document.getElementById("view").width > width, width);
  await until(page, () => document.getElementById("samples").textContent.startsWith("8 per pixel"));
  assert.deepEqual(said, []);
  await page.close();
});

// The page of the tests, not of another version.
test("the player is that of the sources", () => {
  for (const name of ["film.js", "main.js"]) {
    assert.equal(fs.readFileSync(path.join(folder, "served", name), "utf8"), fs.readFileSync(path.join(ROOT, "src/page/player", name), "utf8"));
  }
});
