// How evenly the labeling screen plays a made-up scene: `node e2e/bench.mjs [objects] [seconds] [cameras]`, after `npm
// run build`. A camera has a new image of 1280 x 720 at every frame of the clip. Measures the time between frames in
// Chromium while the scene plays, and what the main thread does in each.
import { readFile } from "node:fs/promises";
import { cpus, loadavg } from "node:os";
import { join, resolve } from "node:path";
import { chromium as launcher } from "playwright-core";
import { chromium } from "./service.mjs";
import { answers, stand } from "./synthetic.mjs";

const objects = Number(process.argv[2] ?? 200);
const seconds = Number(process.argv[3] ?? 10);
const cameras = Number(process.argv[4] ?? 3);
const dist = process.env.WHYROAD_WEB_OUT ?? resolve(import.meta.dirname, "../../crates/whyroad-server/assets");

const browser = await launcher.launch({ executablePath: chromium() ?? undefined, args: ["--no-sandbox"] });
const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
await stand(page, dist, answers({ objects, seconds: seconds + 12, stage: "stage2", cameras }), { readFile, join });
await page.goto("http://whyroad.test/tasks/t1");
await page.waitForSelector("canvas");
await page.waitForTimeout(800);

const cdp = await page.context().newCDPSession(page);
await cdp.send("Performance.enable");
const spent = async () => Object.fromEntries((await cdp.send("Performance.getMetrics")).metrics.map((m) => [m.name, m.value]));
const before = await spent();

const result = await page.evaluate(async (wanted) => {
  const gl = document.createElement("canvas").getContext("webgl");
  const info = gl?.getExtension("WEBGL_debug_renderer_info");
  const renderer = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "none";
  const gaps = [];
  const until = performance.now() + wanted * 1000;
  let last = 0;
  document.querySelector(".transport .play").click();
  await new Promise((done) => {
    const tick = (at) => {
      if (last) gaps.push(at - last);
      last = at;
      if (performance.now() < until) requestAnimationFrame(tick);
      else done();
    };
    requestAnimationFrame(tick);
  });
  return { gaps, renderer };
}, seconds);
const after = await spent();
await browser.close();

/** What the page's main thread did a frame, ms. */
const share = (name) => (((after[name] - before[name]) * 1000) / result.gaps.length).toFixed(1);
const sorted = (v) => [...v].sort((a, b) => a - b);
const at = (v, share) => sorted(v)[Math.min(v.length - 1, Math.floor(v.length * share))];
const mean = result.gaps.reduce((a, b) => a + b, 0) / result.gaps.length;
const late = result.gaps.filter((g) => g > 25).length;
console.log(`page/play/${objects}/${cameras}: ${(1000 / mean).toFixed(1)} frames a second over ${seconds} s`);
console.log(`  between frames: p50 ${at(result.gaps, 0.5).toFixed(1)} ms, p95 ${at(result.gaps, 0.95).toFixed(1)} ms, p99 ${at(result.gaps, 0.99).toFixed(1)} ms, longest ${Math.max(...result.gaps).toFixed(1)} ms`);
console.log(`  main thread a frame: ${share("TaskDuration")} ms, of it script ${share("ScriptDuration")}, layout and style ${(Number(share("LayoutDuration")) + Number(share("RecalcStyleDuration"))).toFixed(1)}; frames later than 25 ms: ${late} of ${result.gaps.length}`);
console.log(`  ${cpus().length} cores of ${cpus()[0]?.model}; load ${loadavg()[0].toFixed(1)}; renderer: ${result.renderer}`);
