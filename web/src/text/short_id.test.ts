// Ids as people are shown them. The form of a UUID is that of RFC 9562, section 4.
import assert from "node:assert/strict";
import { test } from "vitest";
import { shortId } from "./short_id.ts";

test("a UUID is shown by its first part, whatever is around it", () => {
  assert.equal(shortId("f81d4fae-7dec-11d0-a765-00a0c91e6bf6_000"), "f81d4fae…_000");
  assert.equal(shortId("F81D4FAE-7DEC-11D0-A765-00A0C91E6BF6"), "F81D4FAE…");
});

test("ids that people chose stay as they are", () => {
  for (const id of ["multilane-ego_002", "sd_nuscenes_v1.0-mini_scene-0061_000", "0_000"]) assert.equal(shortId(id), id);
});
