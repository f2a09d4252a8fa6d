// Kappa of a few labels is not shown as a number.
import assert from "node:assert/strict";
import { render } from "@testing-library/svelte";
import { test } from "vitest";
import type { Agreement as View } from "../../api/types.ts";
import Agreement from "./Agreement.svelte";

const of = (pairs: number): View =>
  ({ groups: pairs, pairs, longitudinal_kappa: 0.004, lateral_kappa: -1, longitudinal_fleiss: 0.5, lateral_fleiss: null, keyframe_median_s: 0.1, keyframe_worst_s: 0.2, by_pair: [] }) as unknown as View;

test("few labels have no kappa, many have one", () => {
  const few = render(Agreement, { agreement: of(1) });
  assert.doesNotMatch(few.container.textContent ?? "", /0\.00|1\.00/);
  assert.match(few.container.textContent ?? "", /n = 1/);
  few.unmount();
  const many = render(Agreement, { agreement: of(40) });
  assert.match(many.container.textContent ?? "", /0\.00[^]*−1\.00/);
});
