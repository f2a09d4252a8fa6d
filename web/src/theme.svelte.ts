// Dark or light: the user's choice, else the system's. app.css uses `data-theme` on the root element.

export type Theme = "auto" | "light" | "dark";

const KEY = "whyroad.theme";
const stored = localStorage.getItem(KEY);
const system = matchMedia("(prefers-color-scheme: dark)");

export const theme = $state<{ choice: Theme; now: "light" | "dark" }>({
  choice: stored === "light" || stored === "dark" ? stored : "auto",
  now: "light",
});

function apply(): void {
  theme.now = theme.choice === "auto" ? (system.matches ? "dark" : "light") : theme.choice;
  document.documentElement.dataset["theme"] = theme.now;
}

export function setTheme(choice: Theme): void {
  theme.choice = choice;
  localStorage.setItem(KEY, choice);
  apply();
}

system.addEventListener("change", apply);
apply();
