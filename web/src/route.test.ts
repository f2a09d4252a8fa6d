// Addresses: every screen has one, and every address has at most one screen.
import assert from "node:assert/strict";
import { test } from "vitest";
import { pathOf, routeOf, type Route } from "./route.svelte.ts";

test("every screen's address is routeOf back as that screen", () => {
  const all: Route[] = [
    { screen: "projects" },
    { screen: "project", project: "p1" },
    ...(["tasks", "dashboard", "analytics", "members", "exchange"] as const).map((screen) => ({ screen, project: "a b/ü%" })),
    { screen: "label", task: "t/1" },
    { screen: "users" },
    { screen: "settings" },
  ];
  for (const route of all) assert.deepEqual(routeOf(pathOf(route)), route);
});

test("other addresses are no screen", () => {
  for (const path of ["/tasks", "/tasks/1/2", "/projects/p/nothing", "/projects/p/tasks/1", "/users/1", "/x"]) {
    assert.deepEqual(routeOf(path), { screen: "unknown" }, path);
  }
});
