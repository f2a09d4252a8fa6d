// The screen of an address. Addresses are plain paths, so that a link to a task can be shared.

export type Route =
  | { screen: "projects" }
  | { screen: "tasks" | "dashboard" | "analytics" | "members" | "exchange" | "episodes" | "project"; project: string }
  | { screen: "label"; task: string }
  | { screen: "users" | "settings" | "unknown" };

/** The address to which the identity provider redirects; not a screen, it is left at once. */
export const CALLBACK = "/oidc/callback";

const PROJECT_SCREENS = ["tasks", "dashboard", "analytics", "members", "exchange", "episodes"] as const;

/** The screen of a path. `/projects/<id>` is the project's settings. */
export function routeOf(path: string): Route {
  const parts = path.split("/").filter(Boolean).map(decodeURIComponent);
  const [head, id, word] = parts;
  if (head === undefined) return { screen: "projects" };
  if (head === "tasks" && id && parts.length === 2) return { screen: "label", task: id };
  if (head === "projects" && parts.length === 1) return { screen: "projects" };
  if (head === "projects" && id && parts.length <= 3) {
    if (word === undefined) return { screen: "project", project: id };
    const screen = PROJECT_SCREENS.find((s) => s === word);
    if (screen) return { screen, project: id };
  }
  if ((head === "users" || head === "settings") && parts.length === 1) return { screen: head };
  return { screen: "unknown" };
}

/** The path of a screen: what `read` reads. */
export function pathOf(to: Route): string {
  switch (to.screen) {
    case "projects":
      return "/";
    case "label":
      return `/tasks/${encodeURIComponent(to.task)}`;
    case "project":
      return `/projects/${encodeURIComponent(to.project)}`;
    case "tasks":
    case "dashboard":
    case "analytics":
    case "members":
    case "exchange":
    case "episodes":
      return `/projects/${encodeURIComponent(to.project)}/${to.screen}`;
    default:
      return `/${to.screen}`;
  }
}

const here = (): { path: string; query: string } => ({ path: location.pathname, query: location.search });

/** The current address; follows the browser's Back and Forward. */
export const currentLocation = $state(typeof location === "undefined" ? { path: "/", query: "" } : here());

function follow(): void {
  Object.assign(currentLocation, here());
}

/** Opens a screen; `query` begins with `?` or is empty. */
export function go(to: Route | string, query = ""): void {
  history.pushState(null, "", (typeof to === "string" ? to : pathOf(to)) + query);
  follow();
}

/** Replaces the current path: the browser's Back skips it. */
export function replace(path: string): void {
  history.replaceState(null, "", new URL(path, location.origin).pathname + new URL(path, location.origin).search);
  follow();
}

/** Changes the query of this screen without an entry in the browser's history, for filters. */
export function replaceQuery(query: string): void {
  history.replaceState(null, "", currentLocation.path + query);
  follow();
}

/** Makes ordinary links change the screen without a reload. Call once. */
export function startRouter(): void {
  addEventListener("popstate", follow);
  document.addEventListener("click", (e) => {
    const link = e.target instanceof Element ? e.target.closest("a[href]") : null;
    if (!(link instanceof HTMLAnchorElement) || e.defaultPrevented || e.button !== 0) return;
    if (e.ctrlKey || e.metaKey || e.shiftKey || e.altKey || link.target || link.hasAttribute("download")) return;
    // Links within the page, such as "skip to content", are left to the browser.
    const inside = link.getAttribute("href")?.startsWith("#") ?? true;
    if (inside || link.origin !== location.origin || link.pathname.startsWith("/api/")) return;
    e.preventDefault();
    go(link.pathname, link.search);
  });
}
