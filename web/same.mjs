// Is the committed build what these sources give? Builds the page into a folder of its own and compares every byte.
import { execFileSync } from "node:child_process";
import { mkdtempSync, readdirSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { server } from "./server_crate.mjs";

const committed = `${server}/assets`;
const fresh = mkdtempSync(join(tmpdir(), "whyroad-page-"));
const files = (dir) => readdirSync(dir, { recursive: true, withFileTypes: true }).filter((f) => f.isFile()).map((f) => f.name).sort();
try {
  const env = { ...process.env, WHYROAD_WEB_OUT: fresh };
  execFileSync("npm", ["run", "-s", "build", "--", "--logLevel", "warn"], { env, stdio: "inherit" });
  const names = [...new Set([...files(committed), ...files(fresh)])];
  const same = (name) => {
    try {
      return readFileSync(join(committed, name)).equals(readFileSync(join(fresh, name)));
    } catch {
      return false;
    }
  };
  const differing = names.filter((name) => !same(name));
  if (differing.length > 0) {
    console.error(`The committed page is not what web/ builds: ${differing.join(", ")}. Run "npm run build" in web/ and commit.`);
    process.exitCode = 1;
  } else {
    console.log(`The committed page is what web/ builds: ${names.length} files.`);
  }
} finally {
  rmSync(fresh, { recursive: true, force: true });
}
