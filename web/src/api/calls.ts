// Every route that the page calls, with its types: the one place where a URL and a type meet.
import { call, forget, LONG_MS, query, Raw, setCsrf } from "./client.ts";
import type * as T from "./types.ts";

const id = encodeURIComponent;

async function session(method: "GET" | "POST", path: string, body?: unknown): Promise<T.Session> {
  const { data } = await call<T.Session>(method, path, body);
  if (method !== "GET") forget();
  setCsrf(data.csrf);
  return data;
}

export const api = {
  session: () => session("GET", "/session"),
  signIn: (name: string, password: string) => session("POST", "/session", { name, password }),
  setup: (first: { name: string; display: string; password: string; lang: string; token?: string }) =>
    session("POST", "/setup", first),
  signOut: async () => (await call<T.SignedOut>("DELETE", "/session")).data,
  /** The address at the identity provider, to which the browser goes next. */
  beginAtProvider: async (purpose: "sign_in" | "link") =>
    (await call<T.ProviderAddress>("POST", "/oidc/begin", { purpose })).data.url,
  finishAtProvider: (returned: T.Returned) => session("POST", "/oidc/finish", returned),
  identities: async () => (await call<{ items: T.Identity[] }>("GET", "/identities")).data.items,
  unlink: (identity: string) => call("DELETE", `/identities/${id(identity)}`),

  users: async () => (await call<{ items: T.User[] }>("GET", "/users")).data.items,
  newUser: async (user: { name: string; display: string; password: string | null; email: string | null; admin: boolean; lang: string }) =>
    (await call<T.User>("POST", "/users", user)).data,
  changeUser: async (u: string, change: Partial<T.UserChange>) =>
    (await call<T.User>("PATCH", `/users/${id(u)}`, change)).data,
  tokens: async () => (await call<{ items: T.Token[] }>("GET", "/tokens")).data.items,
  newToken: async (name: string) => (await call<T.Token>("POST", "/tokens", { name })).data,
  dropToken: (token: string) => call("DELETE", `/tokens/${id(token)}`),

  projects: async () => (await call<{ items: T.Project[] }>("GET", "/projects")).data.items,
  newProject: async (p: { name: string; guide?: string; quota?: Record<string, number>; settings?: Partial<T.Settings> }) => (await call<T.Project>("POST", "/projects", p)).data,
  project: async (p: string) => (await call<T.Project>("GET", `/projects/${id(p)}`)).data,
  changeProject: async (p: string, change: Partial<T.ProjectChange>) =>
    (await call<T.Project>("PATCH", `/projects/${id(p)}`, change)).data,
  members: async (p: string) => (await call<{ items: T.Member[] }>("GET", `/projects/${id(p)}/members`)).data.items,
  setMember: async (p: string, m: { user: string; roles: T.Role[]; skills: string[]; languages?: string[] }) =>
    (await call<{ items: T.Member[] }>("POST", `/projects/${id(p)}/members`, m)).data.items,
  dashboard: async (p: string) => (await call<T.Dashboard>("GET", `/projects/${id(p)}/dashboard`)).data,

  tasks: async (p: string, filter: Record<string, string | boolean | undefined>) =>
    (await call<T.Tasks>("GET", `/projects/${id(p)}/tasks${query(filter)}`)).data,
  mined: async () => (await call<{ items: T.MinedFolder[] }>("GET", "/mined")).data.items,
  makeTasks: async (p: string, body: Partial<T.CreateTasks>) =>
    (await call<T.Created>("POST", `/projects/${id(p)}/tasks:create`, body, LONG_MS)).data,
  /** Null when the queue has nothing. */
  next: async (p: string, kind: T.Kind): Promise<T.Task | null> => {
    const { data, status } = await call<T.Task>("POST", `/projects/${id(p)}/tasks:next`, { kind });
    return status === 204 ? null : data;
  },

  /** Why `next` has nothing. */
  whyNothing: async (p: string, kind: T.Kind) =>
    (await call<{ reasons: T.QueueReason[] }>("GET", `/projects/${id(p)}/queue${query({ kind })}`)).data.reasons,

  task: async (t: string) => (await call<T.Task>("GET", `/tasks/${id(t)}`)).data,
  lease: async (t: string, action: "take" | "heartbeat" | "release", fence?: number | null) =>
    (await call<T.Lease>("POST", `/tasks/${id(t)}/lease`, { action, fence: fence ?? null })).data,
  assign: async (t: string, user: string | null) => (await call<T.Task>("POST", `/tasks/${id(t)}/assign`, { user })).data,
  save: async (t: string, fence: number, base_version: number, changes: T.FieldChange[]) =>
    (await call<T.DraftSaved>("PATCH", `/tasks/${id(t)}/draft`, { fence, base_version, changes })).data,
  act: async (
    t: string,
    action: { fence: number | null; action: T.ActionName; reason?: string | null; comments?: T.NewComment[]; seq?: number },
  ) => (await call<T.Task>("POST", `/tasks/${id(t)}/actions`, action)).data,
  /** All of it, page by page. */
  history: async (t: string): Promise<T.HistoryEntry[]> => {
    const all: T.HistoryEntry[] = [];
    let cursor: string | undefined;
    do {
      const { items, next } = (await call<{ items: T.HistoryEntry[]; next?: string | null }>("GET", `/tasks/${id(t)}/history${query({ cursor })}`)).data;
      all.push(...items);
      cursor = next ?? undefined;
    } while (cursor !== undefined);
    return all;
  },
  /** The draft as it was after an entry of the history; 1 is the task's making. */
  draftAt: async (t: string, seq: number) => (await call<T.DraftAt>("GET", `/tasks/${id(t)}/history/${seq}`)).data.draft,
  validate: async (t: string, label: unknown) => (await call<{ findings: T.Finding[] }>("POST", `/tasks/${id(t)}/validate`, { label })).data.findings,
  overlap: async (t: string) => (await call<T.Overlap>("GET", `/tasks/${id(t)}/overlap`)).data.items,
  comment: async (t: string, c: T.NewComment) => (await call<T.Comment>("POST", `/tasks/${id(t)}/comments`, c)).data,
  resolve: async (c: string) => (await call<T.Comment>("POST", `/comments/${id(c)}/resolve`, {})).data,

  scene: async (t: string) => (await call<T.SceneView>("GET", `/tasks/${id(t)}/scene`, undefined, LONG_MS)).data,
  map: async (t: string) => (await call<T.MapView>("GET", `/tasks/${id(t)}/map`)).data,
  framework: async () => (await call<T.FrameworkView>("GET", "/framework")).data,

  exportUrl: (p: string, q: { format: "labels" | "tasks"; version?: string }) => `/api/v1/projects/${id(p)}/export${query(q)}`,
  importLines: async (p: string, lines: string) =>
    (await call<T.Imported>("POST", `/projects/${id(p)}/import`, new Raw(lines, "application/x-ndjson"), LONG_MS)).data,
  webhooks: async (p: string) => (await call<{ items: T.Webhook[] }>("GET", `/projects/${id(p)}/webhooks`)).data.items,
  newWebhook: async (p: string, hook: { url: string; events: string[] }) =>
    (await call<T.Webhook>("POST", `/projects/${id(p)}/webhooks`, hook)).data,
  dropWebhook: (w: string) => call("DELETE", `/webhooks/${id(w)}`),
};
