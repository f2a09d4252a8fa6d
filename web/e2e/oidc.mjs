// Signing in at a real OpenID provider, with a service of its own: by keyboard, with an account that an administrator
// gave the address; who has no verified address is refused; a signed-in user links their own identity; signing out
// there as well.
import assert from "node:assert/strict";
import { join } from "node:path";
import { checkAccessibility, person, signIn, tabTo } from "./people.mjs";
import { CLIENT, freePort, provide } from "./provider.mjs";
import { serve } from "./service.mjs";
import { shot } from "./shots.mjs";

const PASSWORD = "山高月小水落石出-赤壁";

async function setUp(day) {
  const port = await freePort();
  const url = `http://127.0.0.1:${port}`;
  const provider = await provide(url);
  const environment = {
    WHYROAD_OIDC_ISSUER: provider.issuer,
    WHYROAD_OIDC_CLIENT_ID: CLIENT.id,
    WHYROAD_OIDC_CLIENT_SECRET: CLIENT.secret,
    WHYROAD_OIDC_NAME: "城市通行证",
  };
  const service = await serve({ data: join(day.scratch, "oidc"), demo: day.demo, port, environment });
  day.oidc = { provider, service };
  const admin = await person(day.browser, url, { faults: day.faults });
  day.oidc.admin = admin;
  const { page } = admin;
  await page.getByLabel("用户名").fill("admin");
  await page.getByLabel("密码", { exact: true }).fill(PASSWORD);
  await page.getByLabel("再次输入密码").fill(PASSWORD);
  assert.equal(await page.getByRole("button", { name: /城市通行证/ }).count(), 0, "the first account is made here");
  await page.keyboard.press("Enter");
  await page.getByRole("link", { name: "用户" }).click();
  await page.getByRole("button", { name: "新建用户" }).first().click();
  const dialog = page.getByRole("dialog");
  await dialog.getByLabel("用户名").fill("liming");
  await dialog.getByLabel("显示名").fill("李明");
  // With an address no password is needed.
  await dialog.getByLabel("邮箱").fill("Li@example.com");
  await checkAccessibility(page, "a new user with an address");
  await dialog.getByRole("button", { name: "新建用户" }).click();
  await page.getByText("已创建用户 liming。").waitFor();
  await page.getByRole("cell", { name: "li@example.com" }).waitFor();
}

/** The provider's own pages: who, then whether the service may know. */
async function there(page, name) {
  await page.locator("input[name=login]").fill(name);
  await page.locator("input[name=password]").fill("any");
  await page.keyboard.press("Enter");
  await page.getByRole("button", { name: "Continue" }).click();
}

async function byKeyboard(day) {
  const someone = await person(day.browser, `${day.oidc.service.url}/settings`, { faults: day.faults });
  const { page } = someone;
  const button = page.getByRole("button", { name: "用 城市通行证 登录" });
  await button.waitFor();
  for (const theme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme: theme });
    await checkAccessibility(page, `the door with a provider, ${theme}`);
  }
  await page.emulateMedia({ colorScheme: "light" });
  await shot(day, page, "sign-in-provider");
  await tabTo(page, button);
  await page.keyboard.press("Enter");
  await page.waitForURL(`${day.oidc.provider.issuer}/interaction/**`);
  await there(page, "li");
  // Back where one wanted to be, and the code is not in the address.
  await page.locator("header .who").getByText("李明").waitFor();
  assert.equal(page.url(), `${day.oidc.service.url}/settings`);
  assert.equal(await page.evaluate(() => window.pointerPresses), 0, "all on our page by keyboard");
  await page.getByRole("cell", { name: "li@example.com" }).waitFor();
  await checkAccessibility(page, "settings with a linked identity");
  await shot(day, page, "settings-identity");
  // Going back does not lead into the used answer.
  await page.reload();
  await page.locator("header .who").getByText("李明").waitFor();
  // Its only way in stays.
  await page.getByRole("button", { name: "解除关联" }).click();
  await page.getByRole("alert").getByText(/唯一的登录方式/).waitFor();
  day.oidc.li = someone;
}

