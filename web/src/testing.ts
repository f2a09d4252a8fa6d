// Stands in for the browser where modules look at it as soon as they are loaded. Only tests import it, and before all else.

export const storage = new Map<string, string>();

Object.assign(globalThis, {
  localStorage: {
    getItem: (k: string) => storage.get(k) ?? null,
    setItem: (k: string, v: string) => storage.set(k, v),
    removeItem: (k: string) => storage.delete(k),
  },
  document: { documentElement: { lang: "", dataset: {} } },
  cancelAnimationFrame: () => {},
});
if (!("navigator" in globalThis)) Object.assign(globalThis, { navigator: { language: "zh-CN" } });
