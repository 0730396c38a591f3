// A page with a recorded motion in Chromium, from disk: it moves, its positions are the run's, its
// charts zoom, show values and hide curves.
// usage: node film_test.mjs INDEX.HTML CHROMIUM PHOTOS RUN
// RUN: a folder of `tremolo run --out RUN --surfaces N --surface-format obj`: what moves on the page.
import assert from 'node:assert/strict';
import { mkdirSync, readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { chromium } from 'playwright-core';

const [index, executablePath, photos, run] = process.argv.slice(2);
mkdirSync(photos, { recursive: true });
const browser = await chromium.launch({ executablePath,
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--ignore-gpu-blocklist'] });
const context = await browser.newContext({ offline: true, viewport: { width: 1000, height: 760 } });
const page = await context.newPage();
const errors = [], requests = [];
page.on('pageerror', (error) => errors.push(error.message));
page.on('console', (message) => message.type() === 'error' && errors.push(message.text()));
page.on('request', (request) => requests.push(request.url()));
await page.goto(pathToFileURL(index).href);
await page.waitForFunction(() => window.tremoloFilm?.player.frames > 2, null, { timeout: 60000 });

// The fraction of the stage that is coloured as a body is, and how much two pictures differ.
const look = () => page.evaluate(() => {
  const from = document.getElementById('scene'), flat = document.createElement('canvas');
  [flat.width, flat.height] = [from.width, from.height];
  const context = flat.getContext('2d');
  context.drawImage(from, 0, 0);
  const { data } = context.getImageData(0, 0, flat.width, flat.height);
  let count = 0, changed = 0;
  for (let k = 0; k < data.length; k += 4) {
    if (Math.max(data[k], data[k + 1], data[k + 2]) - Math.min(data[k], data[k + 1], data[k + 2]) >= 32) ++count;
    if (window.lastLook && Math.abs(data[k] - window.lastLook[k]) > 12) ++changed;
  }
  window.lastLook = data;
  return { share: count / (data.length / 4), changed: changed / (data.length / 4) };
});
// A requested frame is drawn in the picture after the next.
const settle = () => page.evaluate(() => new Promise((resolve) => {
  const wanted = window.tremoloFilm.player.frames + 2;
  const wait = () => (window.tremoloFilm.player.frames >= wanted ? resolve() : requestAnimationFrame(wait));
  wait();
}));
const time = () => page.evaluate(() => window.tremoloFilm.player.time);
const seek = async (t) => {
  await page.evaluate((to) => window.tremoloFilm.player.seek(to), t);
  await settle();
};

// It moves by itself, is at rest when paused, and is slow on request.
const seen = await look();
assert.ok(seen.share > 0.02 && seen.share < 0.6, `the body covers ${seen.share} of the stage`);
const began = await time();
// The film begins again at its end.
await page.waitForFunction((t) => Math.abs(window.tremoloFilm.player.time - t) > 0.1, began, { timeout: 30000 });
await page.click('#play');
await settle();
const stopped = await time();
await page.waitForTimeout(300);
assert.equal(await time(), stopped);
await look();
await settle();
assert.equal((await look()).changed, 0);
await seek(0);
await look();
await page.screenshot({ path: join(photos, 'film-0.png') });
await seek(1.4);
const moved = await look();
assert.ok(moved.changed > 1e-3, `the picture at 1.4 s differs in ${moved.changed}`);
await page.screenshot({ path: join(photos, 'film-1.png') });
await page.selectOption('#speed', '0.02');
const since = await page.evaluate(() => performance.now()); // before it plays: whatever the machine does between
await page.click('#play');
await page.waitForFunction(() => window.tremoloFilm.player.time > 1.405, null, { timeout: 30000 });
const slow = await page.evaluate((from) => (window.tremoloFilm.player.time - 1.4) / (1e-3 * (performance.now() - from)), since);
assert.ok(slow < 0.05, `${slow} of real time, asked for a fiftieth`);
await page.click('#play');

// The bar moves to a time, the mouse rotates the camera.
await page.fill('#time', '2.5');
await settle();
assert.ok(Math.abs((await time()) - 2.5) < 1e-9);
await look();
const stage = await page.locator('#scene').boundingBox();
await page.mouse.move(stage.x + 300, stage.y + 200);
await page.mouse.down();
await page.mouse.move(stage.x + 500, stage.y + 160, { steps: 5 });
await page.mouse.up();
await settle();
assert.ok((await look()).changed > 0.01, 'the camera has turned');
await page.selectOption('#colour', 'displacement');
await settle();
await page.screenshot({ path: join(photos, 'film-2.png') });

// Places are the run's to a hundred thousandth of the size.
let worst = 0, compared = 0, moving = 0;
for (const file of readdirSync(run).filter((name) => /^surface-.*\.obj$/.test(name))) {
  const at = Number(/-t([0-9.]+)s/.exec(file)[1]);
  const expected = readFileSync(join(run, file), 'utf8').split('\n').filter((line) => line.startsWith('v '))
    .flatMap((line) => line.split(' ').slice(1, 4).map(Number));
  const { frame, shown, rest } = await page.evaluate((t) => {
    const { film } = window.tremoloFilm, nearest = film.times.reduce((a, b) => (Math.abs(b - t) < Math.abs(a - t) ? b : a));
    return { frame: nearest, shown: film.positions(0, nearest), rest: Array.from(film.shapes[0].rest) };
  }, at);
  if (Math.abs(frame - at) > 1e-5) continue; // the page has every second step
  assert.equal(shown.length, expected.length);
  const sides = [0, 1, 2].map((k) => {
    const column = rest.filter((x, i) => i % 3 === k);
    return column.reduce((a, b) => Math.max(a, b)) - column.reduce((a, b) => Math.min(a, b));
  });
  const size = Math.max(...sides);
  for (let k = 0; k < shown.length; k += 3) {
    worst = Math.max(worst, Math.hypot(...[0, 1, 2].map((c) => shown[k + c] - expected[k + c])) / size);
    moving = Math.max(moving, Math.hypot(...[0, 1, 2].map((c) => rest[k + c] - expected[k + c])) / size);
  }
  ++compared;
}
console.log(`${compared} moments: places ${worst.toExponential(1)} of the size apart, of a motion of ${moving.toFixed(2)}`);
assert.ok(compared >= 2 && moving > 0.01);
// The page's bound, and six digits of the .obj.
assert.ok(worst <= 1e-5 + 2e-6);

// Charts: as many curves as runs; the legend hides one, a double click leaves one alone.
const panel = page.locator('.panel').first();
const curves = () => panel.locator('svg > g path.curve').count();
const runs = await page.locator('.legend button').count();
assert.equal(await curves(), runs);
await page.locator('.legend button').first().click();
assert.equal(await curves(), runs - 1);
await page.locator('.legend button').first().click();
await page.locator('.legend button').nth(1).dblclick();
assert.equal(await curves(), 1);
await page.locator('.legend button').nth(1).dblclick();
assert.equal(await curves(), runs);

// Dragging zooms along x, on all panels; a double click goes back. The values under the pointer are
// those of the run.
const ticks = () => page.locator('.panel').nth(1).locator('svg > text').allTextContents();
await panel.scrollIntoViewIfNeeded();
const all = await ticks(), box = await panel.boundingBox();
await page.mouse.move(box.x + 200, box.y + 150);
await page.mouse.down();
await page.mouse.move(box.x + 320, box.y + 152, { steps: 4 });
await page.mouse.up();
assert.notDeepEqual(await ticks(), all);
await page.mouse.move(box.x + 400, box.y + 90);
const told = await panel.locator('.told').innerText();
await page.screenshot({ path: join(photos, 'zoomed.png') });
const label = await page.locator('.legend button').first().innerText();
const at = Number(/time \(s\): ([0-9.e-]+)/.exec(told)[1]);
const value = Number(new RegExp(`${label}: ([0-9.e-]+)`).exec(told)[1]);
const lines = readFileSync(join(run, 'run.csv'), 'utf8').trim().split('\n').map((line) => line.split(','));
const [t, total] = ['t', 'total'].map((name) => lines[0].indexOf(name));
const row = lines.find((cells) => Math.abs(Number(cells[t]) - at) < 1e-6);
assert.ok(row && Math.abs(Number(row[total]) - value) <= 1e-5 * Math.abs(value), `${told}, and the run has ${row}`);
// A click takes the film to that time.
await page.mouse.click(box.x + 400, box.y + 90);
await settle();
assert.ok(Math.abs((await time()) - at) < 0.1, `${await time()} after a click at ${at}`);
await page.mouse.dblclick(box.x + 400, box.y + 90);
assert.deepEqual(await ticks(), all);

// The browser takes the context away and gives it back.
await page.evaluate(() => {
  const lose = document.getElementById('scene').getContext('webgl2').getExtension('WEBGL_lose_context');
  const canvas = document.getElementById('scene');
  window.scrollTo(0, 0);
  return new Promise((resolve) => {
    canvas.addEventListener('webglcontextlost', () => setTimeout(() => lose.restoreContext()), { once: true });
    canvas.addEventListener('webglcontextrestored', () => setTimeout(resolve), { once: true });
    lose.loseContext();
  });
});
// Drawn in software beside other work, the first pictures after it may be empty.
let drawn = 0;
for (let k = 0; k < 20 && drawn <= 0.02; ++k) {
  await settle();
  drawn = (await look()).share;
}
assert.ok(drawn > 0.02, 'the body is drawn again');

// Nothing but the page itself has been asked for.
assert.deepEqual(requests.filter((url) => !url.startsWith('blob:')), [pathToFileURL(index).href]);
await page.pdf({ path: join(photos, 'film.pdf'), format: 'A4', printBackground: true });

// Without WebGL the page says so, and shows the rest.
const bare = await context.newPage();
await bare.addInitScript(() => { HTMLCanvasElement.prototype.getContext = () => null; });
await bare.goto(pathToFileURL(index).href);
await bare.waitForSelector('.stage .notice');
assert.match(await bare.textContent('.stage .notice'), /has no WebGL 2/);
await bare.waitForSelector('.panel path.curve', { state: 'attached' });
assert.equal(await bare.locator('.panel').first().locator('svg > g path.curve').count(), runs);
assert.deepEqual(errors, []);
await browser.close();
console.log('1 passed, 0 failed');
