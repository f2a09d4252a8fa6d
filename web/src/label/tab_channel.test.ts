// Two tabs of one browser that show the same task. The channel is the browser's own (Node has it, too).
import assert from "node:assert/strict";
import { afterEach, test, vi } from "vitest";
import { TabChannel } from "./tab_channel.svelte.ts";

const open: TabChannel[] = [];
afterEach(() => open.splice(0).forEach((tab) => tab.close()));

function tab(task: string, saved: (version: number) => void = () => {}): TabChannel {
  const channel = new TabChannel();
  channel.open(task, saved);
  open.push(channel);
  return channel;
}

test("each tab learns of the other, and that it has left", async () => {
  const first = tab("t1");
  const second = tab("t1");
  const elsewhere = tab("t2");
  await vi.waitFor(() => assert.deepEqual([first.openElsewhere, second.openElsewhere], [true, true]));
  assert.equal(elsewhere.openElsewhere, false);
  second.close();
  await vi.waitFor(() => assert.equal(first.openElsewhere, false));
});

test("what one tab saved is announced to the other, not to itself", async () => {
  const heard: string[] = [];
  const first = tab("t1", (version) => heard.push(`first ${version}`));
  tab("t1", (version) => heard.push(`second ${version}`));
  first.announceSaved(7);
  await vi.waitFor(() => assert.deepEqual(heard, ["second 7"]));
});
