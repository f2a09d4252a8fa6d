// The signed-in user. One value for the whole page; every screen reads it, only these functions change it.
import * as api from "./api/calls.generated.ts";
import { ApiError, clearCache, onStaleSession, setCsrf } from "./api/client.ts";
import type { Returned, Session, User } from "./api/types.ts";
import { CALLBACK, replace, replaceQuery } from "./route.svelte.ts";
import { setLanguage } from "./text/text.svelte.ts";

/** `loading` until the service has answered once; `away` when it could not be reached. */
export const session = $state<{
  status: "loading" | "away" | "setup" | "out" | "in";
  user: User | null;
  /** Name of the identity provider; null without one. */
  provider: string | null;
  /** The first account needs the token that the service printed, and the address does not have it. */
  asksToken: boolean;
  /** Address at the provider that signs out there as well; set after signing out here. */
  providerSignOut: string | null;
  /** The session ended while the page was in use: in another tab, or by its time. */
  ended: boolean;
}>({ status: "loading", user: null, provider: null, asksToken: false, providerSignOut: null, ended: false });

/** Why signing in at the identity provider failed; shown by the next screen. */
export const providerReturn = $state<{ error: unknown }>({ error: null });

/** In this tab's storage: the address to return to from the provider. */
const RETURN_TO = "whyroad.before";

function adopt(s: Session): void {
  setCsrf(s.csrf);
  session.user = s.user ?? null;
  session.provider = s.provider ?? null;
  session.asksToken = s.setup_token === true && !tokenInAddress();
  session.status = s.user ? "in" : s.first_run ? "setup" : "out";
}

/** Uses the language of the account unless another one was chosen in this browser. */
function useAccountLanguage(): void {
  if (session.user && !localStorage.getItem("whyroad.lang") && (session.user.lang === "zh" || session.user.lang === "en")) {
    setLanguage(session.user.lang);
  }
}

export async function open(): Promise<void> {
  session.status = "loading";
  const returned = providerAnswer();
  try {
    const before = await api.getSession();
    setCsrf(before.csrf);
    if (!returned) return adopt(before);
    try {
      signedIn(await api.postOidcFinish(returned));
    } catch (error) {
      providerReturn.error = error;
      adopt(before);
    }
  } catch {
    session.status = "away";
  }
}

/** What the identity provider added to the address. It is valid once, so it is removed from the address. */
function providerAnswer(): Returned | null {
  if (location.pathname !== CALLBACK) return null;
  const query = new URLSearchParams(location.search);
  const returnTo = sessionStorage.getItem(RETURN_TO) ?? "/";
  sessionStorage.removeItem(RETURN_TO);
  replace(returnTo);
  const part = (name: string): string | null => query.get(name);
  return { state: part("state") ?? "", code: part("code"), iss: part("iss"), error: part("error") };
}

/** A new session: what another user read is no longer valid. */
function signedIn(s: Session): void {
  clearCache();
  adopt(s);
  session.providerSignOut = null;
  session.ended = false;
  useAccountLanguage();
}

export async function signIn(name: string, password: string): Promise<void> {
  signedIn(await api.postSession({ name, password }));
}

/** Goes to the identity provider: to sign in, or to link the signed-in user to an identity there. */
export async function goToProvider(purpose: "sign_in" | "link"): Promise<void> {
  const { url } = await api.postOidcBegin({ purpose });
  sessionStorage.setItem(RETURN_TO, location.pathname + location.search);
  location.assign(url);
}

function tokenInAddress(): string | null {
  return new URLSearchParams(location.search).get("setup");
}

/**
 * Creates the first administrator. A service that is reachable from other machines requires the token of the address it
 * printed; `typed` is used where the address of the page does not have it.
 */
export async function setup(
  first: { name: string; display: string; password: string; lang: string },
  typed: string,
): Promise<void> {
  const token = tokenInAddress() ?? typed.trim();
  signedIn(await api.postSetup(token ? { ...first, token } : first));
  // The token is used up and must not stay in the address.
  if (token) replaceQuery("");
}

/** Who signs in next begins at their projects: the task that was open here may show what they must not see. */
export async function signOut(): Promise<void> {
  const { provider_sign_out } = await api.deleteSession();
  clearCache();
  replace("/");
  await open();
  session.providerSignOut = provider_sign_out ?? null;
}

// Another tab of this browser signed out, or in again.
onStaleSession(async () => {
  if (session.status !== "in") return false;
  const now = await api.getSession();
  if (now.user && now.user.id === session.user?.id) {
    setCsrf(now.csrf);
    return true;
  }
  // The sign-in is shown at the same address. What was not saved stays in this browser and is sent after it.
  setCsrf(now.csrf);
  session.user = null;
  session.status = "out";
  session.ended = true;
  return false;
});

/** Handles a session that ended while the page was open: shows the sign-in, keeps the address. */
export function sessionEnded(error: unknown): boolean {
  // While signing in, a 401 is the answer to a wrong password.
  if (!(error instanceof ApiError) || error.status !== 401 || session.status !== "in") return false;
  session.user = null;
  session.status = "out";
  session.ended = true;
  return true;
}
