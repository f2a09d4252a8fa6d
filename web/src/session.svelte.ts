// Who is signed in. One value for the whole page; every screen reads it, only these functions change it.
import { api } from "./api/calls.ts";
import { ApiError } from "./api/client.ts";
import type { Session, User } from "./api/types.ts";
import { requery } from "./route.svelte.ts";
import { speak } from "./text/text.svelte.ts";

/** `loading` until the server has answered once; `away` when it could not be reached. */
export const session = $state<{ status: "loading" | "away" | "setup" | "out" | "in"; user: User | null }>({
  status: "loading",
  user: null,
});

function take(s: Session): void {
  session.user = s.user ?? null;
  session.status = s.user ? "in" : s.first_run ? "setup" : "out";
}

export async function open(): Promise<void> {
  session.status = "loading";
  try {
    take(await api.session());
  } catch {
    session.status = "away";
  }
}

export async function signIn(name: string, password: string): Promise<void> {
  take(await api.signIn(name, password));
  // The language that the account was made with holds until this browser was told another.
  if (session.user && !localStorage.getItem("whyroad.lang") && (session.user.lang === "zh" || session.user.lang === "en")) {
    speak(session.user.lang);
  }
}

/** Makes the first administrator. A service beyond one's own machine wants the token from the address that it printed. */
export async function setup(first: { name: string; display: string; password: string; lang: string }): Promise<void> {
  const token = new URLSearchParams(location.search).get("setup");
  take(await api.setup(token ? { ...first, token } : first));
  // The token has done its work and is nobody else's business.
  if (token) requery("");
}

export async function signOut(): Promise<void> {
  await api.signOut();
  await open();
}

/** A session that ended while the page was open: back to the door, the address kept. */
export function ended(error: unknown): boolean {
  // At the door a 401 is the answer to a wrong password.
  if (!(error instanceof ApiError) || error.status !== 401 || session.status !== "in") return false;
  session.user = null;
  session.status = "out";
  return true;
}
