// The projects of the reader and the framework's names: asked for once, used by many screens.
import { api } from "./api/calls.ts";
import type { Project } from "./api/types.ts";

export const known = $state<{ items: Project[]; loaded: boolean }>({ items: [], loaded: false });

export async function loadProjects(): Promise<void> {
  known.items = await api.projects();
  known.loaded = true;
}

/** Puts a changed project in its place, so that the bar and the lists say what the server now holds. */
export function changed(project: Project): void {
  const at = known.items.findIndex((p) => p.id === project.id);
  if (at >= 0) known.items[at] = project;
  else known.items.push(project);
}