async function outThere(day) {
  const { page } = day.oidc.li;
  await page.getByRole("button", { name: "退出登录" }).click();
  const link = page.getByRole("link", { name: "同时退出 城市通行证" });
  await link.waitFor();
  await checkAccessibility(page, "signed out here, not there");
  await link.click();
  await page.waitForURL(`${day.oidc.provider.issuer}/**`);
  await page.getByRole("button", { name: "Yes, sign me out" }).click();
  await page.waitForURL(`${day.oidc.service.url}/`);
  await page.getByRole("button", { name: "用 城市通行证 登录" }).click();
  // The provider asks for the identity again: nobody is signed in as the previous user.
  await page.locator("input[name=login]").waitFor();
  await day.oidc.li.context.close();
}

async function stranger(day) {
  const someone = await person(day.browser, day.oidc.service.url, { faults: day.faults });
  const { page } = someone;
  await page.getByRole("button", { name: "用 城市通行证 登录" }).click();
  await there(page, "zhao");
  await page.getByRole("alert").getByText(/没有与此身份关联的账号/).waitFor();
  await page.getByRole("button", { name: "English" }).click();
  await page.getByRole("alert").getByText(/No account is linked to this identity/).waitFor();
  assert.equal(page.url(), `${day.oidc.service.url}/`);
  await checkAccessibility(page, "no account");
  await page.getByRole("button", { name: "中文" }).click();
  // A user who declines there returns and sees why.
  await page.context().clearCookies();
  await page.goto(day.oidc.service.url);
  await page.getByRole("button", { name: "用 城市通行证 登录" }).click();
  await page.getByRole("link", { name: "Cancel" }).click();
  await page.getByRole("alert").getByText(/未同意登录（access_denied）/).waitFor();
  await someone.context.close();
}

async function link(day) {
  const { page } = day.oidc.admin;
  await page.goto(`${day.oidc.service.url}/settings`);
  await page.getByRole("button", { name: "关联 城市通行证" }).click();
  await there(page, "boss");
  await page.getByRole("button", { name: "解除关联" }).waitFor();
  assert.equal(page.url(), `${day.oidc.service.url}/settings`);
  // From now on without a password.
  const fresh = await person(day.browser, day.oidc.service.url, { faults: day.faults });
  await fresh.page.getByRole("button", { name: "用 城市通行证 登录" }).click();
  await there(fresh.page, "boss");
  await fresh.page.locator("header .who").getByText("admin").waitFor();
  await fresh.context.close();
  await page.getByRole("button", { name: "解除关联" }).click();
  await page.getByRole("button", { name: "关联 城市通行证" }).waitFor();
  // The password works as before.
  const plain = await person(day.browser, day.oidc.service.url, { faults: day.faults });
  await signIn(plain.page, "admin", PASSWORD);
  await plain.context.close();
  await day.oidc.admin.context.close();
}

async function end(day) {
  assert.deepEqual(day.oidc.provider.faults, []);
  await day.oidc.provider.stop();
  // Without the provider the button says what is the matter, and the password goes on working.
  const someone = await person(day.browser, day.oidc.service.url, { faults: day.faults });
  await signIn(someone.page, "admin", PASSWORD);
  await someone.context.close();
  assert.equal(await day.oidc.service.stop(), "0");
}

export const oidc = [
  ["a service with a real OpenID provider; the administrator gives an account its address", setUp],
  ["somebody signs in at the provider by keyboard and is back where they wanted to be", byKeyboard],
  ["they sign out here and there", outThere],
  ["a user without an account, or who declines, sees why", stranger],
  ["the administrator links their own account, uses that, and unlinks it", link],
  ["without the provider the password goes on working", end],
];
