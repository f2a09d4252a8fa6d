// Ids as people are shown them. The form of a UUID is that of RFC 9562, section 4; the others are ids of public logs.
import assert from "node:assert/strict";
import { test } from "vitest";
import { shortId, shortTrack } from "./short_id.ts";

test("a UUID is shown by its first part, whatever is around it", () => {
  assert.equal(shortId("f81d4fae-7dec-11d0-a765-00a0c91e6bf6_000"), "f81d4fae…_000");
  assert.equal(shortId("F81D4FAE-7DEC-11D0-A765-00A0C91E6BF6"), "F81D4FAE…");
});

test("long ids of a series still differ", () => {
  assert.equal(shortId("sd_nuscenes_v1.0-mini_scene-0061_000"), "sd_nusce…_scene-0061_000");
  assert.notEqual(shortId("b0c9d2329ad1606b-2018-08-02--08-34-47_40_000"), shortId("b0c9d2329ad1606b-2018-08-02--08-34-47_41_000"));
});

test("short ids stay as they are", () => {
  for (const id of ["multilane-ego_002", "signal_junction-ego_001", "0_000"]) assert.equal(shortId(id), id);
});

test("of a long id of an object the beginning is shown", () => {
  assert.equal(shortTrack("c1958768d48640948f6053d04cffd35b"), "c1958768…");
  assert.equal(shortTrack("walker_3"), "walker_3");
});
