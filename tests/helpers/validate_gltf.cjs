// Khronos' glTF validator's report on a file, as JSON: node validate_gltf.cjs MODULE FILE
const { readFileSync } = require("fs");
const [module_, file] = process.argv.slice(2);
require(module_)
  .validateBytes(new Uint8Array(readFileSync(file)), { maxIssues: 0, writeTimestamp: false })
  .then((report) => process.stdout.write(JSON.stringify(report)));
