// The page in Chromium, from disk: pixels of the body, what a pull does, models, wrong files.
// usage: node page_test.mjs INDEX.HTML CHROMIUM PHOTOS
import assert from 'node:assert/strict';
import { mkdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { chromium } from 'playwright-core';

const [index, executablePath, photos] = process.argv.slice(2);
mkdirSync(photos, { recursive: true });
const browser = await chromium.launch({ executablePath,
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--ignore-gpu-blocklist'] });
const context = await browser.newContext({ offline: true, viewport: { width: 900, height: 640 } });
const page = await context.newPage();
const errors = [];
page.on('pageerror', (error) => errors.push(error.message));
page.on('console', (message) => message.type() === 'error' && errors.push(message.text()));
await page.goto(pathToFileURL(index).href);
await page.waitForFunction(() => window.tremoloPage?.frames > 2, null, { timeout: 60000 });
const firstFrame = await page.evaluate(() => window.tremoloPage.firstFrame);
console.log(`first picture ${firstFrame.toFixed(0)} ms after the script began`);

// The fraction of the middle's pixels that are neither floor nor sky: coloured, or dark.
const body = () => page.evaluate(() => {
  const from = document.getElementById('scene'), flat = document.createElement('canvas');
  flat.width = from.width;
  flat.height = from.height;
  const context = flat.getContext('2d');
  context.drawImage(from, 0, 0);
  const { data } = context.getImageData(0, 0, flat.width, flat.height);
  let count = 0, x = 0, y = 0;
  for (let k = 0; k < data.length; k += 4) {
    const spread = Math.max(data[k], data[k + 1], data[k + 2]) - Math.min(data[k], data[k + 1], data[k + 2]);
    if (spread < 32) continue;
    ++count;
    x += (k / 4) % flat.width;
    y += Math.floor(k / 4 / flat.width);
  }
  return { share: count / (flat.width * flat.height), x: x / count / flat.width, y: y / count / flat.height };
});
const seen = await body();
console.log('horse', seen);
assert.ok(seen.share > 0.02 && seen.share < 0.6, `the horse covers ${seen.share} of the picture`);
assert.ok(Math.abs(seen.x - 0.5) < 0.15 && Math.abs(seen.y - 0.5) < 0.2);
await page.screenshot({ path: join(photos, 'horse.png') });

// It moves by itself after the first blow, and is at rest when paused.
const state = () => page.evaluate(() => Array.from(window.tremoloPage.now));
const moved = async () => {
  const before = await state();
  await page.waitForTimeout(400);
  const after = await state();
  return Math.max(...after.map((x, i) => Math.abs(x - before[i])));
};
assert.ok((await moved()) > 0);
await page.click('#pause');
await page.waitForTimeout(100);
assert.equal(await moved(), 0);
await page.click('#pause');

// The default method keeps the energy.
const energy = () => page.evaluate(() => window.tremoloPage.body.energy().total);
const start = await energy();
await page.waitForTimeout(1500);
assert.ok(Math.abs((await energy()) - start) < 1e-6 * start);

// A pull at the body puts energy in; one next to it rotates the camera.
const target = { x: 900 * seen.x, y: 640 * seen.y };
const at = await page.evaluate(() => document.getElementById('scene').getBoundingClientRect().toJSON());
await page.mouse.move(at.x + target.x, at.y + target.y);
await page.mouse.down();
const held = await page.evaluate(() => window.tremoloPage.hand !== null);
await page.mouse.move(at.x + target.x + 60, at.y + target.y - 50, { steps: 8 });
await page.waitForTimeout(500);
await page.screenshot({ path: join(photos, 'pulled.png') });
await page.mouse.up();
assert.ok(held, 'the pointer on the body takes hold of it');
assert.ok(await page.evaluate(() => window.tremoloPage.hand === null));
await page.waitForTimeout(200);
const pulled = await energy();
assert.ok(Math.abs(pulled - start) > 1e-3 * start, 'the pull changed the energy');

// Implicit Euler lets it die.
await page.selectOption('#integrator', 'implicit-euler');
const readout = () => page.textContent('#readout');
await page.waitForFunction((before) => window.tremoloPage.body.energy().total < 0.5 * before, pulled, { timeout: 60000 })
  .catch(async () => assert.fail(`of ${pulled} J: ${await readout()}`));

// Every model, in colours that the floor has not.
await page.selectOption('#colour', 'displacement');
for (const name of await page.$$eval('#model option', (all) => all.map((one) => one.value))) {
  await page.selectOption('#model', name);
  await page.waitForFunction((wanted) => window.tremoloPage.name === wanted, name, { timeout: 30000 });
  await page.waitForTimeout(500);
  const shown = await body();
  console.log(name, shown.share.toFixed(3), `${(await page.evaluate(() => 1e3 * window.tremoloPage.stepCost)).toFixed(0)} us a step`);
  await page.screenshot({ path: join(photos, `${name}.png`) });
  assert.equal(await page.textContent('#message'), '');
  assert.ok(shown.share > 0.01 && shown.share < 0.6, `${name} covers ${shown.share} of the picture`);
}

// The browser takes the context away and gives it back.
await page.evaluate(() => {
  const lose = document.getElementById('scene').getContext('webgl2').getExtension('WEBGL_lose_context');
  const canvas = document.getElementById('scene');
  return new Promise((resolve) => {
    canvas.addEventListener('webglcontextlost', () => setTimeout(() => lose.restoreContext()), { once: true });
    canvas.addEventListener('webglcontextrestored', () => setTimeout(resolve), { once: true });
    lose.loseContext();
  });
});
const drawn = await page.evaluate(() => window.tremoloPage.frames);
await page.waitForFunction((frames) => window.tremoloPage.frames > frames + 1, drawn, { timeout: 30000 });
const again = await body();
assert.ok(again.share > 0.01, `after the context came back the body covers ${again.share} of the picture`);

// A file that is not a model.
const wrong = join(photos, 'wrong.tremolo');
writeFileSync(wrong, 'this is no basis file, though it is long enough to be looked at closely');
await page.evaluate(async (text) => {
  const transfer = new DataTransfer();
  transfer.items.add(new File([text], 'wrong.tremolo'));
  dispatchEvent(new DragEvent('drop', { dataTransfer: transfer }));
}, 'this is no basis file, though it is long enough to be looked at closely');
await page.waitForFunction(() => document.getElementById('message').textContent.includes('wrong.tremolo'));
console.log(await page.textContent('#message'));
assert.deepEqual(errors, []);
await browser.close();
console.log('1 passed, 0 failed');
