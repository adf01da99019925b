// Prints the report of the Khronos validator on one GLB file as JSON.
import { readFileSync } from "node:fs";
import validator from "gltf-validator";

const data = new Uint8Array(readFileSync(process.argv[2]));
const report = await validator.validateBytes(data, { format: "glb", maxIssues: 0, writeTimestamp: false });
console.log(JSON.stringify(report));
