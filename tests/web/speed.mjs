// Steps of ep4 in node and in Chromium compared with those of the native engine, alternately: horse
// and heart swing freely after an impulse of one step. Prints the least of the series in each;
// nothing is judged.
// usage: node speed.mjs BUILD CHROMIUM; where run.sh has installed what it needs
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { chromium } from 'playwright-core';

const [build, executablePath] = process.argv.slice(2);
const kStep = 0.003, kSteps = 250, kSeries = 40;
const kPushed = { horse: [1045, [0.05, 0.4, -0.2]], heart: [498, [0, 0, 2]] };

// Runs where the package is: [us a step of the fastest series].
function measure(tremolo, bytes, [vertex, force], step, steps, series) {
  const model = tremolo.loadModel(bytes), body = model.createBody({ integrator: 'ep4', step });
  body.applyForce(vertex, force, 1);
  body.step(steps);
  let least = Infinity;
  for (let k = 0; k < series; ++k) {
    const begin = performance.now();
    body.step(steps);
    least = Math.min(least, (1000 * (performance.now() - begin)) / steps);
  }
  body.release();
  model.release();
  return least;
}

function native(name, [vertex, force], vectors) {
  const out = execFileSync(join(build, 'bin/tremolo'), ['run', join(build, `models/${name}.tremolo`), '--integrator', 'ep4',
    '--load', 'impulse', '--at', `${vertex}`, '--force', force.join(','), '--duration', `${kStep * kSteps * (kSeries + 1)}`,
    '--step', `${kStep}`, '--json'], { env: { ...process.env, TREMOLO_VECTORS: vectors }, stdio: ['ignore', 'pipe', 'ignore'] });
  return JSON.parse(out).microseconds_per_step;
}

const browser = await chromium.launch({ executablePath, args: ['--no-sandbox'] });
const page = await browser.newPage();
await page.goto(pathToFileURL(resolve(build, 'web/package/package.json')).href); // any page that has an address
await page.addScriptTag({ type: 'module', content: `${readFileSync(join(build, 'web/engine.inline.js'), 'utf8')}
Object.assign(window, { start: () => loadTremolo({ wasmBinary: tremoloWasm() }), measure: ${measure} });` });
await page.waitForFunction(() => window.measure);
const { loadTremolo } = await import(pathToFileURL(resolve(build, 'web/package/tremolo.mjs')));
const tremolo = await loadTremolo();
for (const [name, push] of Object.entries(kPushed)) {
  const bytes = readFileSync(join(build, `models/${name}.tremolo`));
  for (let turn = 0; turn < 3; ++turn) {
    const inNode = measure(tremolo, bytes, push, kStep, kSteps, kSeries);
    const inPage = await page.evaluate(async ([text, ...rest]) => {
      const raw = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
      return window.measure(await window.start(), raw, ...rest);
    }, [bytes.toString('base64'), push, kStep, kSteps, kSeries]);
    const [avx2, widest] = ['avx2', ''].map((vectors) => native(name, push, vectors));
    console.log(`${name}: node ${inNode.toFixed(1)}, Chromium ${inPage.toFixed(1)}, native AVX2 ${avx2.toFixed(2)}, ` +
      `widest ${widest.toFixed(2)} us a step; Chromium over AVX2 ${(inPage / avx2).toFixed(2)}`);
  }
}
await browser.close();
