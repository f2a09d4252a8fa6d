// A form in a dialog: sent once, by button or Ctrl+Enter, not while it cannot be, and its error is shown in it.
import { fireEvent, render, screen, waitFor } from "@testing-library/svelte";
import assert from "node:assert/strict";
import { tick } from "svelte";
import { beforeEach, test } from "vitest";
import { ApiError } from "../api/client.ts";
import { RequestState } from "../request_state.svelte.ts";
import { setLanguage } from "../text/text.svelte.ts";
import NameForm from "../testing/NameForm.svelte";

let sent: string[];
let closed: number;
let request: RequestState;
/** Answers the request that the name "slow" makes. */
let answer: () => void;

/** The name "slow" is sent when a first step is over, as unsaved changes are saved before an action. */
async function submit(name: string): Promise<void> {
  sent.push(name);
  if (name !== "slow") return;
  await tick();
  await request.run(() => new Promise<void>((done) => (answer = done)));
}

beforeEach(() => {
  setLanguage("en");
  sent = [];
  closed = 0;
  request = new RequestState();
  render(NameForm, { request, submit, close: () => closed++ });
});

const field = (): HTMLElement => screen.getByLabelText("Name");
const button = (): HTMLButtonElement => screen.getByRole("button", { name: "Create" });

test("the dialog has its title, and sends by its button", async () => {
  assert.ok(screen.getByRole("dialog", { name: "New person" }));
  await fireEvent.input(field(), { target: { value: "anna" } });
  await fireEvent.click(button());
  assert.deepEqual(sent, ["anna"]);
});

test("Ctrl+Enter sends from a text area; Enter alone and composing do not", async () => {
  await fireEvent.input(field(), { target: { value: "anna" } });
  await fireEvent.keyDown(field(), { key: "Enter" });
  await fireEvent.keyDown(field(), { key: "Enter", ctrlKey: true, isComposing: true });
  assert.deepEqual(sent, []);
  await fireEvent.keyDown(field(), { key: "Enter", ctrlKey: true });
  assert.deepEqual(sent, ["anna"]);
});

test("an empty required field is not sent", async () => {
  await fireEvent.keyDown(field(), { key: "Enter", ctrlKey: true });
  assert.deepEqual(sent, []);
});

test("Ctrl+Enter while another request runs sends when that has ended, once", async () => {
  await fireEvent.input(field(), { target: { value: "anna" } });
  let finish = (): void => {};
  const running = request.run(() => new Promise<void>((done) => (finish = done)));
  for (let n = 0; n < 2; n++) await fireEvent.keyDown(field(), { key: "Enter", ctrlKey: true });
  assert.deepEqual(sent, []);
  finish();
  await running;
  await tick();
  assert.deepEqual(sent, ["anna"]);
});

test("its own request is not sent again by pressing again", async () => {
  await fireEvent.input(field(), { target: { value: "slow" } });
  for (let n = 0; n < 3; n++) await fireEvent.keyDown(field(), { key: "Enter", ctrlKey: true });
  assert.deepEqual(sent, ["slow"]);
  answer();
  await waitFor(() => assert.ok(!request.busy));
  assert.deepEqual(sent, ["slow"]);
  await fireEvent.keyDown(field(), { key: "Enter", ctrlKey: true });
  assert.deepEqual(sent, ["slow", "slow"], "what failed or was refused can be sent again");
  answer();
});

test("it cannot be sent while it is disabled", async () => {
  await fireEvent.input(field(), { target: { value: "nobody" } });
  assert.ok(button().disabled);
  await fireEvent.input(field(), { target: { value: "anna" } });
  assert.ok(!button().disabled);
});

test("what the service refused is shown in the reader's language", async () => {
  await request.run(() => Promise.reject(new ApiError(409, "user.exists", "用户名已存在", "The user name is taken", {})));
  assert.match((await screen.findByRole("alert")).textContent, /The user name is taken/);
  setLanguage("zh");
  assert.ok(await screen.findByText("用户名已存在"));
});

test("Cancel and the cross close it", async () => {
  await fireEvent.click(screen.getByRole("button", { name: "Cancel" }));
  assert.equal(closed, 1);
  await fireEvent.click(screen.getByRole("button", { name: "Close" }));
  assert.equal(closed, 2);
});
