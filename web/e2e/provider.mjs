// A real OpenID provider for the test: `oidc-provider`, which the OpenID Foundation has certified. It asks for any
// login and any password, and for consent, on pages of its own.
import { createServer } from "node:http";

export const CLIENT = { id: "whyroad", secret: "e2e secret/+&" };

/** Whose e-mail address the provider has verified; everybody has one. */
const VERIFIED = ["li"];

/** A free port of this machine. */
export async function freePort() {
  const server = createServer();
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  const { port } = server.address();
  await new Promise((done) => server.close(done));
  return port;
}

/** A provider for the service at `service`. `asked` fills with what came to its token endpoint. */
export async function provide(service) {
  const port = await freePort();
  const issuer = `http://127.0.0.1:${port}`;
  // It warns on the console that its pages, keys and store are made for trying out, as here.
  const { warn, info } = console;
  console.warn = console.info = () => {};
  const { Provider } = await import("oidc-provider");
  const provider = new Provider(issuer, {
    clients: [
      {
        client_id: CLIENT.id,
        client_secret: CLIENT.secret,
        redirect_uris: [`${service}/oidc/callback`],
        post_logout_redirect_uris: [`${service}/`],
        response_types: ["code"],
        grant_types: ["authorization_code"],
      },
    ],
    pkce: { required: () => true },
    // As the standard has it: scopes are answered at the userinfo endpoint, not in the token.
    conformIdTokenClaims: true,
    claims: { openid: ["sub"], email: ["email", "email_verified"], profile: ["name", "preferred_username"] },
    ttl: { AccessToken: 600, AuthorizationCode: 60, Grant: 600, IdToken: 600, Interaction: 600, Session: 600 },
    cookies: { keys: ["only for this test"] },
    findAccount: (_, id) => ({
      accountId: id,
      claims: () => ({ sub: id, name: id, preferred_username: id, email: `${id}@example.com`, email_verified: VERIFIED.includes(id) }),
    }),
  });
  const answer = provider.callback();
  const server = createServer((request, response) => void answer(request, response));
  await new Promise((done) => server.listen(port, "127.0.0.1", done));
  Object.assign(console, { warn, info });
  const faults = [];
  provider.on("server_error", (_, error) => faults.push(error));
  return { issuer, faults, stop: () => new Promise((done) => (server.closeAllConnections(), server.close(done))) };
}
