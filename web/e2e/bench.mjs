// How evenly the labelling screen plays a made-up scene: `node e2e/bench.mjs [objects] [seconds]`, after `npm run build`.
// Measures the time between frames in Chromium while the scene plays, and the script's share of each frame.
import { readFile } from "node:fs/promises";
import { cpus } from "node:os";
import { join, resolve } from "node:path";
import { chromium as launcher } from "playwright-core";
import { chromium } from "./service.mjs";
import { answers, stand } from "./synthetic.mjs";

const objects = Number(process.argv[2] ?? 200);
const seconds = Number(process.argv[3] ?? 10);
const dist = process.env.WHYROAD_WEB_OUT ?? resolve(import.meta.dirname, "../../crates/whyroad-labeling/assets");

const browser = await launcher.launch({ executablePath: chromium() ?? undefined, args: ["--no-sandbox"] });
const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
await stand(page, dist, answers({ objects, seconds: seconds + 12, stage: "stage2" }), { readFile, join });
await page.goto("http://whyroad.test/tasks/t1");
await page.waitForSelector("canvas");
await page.waitForTimeout(800);

const result = await page.evaluate(async (wanted) => {
  const gl = document.createElement("canvas").getContext("webgl");
  const info = gl?.getExtension("WEBGL_debug_renderer_info");
  const renderer = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "none";
  // The page's own work in a frame: from the first callback of a frame to the last, which this one is.
  const gaps = [];
  const work = [];
  const until = performance.now() + wanted * 1000;
  let last = 0;
  document.querySelector(".transport .play").click();
  await new Promise((done) => {
    const tick = (at) => {
      if (last) gaps.push(at - last);
      last = at;
      // Microtasks, and with them the drawing, have run before a message arrives.
      const channel = new MessageChannel();
      channel.port1.onmessage = () => work.push(performance.now() - at);
      channel.port2.postMessage(0);
      if (performance.now() < until) requestAnimationFrame(tick);
      else done();
    };
    requestAnimationFrame(tick);
  });
  return { gaps, work, renderer, dots: document.querySelectorAll(".objects li").length };
}, seconds);
await browser.close();

const sorted = (v) => [...v].sort((a, b) => a - b);
const at = (v, share) => sorted(v)[Math.min(v.length - 1, Math.floor(v.length * share))];
const mean = result.gaps.reduce((a, b) => a + b, 0) / result.gaps.length;
const late = result.gaps.filter((g) => g > 25).length;
console.log(`page/play/${objects}: ${(1000 / mean).toFixed(1)} frames a second over ${seconds} s`);
console.log(`  between frames: p50 ${at(result.gaps, 0.5).toFixed(1)} ms, p95 ${at(result.gaps, 0.95).toFixed(1)} ms, p99 ${at(result.gaps, 0.99).toFixed(1)} ms, longest ${Math.max(...result.gaps).toFixed(1)} ms`);
console.log(`  frame to message: p50 ${at(result.work, 0.5).toFixed(1)} ms, p95 ${at(result.work, 0.95).toFixed(1)} ms; frames later than 25 ms: ${late} of ${result.gaps.length}`);
console.log(`  ${cpus().length} cores of ${cpus()[0]?.model}; renderer: ${result.renderer}`);
