// Writes dist/: the page, one script, one style sheet, the licences of what is bundled, and the
// digest of the sources, by which a test sees that dist/ was built from them.
import { createHash } from "node:crypto";
import { cpSync, mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { build } from "esbuild";

const COPIED = ["index.html", "icon.svg"];

function digest() {
  const entries = readdirSync("src", { recursive: true, withFileTypes: true }).filter((entry) => entry.isFile());
  const files = ["build.mjs", "package.json", ...entries.map((entry) => `${entry.parentPath}/${entry.name}`)].sort();
  const hash = createHash("sha256");
  for (const file of files) hash.update(file + "\n").update(readFileSync(file)).update("\n");
  return hash.digest("hex");
}

/** Of each package of which the bundle holds something. */
function licences(inputs) {
  const names = Object.keys(inputs).map((path) => /^node_modules\/((?:@[^/]+\/)?[^/]+)/.exec(path)?.[1]);
  return [...new Set(names.filter(Boolean))].sort().map((name) => {
    const { version, license } = JSON.parse(readFileSync(`node_modules/${name}/package.json`));
    const text = readFileSync(`node_modules/${name}/LICENSE`, "utf8").trim();
    return `${name} ${version} (${license})\n\n${text}\n`;
  });
}

rmSync("dist", { recursive: true, force: true });
mkdirSync("dist");
const { metafile } = await build({
  entryPoints: [
    { in: "src/main.js", out: "viewer" },
    { in: "src/viewer.css", out: "viewer" },
  ],
  outdir: "dist",
  bundle: true,
  format: "esm",
  target: "es2021",
  minify: true,
  metafile: true,
  legalComments: "none",
  banner: { js: "// Licences of what is bundled here: licences.txt", css: "/* Licences: licences.txt */" },
  logLevel: "info",
});
for (const name of COPIED) cpSync(`src/${name}`, `dist/${name}`);
writeFileSync("dist/licences.txt", licences(metafile.inputs).join("\n" + "-".repeat(72) + "\n\n"));
writeFileSync("dist/sources.sha256", digest() + "\n");
