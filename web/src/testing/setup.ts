// Runs before every test file: what jsdom lacks of a browser, and an empty localStorage for each test.
import { beforeEach } from "vitest";

Object.assign(globalThis, {
  matchMedia: () => ({ matches: false, addEventListener: () => {} }),
  ResizeObserver: class {
    observe(): void {}
    unobserve(): void {}
    disconnect(): void {}
  },
});

Element.prototype.scrollIntoView = () => {};
Element.prototype.animate = () => ({}) as Animation;
HTMLDialogElement.prototype.showModal = function () {
  this.open = true;
};
HTMLDialogElement.prototype.close = function () {
  if (!this.open) return;
  this.open = false;
  this.dispatchEvent(new Event("close"));
};

beforeEach(() => localStorage.clear());
