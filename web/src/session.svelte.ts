// Who is signed in. One value for the whole page; every screen reads it, only these functions change it.
import { api } from "./api/calls.ts";
import { ApiError } from "./api/client.ts";
import type { Returned, Session, User } from "./api/types.ts";
import { CALLBACK, replace, requery } from "./route.svelte.ts";
import { speak } from "./text/text.svelte.ts";

/** `loading` until the server has answered once; `away` when it could not be reached. */
export const session = $state<{
  status: "loading" | "away" | "setup" | "out" | "in";
  user: User | null;
  /** Name of the identity provider at which one can sign in too. */
  provider: string | null;
  /** Where to sign out there as well, after signing out here. */
  providerSignOut: string | null;
}>({ status: "loading", user: null, provider: null, providerSignOut: null });

/** Why coming back from the identity provider led nowhere; told by the screen that shows next. */
export const comingBack = $state<{ error: unknown }>({ error: null });

/** Where one was before going to the provider; this tab's alone. */
const BEFORE = "whyroad.before";

function take(s: Session): void {
  session.user = s.user ?? null;
  session.provider = s.provider ?? null;
  session.status = s.user ? "in" : s.first_run ? "setup" : "out";
}

/** The language that the account was made with holds until this browser was told another. */
function speakTheirs(): void {
  if (session.user && !localStorage.getItem("whyroad.lang") && (session.user.lang === "zh" || session.user.lang === "en")) {
    speak(session.user.lang);
  }
}

export async function open(): Promise<void> {
  session.status = "loading";
  const returned = whatCameBack();
  try {
    const before = await api.session();
    if (!returned) return take(before);
    try {
      take(await api.finishAtProvider(returned));
      session.providerSignOut = null;
      speakTheirs();
    } catch (error) {
      comingBack.error = error;
      take(before);
    }
  } catch {
    session.status = "away";
  }
}

/** What the identity provider sent the browser back with. It serves once, so it goes from the address at once. */
function whatCameBack(): Returned | null {
  if (location.pathname !== CALLBACK) return null;
  const query = new URLSearchParams(location.search);
  const before = sessionStorage.getItem(BEFORE) ?? "/";
  sessionStorage.removeItem(BEFORE);
  replace(before);
  const part = (name: string): string | null => query.get(name);
  return { state: part("state") ?? "", code: part("code"), iss: part("iss"), error: part("error") };
}

export async function signIn(name: string, password: string): Promise<void> {
  take(await api.signIn(name, password));
  session.providerSignOut = null;
  speakTheirs();
}

/** Goes to the identity provider: to sign in, or to let who is signed in do so there from now on. */
export async function goToProvider(purpose: "sign_in" | "link"): Promise<void> {
  const url = await api.beginAtProvider(purpose);
  sessionStorage.setItem(BEFORE, location.pathname + location.search);
  location.assign(url);
}

/** Makes the first administrator. A service beyond one's own machine wants the token from the address that it printed. */
export async function setup(first: { name: string; display: string; password: string; lang: string }): Promise<void> {
  const token = new URLSearchParams(location.search).get("setup");
  take(await api.setup(token ? { ...first, token } : first));
  // The token has done its work and is nobody else's business.
  if (token) requery("");
}

export async function signOut(): Promise<void> {
  const { provider_sign_out } = await api.signOut();
  await open();
  session.providerSignOut = provider_sign_out ?? null;
}

/** A session that ended while the page was open: back to the door, the address kept. */
export function ended(error: unknown): boolean {
  // At the door a 401 is the answer to a wrong password.
  if (!(error instanceof ApiError) || error.status !== 401 || session.status !== "in") return false;
  session.user = null;
  session.status = "out";
  return true;
}
