// What was typed is neither lost nor doubled when changes are joined, sent again or applied to another draft.
import assert from "node:assert/strict";
import { test } from "vitest";
import { apply, join, needed, rooted } from "./changes.ts";
import { pointer, read, write } from "./pointer.ts";

test("pointers read and write, and leave the original alone", () => {
  const doc = { a: [{ b: 1 }, { b: 2 }], "x/y": { "~": 3 } };
  assert.equal(read(doc, "/a/1/b"), 2);
  assert.equal(read(doc, "/x~1y/~0"), 3);
  assert.equal(pointer("x/y", "~"), "/x~1y/~0");
  assert.deepEqual(write(doc, "/a/0/b", 9), { ...doc, a: [{ b: 9 }, { b: 2 }] });
  assert.deepEqual(write(doc, "/a/0", undefined), { ...doc, a: [{ b: 2 }] });
  assert.deepEqual(doc.a[0], { b: 1 });
});

test("a later write of a field or of its parent replaces the earlier one; of a sibling it does not", () => {
  let c = join([], { path: "/a/b", value: 1 });
  c = join(c, { path: "/ab", value: 5 });
  c = join(c, { path: "/a/b", value: 2 });
  assert.deepEqual(c, [{ path: "/ab", value: 5 }, { path: "/a/b", value: 2 }]);
  c = join(c, { path: "/a", value: { b: 3 } });
  assert.deepEqual(c, [{ path: "/ab", value: 5 }, { path: "/a", value: { b: 3 } }]);
  assert.deepEqual(apply({ a: null, ab: 0 }, c), { a: { b: 3 }, ab: 5 });
});

test("what the server has already is not sent again", () => {
  assert.deepEqual(needed({ a: 1, b: { c: [1] } }, [{ path: "/a", value: 1 }, { path: "/b/c", value: [1, 2] }]), [
    { path: "/b/c", value: [1, 2] },
  ]);
});

test("a field whose parent is not there is sent as the parent", () => {
  assert.deepEqual(rooted({}, { path: "/causes/lateral", value: { components: ["c1"] } }), {
    path: "/causes",
    value: { lateral: { components: ["c1"] } },
  });
  assert.deepEqual(rooted({ causes: {} }, { path: "/causes/lateral", value: 1 }), { path: "/causes/lateral", value: 1 });
});
