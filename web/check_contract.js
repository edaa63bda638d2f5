// Validates the robots' contract, docs/contract/asyncapi.yaml, with its examples: `npm run check:contract`.

import { readFile } from "node:fs/promises";
import process from "node:process";

import { Parser } from "@asyncapi/parser";

const DOCUMENT = new URL("../docs/contract/asyncapi.yaml", import.meta.url);
/** AsyncAPI 3.1 exists; the document stays readable for tools that know 3.0. */
const ACCEPTED = new Set(["asyncapi-latest-version"]);

const { diagnostics } = await new Parser().parse(await readFile(DOCUMENT, "utf8"));
const faults = diagnostics.filter(({ code, severity }) => severity <= 1 && !ACCEPTED.has(String(code)));
for (const { code, message, path } of faults) {
    console.error(`docs/contract/asyncapi.yaml ${path.join(".")}: ${message} (${code})`);
}
process.exit(faults.length > 0 ? 1 : 0);
