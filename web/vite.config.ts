// Builds the page into the folder that the service embeds, and runs its tests. File names carry no hash of the machine
// or the time: the same sources give the same bytes, so that a test can compare the committed build with a fresh one.
import { svelte } from "@sveltejs/vite-plugin-svelte";
import { svelteTesting } from "@testing-library/svelte/vite";
import { defineConfig } from "vitest/config";
import { server } from "./server_crate.mjs";

export default defineConfig({
  plugins: [svelte(), svelteTesting()],
  base: "/",
  build: {
    outDir: process.env.WHYROAD_WEB_OUT || `${server}/assets`,
    emptyOutDir: true,
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    rollupOptions: {
      output: { entryFileNames: "page.js", chunkFileNames: "[name].js", assetFileNames: "page.[ext]" },
    },
  },
  server: { proxy: { "/api": process.env.WHYROAD_SERVER ?? "http://127.0.0.1:8080" } },
  test: { environment: "jsdom", include: ["src/**/*.test.ts"], setupFiles: ["src/testing/setup.ts"] },
});
