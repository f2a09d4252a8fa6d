// JSON pointers (RFC 6901) into a draft: read, write without changing the original, compose.

export type Json = null | boolean | number | string | Json[] | { [key: string]: Json };

export function parts(pointer: string): string[] {
  if (pointer === "") return [];
  return pointer.slice(1).split("/").map((p) => p.replaceAll("~1", "/").replaceAll("~0", "~"));
}

export function pointer(...segments: (string | number)[]): string {
  return segments.map((s) => `/${String(s).replaceAll("~", "~0").replaceAll("/", "~1")}`).join("");
}

/** The value at `at`; undefined without one. */
export function read(doc: Json | undefined, at: string): Json | undefined {
  let here: Json | undefined = doc;
  for (const key of parts(at)) {
    if (Array.isArray(here)) here = here[Number(key)];
    else if (here !== null && typeof here === "object") here = here[key];
    else return undefined;
  }
  return here;
}

/** A copy of `doc` with `value` at `at`; `undefined` removes the member. Missing objects on the path are created. */
export function write(doc: Json | undefined, at: string, value: Json | undefined): Json {
  return set(doc, parts(at), value) ?? null;
}

function set(doc: Json | undefined, path: string[], value: Json | undefined): Json | undefined {
  const [key, ...rest] = path;
  if (key === undefined) return value;
  if (Array.isArray(doc)) {
    const copy = [...doc];
    const child = set(copy[Number(key)], rest, value);
    if (child === undefined) copy.splice(Number(key), 1);
    else copy[Number(key)] = child;
    return copy;
  }
  const copy: { [key: string]: Json } = doc !== null && typeof doc === "object" ? { ...doc } : {};
  const child = set(copy[key], rest, value);
  if (child === undefined) delete copy[key];
  else copy[key] = child;
  return copy;
}

export function same(a: Json | undefined, b: Json | undefined): boolean {
  return canonical(a) === canonical(b);
}

/** Text with sorted keys, so that equal documents have equal text. */
function canonical(v: Json | undefined): string {
  if (v === undefined) return "";
  if (Array.isArray(v)) return `[${v.map(canonical).join()}]`;
  if (v !== null && typeof v === "object") {
    return `{${Object.keys(v).sort().map((k) => `${JSON.stringify(k)}:${canonical(v[k])}`).join()}}`;
  }
  return JSON.stringify(v);
}
