// Starts the real service on a fresh store, and finds the programs that the test needs. Knows nothing of the page.
import { execFileSync, spawn } from "node:child_process";
import { existsSync } from "node:fs";
import { resolve } from "node:path";

const root = resolve(import.meta.dirname, "../..");

/** The binary under test: named, else the release build, else the debug build. */
export function binary() {
  const found = [process.env.WHYROAD_BIN, `${root}/target/release/whyroad`, `${root}/target/debug/whyroad`].find((p) => p && existsSync(p));
  if (!found) throw new Error("no whyroad binary: build one (cargo build) or name one in WHYROAD_BIN");
  return found;
}

/** The Chromium of this machine; null without one. */
export function chromium() {
  const names = [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];
  return names.find((p) => p && existsSync(p)) ?? null;
}

/** Runs whyroad to its end; its standard output. Throws when it does not exit with 0. */
export function whyroad(...args) {
  return execFileSync(binary(), args, { encoding: "utf8", stdio: ["ignore", "pipe", "inherit"], timeout: 300_000 });
}

/** A running service: its address, and how to stop it. `demo` is what `whyroad demo --out` wrote. */
export async function serve({ data, demo, lake = demo && `${demo}/lake`, mined = demo && `${demo}/mined`, port = 0, environment = {}, more = [] }) {
  const args = ["--lang", "zh", "serve", "--data", data, "--listen", `127.0.0.1:${port}`, ...more];
  if (lake) args.push("--lake", lake, "--mined", mined);
  const child = spawn(binary(), args, { stdio: ["ignore", "pipe", "pipe"], env: { ...process.env, ...environment } });
  let said = "";
  const ended = new Promise((done) => child.once("exit", (code, signal) => done(`${code ?? signal}`)));
  const address = new Promise((found, failed) => {
    const hear = (chunk) => {
      said += chunk;
      const at = said.match(/http:\/\/127\.0\.0\.1:(\d+)/);
      if (at) found({ url: at[0], port: Number(at[1]) });
    };
    child.stdout.on("data", hear);
    child.stderr.on("data", hear);
    void ended.then((how) => failed(new Error(`the service ended (${how}):\n${said}`)));
  });
  const { url, port: at } = await address;
  for (let n = 0; ; n++) {
    const up = await fetch(`${url}/api/v1/healthz`).then((r) => r.ok, () => false);
    if (up) break;
    if (n > 200) throw new Error(`the service does not answer:\n${said}`);
    await new Promise((done) => setTimeout(done, 50));
  }
  return {
    url,
    port: at,
    async stop(signal = "SIGTERM") {
      child.kill(signal);
      return ended;
    },
  };
}
