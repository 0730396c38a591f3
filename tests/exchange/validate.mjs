// Khronos's validator on .glb files: no error, no warning.
//
//     node validate.mjs NODE_MODULES FILE.glb...
import fs from 'node:fs';
import path from 'node:path';
import { createRequire } from 'node:module';

const validator = createRequire(path.join(process.argv[2], 'x'))('gltf-validator');
let bad = 0;
for (const file of process.argv.slice(3)) {
  const { issues } = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)));
  console.log(`${path.basename(file)}: ${issues.numErrors} errors, ${issues.numWarnings} warnings, ` +
              `${issues.numInfos} informations, ${issues.numHints} hints`);
  for (const { code, message, pointer } of issues.messages.slice(0, 10))
    console.log(`  ${code} ${message} ${pointer ?? ''}`);
  bad += issues.numErrors + issues.numWarnings;
}
process.exit(bad > 0 ? 1 : 0);
