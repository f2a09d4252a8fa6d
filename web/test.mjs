// Runs src/**/*.test.ts with node:test; Vite takes the types away and Svelte compiles the runes, as for the page.
import { readdirSync } from "node:fs";
import { svelte } from "@sveltejs/vite-plugin-svelte";
import { createServer } from "vite";

const server = await createServer({
  configFile: false,
  plugins: [svelte()],
  logLevel: "error",
  server: { middlewareMode: true, watch: null, ws: false },
  optimizeDeps: { noDiscovery: true },
});
const files = readdirSync("src", { recursive: true }).map(String).filter((f) => f.endsWith(".test.ts")).sort();
if (files.length === 0) throw new Error("no test was found");
for (const file of files) {
  try {
    await server.ssrLoadModule(`/src/${file.replaceAll("\\", "/")}`);
  } catch (error) {
    // A test file that does not even load must not look like one without tests.
    console.error(`${file} cannot be loaded:`, error);
    process.exitCode = 1;
  }
}
await server.close();
