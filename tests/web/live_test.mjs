// The page of ./demo --live in Chromium, from disk: the engine's page is in it, its body is
// pulled there, and the recorded motion is behind a button.
// usage: node live_test.mjs INDEX.HTML CHROMIUM PHOTOS
import assert from 'node:assert/strict';
import { mkdirSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { chromium } from 'playwright-core';

const [index, executablePath, photos] = process.argv.slice(2);
mkdirSync(photos, { recursive: true });
const browser = await chromium.launch({ executablePath,
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--ignore-gpu-blocklist'] });
const context = await browser.newContext({ offline: true, viewport: { width: 1100, height: 900 } });
const page = await context.newPage();
const errors = [];
page.on('pageerror', (error) => errors.push(error.message));
await page.goto(pathToFileURL(index).href);
const element = await page.waitForSelector('.stage iframe');
const live = await element.contentFrame();
await live.waitForFunction(() => window.tremoloPage?.frames > 2, null, { timeout: 60000 });
assert.equal(await page.isVisible('#scene'), false);
assert.equal(await page.evaluate(() => window.tremoloFilm.player.frames ?? 0), 0);

// Somewhere along the middle of the stage the pointer finds the body.
const box = await element.boundingBox();
let held = false;
for (let k = 0; k < 30 && !held; ++k) {
  await page.mouse.move(box.x + (0.4 + 0.012 * k) * box.width, box.y + 0.5 * box.height);
  await page.mouse.down();
  held = await live.evaluate(() => window.tremoloPage.hand !== null);
  if (!held) await page.mouse.up();
}
assert.ok(held, 'the pointer takes hold of the body');
const energy = () => live.evaluate(() => window.tremoloPage.body.energy().total);
const before = await energy();
await page.mouse.move(box.x + 0.7 * box.width, box.y + 0.3 * box.height, { steps: 6 });
await page.waitForTimeout(400);
await page.screenshot({ path: join(photos, 'demo-live.png') });
await page.mouse.up();
assert.ok(Math.abs((await energy()) - before) > 1e-3 * before, 'the pull changed the energy');

await page.click('.choice button:nth-child(2)');
await page.waitForFunction(() => window.tremoloFilm.player.frames > 2 && window.tremoloFilm.player.time > 0.1, null, { timeout: 30000 });
assert.equal(await page.isVisible('#scene'), true);
assert.equal(await page.isVisible('.stage iframe'), false);
await page.click('.choice button:nth-child(1)');
assert.equal(await page.isVisible('.stage iframe'), true);
assert.deepEqual(errors, []);
await browser.close();
console.log('1 passed, 0 failed');
