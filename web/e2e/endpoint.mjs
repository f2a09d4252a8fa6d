// A language model by script: answers OpenAI-compatible chat completions on a port of this machine, and misbehaves
// where the script says so. Knows nothing of the page.
import { createServer } from "node:http";

/** All texts of a request's messages. */
const textOf = (body) =>
  body.messages.flatMap((m) => (typeof m.content === "string" ? [m.content] : m.content.filter((p) => p.type === "text").map((p) => p.text))).join("\n");

/**
 * Starts it. `answer(form, text)` gives the answer to a request that asks for `form`; `faults` are the first replies,
 * one after the other: `{ status, headers, body }`, or null for a good one.
 */
export async function endpoint(answer, faults = []) {
  const seen = [];
  let gate = Promise.resolve();
  const server = createServer(async (request, response) => {
    let text = "";
    for await (const chunk of request) text += chunk;
    const body = JSON.parse(text);
    const form = body.response_format?.json_schema?.name ?? "";
    const fault = faults[seen.length];
    seen.push({ form, authorization: request.headers.authorization, text: textOf(body) });
    await gate;
    if (fault) {
      response.writeHead(fault.status, { "content-type": "application/json", ...fault.headers });
      return response.end(fault.body);
    }
    const said = answer(form, textOf(body));
    const message = said.refusal ? { role: "assistant", content: null, refusal: said.refusal } : { role: "assistant", content: JSON.stringify(said) };
    response.writeHead(200, { "content-type": "application/json" });
    response.end(JSON.stringify({ choices: [{ index: 0, message, finish_reason: "stop" }], usage: { prompt_tokens: 1000, completion_tokens: 200 } }));
  });
  await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
  return {
    url: `http://127.0.0.1:${server.address().port}/v1`,
    seen,
    /** Requests from now on wait; the function that is returned lets them go on. */
    hold() {
      let open;
      gate = new Promise((go) => (open = go));
      return open;
    },
    close: () => new Promise((closed) => server.close(closed)),
  };
}
