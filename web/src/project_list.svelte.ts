// The user's projects: loaded once, used by many screens.
import * as api from "./api/calls.generated.ts";
import type { Project } from "./api/types.ts";

export const projectList = $state<{ items: Project[]; loaded: boolean }>({ items: [], loaded: false });

export async function loadProjects(): Promise<void> {
  projectList.items = (await api.getProjects()).items;
  projectList.loaded = true;
}

/** Replaces a project in the list after a change. */
export function updateProject(project: Project): void {
  const at = projectList.items.findIndex((p) => p.id === project.id);
  if (at >= 0) projectList.items[at] = project;
  else projectList.items.push(project);
}
